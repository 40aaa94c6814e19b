//! Solver setups that properties are checked on, and bounds of the difference between solutions.

use common::mesh::Mesh;
use common::settings::{Iteration, Settings, Visibility};
use common::shooting::{RadiosityField, SolveRun, replay_log};
use glam::{DVec3, Vec4};
use gpu::ShaderFault;
use proptest::prelude::*;
use proptest::test_runner::{RngSeed, TestError, TestRunner};
use radiosity_tests::bounds::U;
use radiosity_tests::engines::{AnyEngine, ENGINE_KINDS, settings_of, solve_by_schedule};
use radiosity_tests::random_cases;

/// All iterations.
pub const ITERATIONS: [Iteration; 3] = [Iteration::Southwell, Iteration::Chebyshev, Iteration::Cg];

/// Device, samples, iteration and planted fault of a solve.
#[derive(Clone, Copy, Debug)]
pub struct SolverSetup {
    pub on_gpu: bool,
    pub samples: u32,
    pub iteration: Iteration,
    pub fault: Option<ShaderFault>,
}

impl SolverSetup {
    /// Returns the settings; texels and patches are the scene's own.
    pub fn settings(&self) -> Settings {
        let mut settings = settings_of([1, 1, self.samples], Visibility::Rays, self.unshot_limit());
        settings.schedule.iteration = self.iteration;
        settings
    }

    /// Returns ε. Bounds include the unshot power, so that single shots may stop early.
    fn unshot_limit(&self) -> f64 {
        match self.iteration {
            Iteration::Southwell => 1e-3,
            _ => 1e-5,
        }
    }

    /// Makes an engine.
    pub fn fresh_engine<'m>(&self, mesh: &'m Mesh) -> AnyEngine<'m> {
        let [cpu_rays, _, _, gpu_rays] = ENGINE_KINDS;
        let kind = if self.on_gpu { gpu_rays } else { cpu_rays };
        kind.fresh_engine(mesh, &self.settings(), self.fault.as_slice())
    }

    /// Solves until the unshot power is below ε.
    pub fn solve_mesh(&self, mesh: &Mesh) -> SolveRun {
        solve_by_schedule(self.fresh_engine(mesh).as_mut(), mesh, &self.settings().schedule)
    }

    /// Replays shots of these patches, one after the other.
    pub fn replay_log(&self, mesh: &Mesh, log: &[u32]) -> SolveRun {
        replay_log(self.fresh_engine(mesh).as_mut(), log).unwrap()
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

/// Checks `property` on both engines, with one sample and four, by each of these iterations, on `count` draws of
/// `strategy` each.
fn check_setups<S: Strategy>(
    iterations: &[Iteration],
    count: u32,
    strategy: &S,
    property: impl Fn(SolverSetup, S::Value) -> Result<(), TestCaseError>,
) {
    let setups = (0..4 * iterations.len()).map(|k| SolverSetup {
        on_gpu: k >= 2 * iterations.len(),
        samples: [1, 4][k / iterations.len() % 2],
        iteration: iterations[k % iterations.len()],
        fault: None,
    });
    for (k, way) in (0..).zip(setups) {
        let mut config = random_cases(count);
        if let RngSeed::Fixed(seed) = config.rng_seed {
            config.rng_seed = RngSeed::Fixed(seed + k);
        }
        // The drawn scene is more useful than a shrunken one.
        config.max_shrink_iters = 0;
        match TestRunner::new(config).run(strategy, |scene| property(way, scene)) {
            Ok(()) => {}
            Err(TestError::Fail(reason, scene)) => panic!("{way:?}: {reason}\n{scene:?}"),
            Err(error) => panic!("{way:?}: {error}"),
        }
    }
}

/// Checks `property` by every iteration.
pub fn check_every_iteration<S: Strategy>(
    count: u32,
    strategy: &S,
    property: impl Fn(SolverSetup, S::Value) -> Result<(), TestCaseError>,
) {
    check_setups(&ITERATIONS, count, strategy, property);
}

/// Checks `property` by an iteration of few passes that adds positive numbers only.
pub fn check_every_engine<S: Strategy>(
    count: u32,
    strategy: &S,
    property: impl Fn(SolverSetup, S::Value) -> Result<(), TestCaseError>,
) {
    check_setups(&[Iteration::Chebyshev], count, strategy, property);
}

/// Returns ΣA|a − b| over texels and channels, scene units; texel k of `a` is texel `pairs(k)` of `b`.
pub fn radiosity_distance(mesh: &Mesh, a: &RadiosityField, b: &RadiosityField, pairs: impl Fn(usize) -> usize) -> f64 {
    let texels = mesh.texels.iter().zip(&a.radiosity).enumerate();
    let each = texels.map(|(k, (texel, value))| {
        let other = b.radiosity[pairs(k)].truncate().as_dvec3();
        f64::from(texel.area) * (value.truncate().as_dvec3() - other).abs().element_sum()
    });
    each.sum::<f64>() * mesh.area_unit()
}

/// Returns ΣA|v| over texels and channels, scene units.
pub fn power_of(mesh: &Mesh, values: &[Vec4]) -> f64 {
    let each = mesh.texels.iter().zip(values).map(|(texel, value)| {
        let sum = value.truncate().abs().as_dvec3().element_sum();
        f64::from(texel.area) * sum
    });
    each.sum::<f64>() * mesh.area_unit()
}

/// Returns a bound of the gain of an error by all later reflections: 1/(1 − ρc) with the largest reflectance ρ and the
/// largest sum c of a patch's links; infinite if ρc ≥ 1.
pub fn reflection_gain(mesh: &Mesh, links: &[Vec<f32>]) -> f64 {
    let reflectances = mesh.texels.iter().map(|t| t.reflectance.max_element());
    let rho = f64::from(reflectances.fold(0.0, f32::max));
    let closure = mesh.patches.iter().zip(links).map(|(patch, row)| {
        let taken = mesh.texels.iter().zip(row);
        let sum: f64 = taken.map(|(t, w)| f64::from(t.area) * f64::from(*w)).sum();
        sum / f64::from(patch.shooter.area)
    });
    let product = rho * closure.fold(0.0, f64::max);
    if product < 1.0 {
        1.0 / (1.0 - product)
    } else {
        f64::INFINITY
    }
}

/// Returns a bound of ΣA|B − B'| of solves of the same equations: their unshot power and all its reflections, and a
/// rounding of 4u at each shot, or pass of all patches.
pub fn remaining_error(mesh: &Mesh, gain: f64, runs: &[&SolveRun]) -> f64 {
    let each = runs.iter().map(|run| {
        let rounding = 4.0 * U * (run.shots.len() + mesh.patches.len()) as f64;
        power_of(mesh, &run.field.residual) + rounding * power_of(mesh, &run.field.radiosity)
    });
    gain * each.sum::<f64>()
}

/// Returns the outline of a patch, mesh units; that of a triangle has three corners.
pub fn patch_outline(mesh: &Mesh, patch: usize) -> Vec<DVec3> {
    let c = mesh.patches[patch].shooter.corners.map(|c| c.as_dvec3());
    let count = if c[2] == c[3] { 3 } else { 4 };
    c[..count].to_vec()
}
