//! Solver setups that properties are checked on.

use common::cover;
use common::mesh::Mesh;
use common::polygon::distinct_corners;
use common::settings::Visibility;
use common::shooting::replay_log;
use glam::{DVec3, Vec3};
use properties::Violation;
use proptest::prelude::*;
use proptest::test_runner::{RngSeed, TestError, TestRunner};
use radiosity_tests::engines::{AnyEngine, ENGINE_KINDS, all_patches, settings_of};
use radiosity_tests::random_cases;

/// Device and samples of a solve.
#[derive(Clone, Copy, Debug)]
pub struct SolverSetup {
    pub on_gpu: bool,
    pub samples: u32,
}

/// Light of all texels after some shots, W/m².
pub struct TexelLight {
    pub radiosity: Vec<Vec3>,
    pub irradiance: Vec<Vec3>,
}

impl SolverSetup {
    fn fresh_engine<'m>(&self, mesh: &'m Mesh) -> AnyEngine<'m> {
        let [cpu_rays, _, _, gpu_rays] = ENGINE_KINDS;
        let kind = if self.on_gpu { gpu_rays } else { cpu_rays };
        // Texels and patches are the scene's own.
        kind.fresh_engine(mesh, &settings_of([1, 1, self.samples], Visibility::Rays, 1.0), &[])
    }

    /// Shoots from all patches so many times, in the order of their places, which does not depend on their numbering.
    pub fn shoot_rounds(&self, mesh: &Mesh, rounds: usize) -> TexelLight {
        let mut mesh = mesh.clone();
        cover::sample_covers(&mut mesh, self.samples);
        let place = |patch: &u32| {
            let shooter = &mesh.patches[*patch as usize].shooter;
            [shooter.centre, shooter.normal].map(|v| v.to_array().map(f32::to_bits))
        };
        let mut log = all_patches(&mesh);
        log.sort_by_key(place);
        let run = replay_log(self.fresh_engine(&mesh).as_mut(), &log.repeat(rounds)).unwrap();
        let [radiosity, irradiance] =
            [run.field.radiosity, run.field.irradiance].map(|values| values.iter().map(|v| v.truncate()).collect());
        TexelLight { radiosity, irradiance }
    }

    /// Returns the links of all patches: a row of all texels for each.
    pub fn link_rows(&self, mesh: &Mesh) -> Vec<Vec<f32>> {
        let mut engine = self.fresh_engine(mesh);
        let row = |patch| {
            engine.shoot(patch).unwrap();
            let field = engine.read_field().unwrap();
            field.irradiance.iter().map(|h| h.w).collect()
        };
        (0..mesh.patches.len() as u32).map(row).collect()
    }
}

/// Checks `property` on both engines, with one sample and four, on `count` draws of `strategy` each.
pub fn check_every_engine<S: Strategy>(
    count: u32,
    strategy: &S,
    property: impl Fn(SolverSetup, S::Value) -> Result<(), TestCaseError>,
) {
    let setups = [(false, 1), (false, 4), (true, 1), (true, 4)];
    for (k, (on_gpu, samples)) in (0..).zip(setups) {
        let setup = SolverSetup { on_gpu, samples };
        let mut config = random_cases(count);
        if let RngSeed::Fixed(seed) = config.rng_seed {
            config.rng_seed = RngSeed::Fixed(seed + k);
        }
        // The drawn scene is more useful than a shrunken one.
        config.max_shrink_iters = 0;
        match TestRunner::new(config).run(strategy, |scene| property(setup, scene)) {
            Ok(()) => {}
            Err(TestError::Fail(reason, scene)) => panic!("{setup:?}: {reason}\n{scene:?}"),
            Err(error) => panic!("{setup:?}: {error}"),
        }
    }
}

/// Passes over irradiance that is 0 everywhere: a lamp may face no other face.
pub fn allow_dark(checked: Result<(), Violation>) -> Result<(), Violation> {
    match checked {
        Err(Violation::Dark) => Ok(()),
        checked => checked,
    }
}

/// Returns the outline of a patch, mesh units; that of a triangle has three corners.
pub fn patch_outline(mesh: &Mesh, patch: usize) -> Vec<DVec3> {
    distinct_corners(&mesh.patches[patch].shooter.corners.map(|c| c.as_dvec3())).to_vec()
}
