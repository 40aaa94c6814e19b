//! The ways to solve, and what an answer may be off by.

use common::mesh::Mesh;
use common::passes;
use common::settings::{Iteration, Meshing, Schedule, Settings, Transport, Visibility};
use common::shooting::{Field, Run, replay};
use glam::{DVec3, Vec3};
use gpu::Fault;
use proptest::prelude::*;
use proptest::test_runner::{RngSeed, TestError, TestRunner};
use radiosity_tests::bounds::U;
use radiosity_tests::cases;
use radiosity_tests::engines::{AnyEngine, KINDS, Kind};
use std::ops::ControlFlow;

/// Every iteration.
pub const ITERATIONS: [Iteration; 3] = [Iteration::Southwell, Iteration::Chebyshev, Iteration::Cg];

/// Few passes, and nothing but sums of positive numbers.
const PLAIN: [Iteration; 1] = [Iteration::Chebyshev];

/// One way to solve.
#[derive(Clone, Copy, Debug)]
pub struct Way {
    pub on_gpu: bool,
    pub samples: u32,
    pub iteration: Iteration,
    pub faults: &'static [Fault],
}

/// Both solvers, one sample and four, each of these iterations.
fn ways(iterations: &[Iteration]) -> Vec<Way> {
    let mut all = Vec::new();
    for on_gpu in [false, true] {
        for samples in [1, 4] {
            all.extend(iterations.iter().map(|iteration| Way {
                on_gpu,
                samples,
                iteration: *iteration,
                faults: &[],
            }));
        }
    }
    all
}

impl Way {
    /// Its settings.
    pub fn settings(&self) -> Settings {
        Settings {
            meshing: Meshing {
                samples: self.samples,
                ..Meshing::default()
            },
            transport: Transport {
                visibility: Visibility::Rays,
                ..Transport::default()
            },
            schedule: Schedule {
                iteration: self.iteration,
                epsilon: self.epsilon(),
                ..Schedule::default()
            },
            ..Settings::default()
        }
    }

    /// What is left unshot, as a share of what is emitted: bounds count what is, so that the iterations
    /// of one cell at a time need not shoot a thousand times.
    fn epsilon(&self) -> f64 {
        match self.iteration {
            Iteration::Southwell => 1e-3,
            _ => 1e-5,
        }
    }

    /// A fresh solver.
    pub fn engine<'m>(&self, mesh: &'m Mesh) -> AnyEngine<'m> {
        let by_rays =
            |kind: &&Kind| kind.on_gpu == self.on_gpu && kind.visibility == Visibility::Rays;
        let kind = KINDS.iter().find(by_rays).unwrap();
        kind.engine(mesh, &self.settings(), self.faults)
    }

    /// A solve to its ε.
    pub fn solve(&self, mesh: &Mesh) -> Run {
        let settings = self.settings();
        passes::solve(
            self.engine(mesh).as_mut(),
            mesh,
            &settings.schedule,
            &mut |_| ControlFlow::Continue(()),
        )
        .unwrap()
    }

    /// These cells shoot, one after the other.
    pub fn replay(&self, mesh: &Mesh, log: &[u32]) -> Run {
        replay(self.engine(mesh).as_mut(), log).unwrap()
    }

    /// The links of all cells: a row of all texels for each.
    pub fn links(&self, mesh: &Mesh) -> Vec<Vec<f32>> {
        let mut engine = self.engine(mesh);
        let row = |cell| {
            engine.shoot(cell).unwrap();
            let field = engine.field().unwrap();
            field.irradiance.iter().map(|h| h.w).collect()
        };
        (0..mesh.cells.len() as u32).map(row).collect()
    }
}

/// `property` on `count` draws of `strategy`, other ones for each way.
fn each<S: Strategy>(
    ways: &[Way],
    count: u32,
    strategy: &S,
    property: impl Fn(Way, S::Value) -> Result<(), TestCaseError>,
) {
    for (k, way) in (0..).zip(ways) {
        let mut config = cases(count);
        if let RngSeed::Fixed(seed) = config.rng_seed {
            config.rng_seed = RngSeed::Fixed(seed + k);
        }
        // A scene says more than the least that fails.
        config.max_shrink_iters = 0;
        let mut runner = TestRunner::new(config);
        match runner.run(strategy, |scene| property(*way, scene)) {
            Ok(()) => {}
            Err(TestError::Fail(reason, scene)) => panic!("{way:?}: {reason}\n{scene:?}"),
            Err(error) => panic!("{way:?}: {error}"),
        }
    }
}

/// Of both solvers, with one sample and many, by every iteration.
pub fn every_way<S: Strategy>(
    count: u32,
    strategy: &S,
    property: impl Fn(Way, S::Value) -> Result<(), TestCaseError>,
) {
    each(&ways(&ITERATIONS), count, strategy, property);
}

/// Of both solvers, with one sample and many; for what no iteration changes.
pub fn every_engine<S: Strategy>(
    count: u32,
    strategy: &S,
    property: impl Fn(Way, S::Value) -> Result<(), TestCaseError>,
) {
    each(&ways(&PLAIN), count, strategy, property);
}

/// Every cell's number.
pub fn all(mesh: &Mesh) -> Vec<u32> {
    (0..mesh.cells.len() as u32).collect()
}

/// ΣA|a − b| over texels and channels, scene units; `pairs` says which texel of `b` each of `a` is.
pub fn apart(mesh: &Mesh, a: &Field, b: &Field, pairs: impl Fn(usize) -> usize) -> f64 {
    let texels = mesh.texels.iter().zip(&a.radiosity).enumerate();
    let each = texels.map(|(k, (texel, value))| {
        let other = b.radiosity[pairs(k)].truncate().as_dvec3();
        f64::from(texel.area) * (value.truncate().as_dvec3() - other).abs().element_sum()
    });
    each.sum::<f64>() * mesh.area_unit()
}

/// ΣA|r|, scene units.
pub fn unshot(mesh: &Mesh, field: &Field) -> f64 {
    let texels = mesh.texels.iter().zip(&field.residual);
    let each = texels.map(|(texel, r)| f64::from(texel.area) * sum(r.truncate().abs()));
    each.sum::<f64>() * mesh.area_unit()
}

/// Over the channels.
pub fn sum(v: Vec3) -> f64 {
    v.as_dvec3().element_sum()
}

/// How much all later reflections add, at most, to what is wrong once: with the largest reflectance ρ
/// and the largest sum c of a cell's links, 1/(1 − ρc). Infinite where the discrete equations make
/// light.
pub fn gain(mesh: &Mesh, links: &[Vec<f32>]) -> f64 {
    let rho = largest_reflectance(mesh);
    let closure = mesh.cells.iter().zip(links).map(|(cell, row)| {
        let taken = mesh.texels.iter().zip(row);
        let sum: f64 = taken.map(|(t, w)| f64::from(t.area) * f64::from(*w)).sum();
        sum / f64::from(cell.shooter.area)
    });
    let product = rho * closure.fold(0.0, f64::max);
    if product < 1.0 {
        1.0 / (1.0 - product)
    } else {
        f64::INFINITY
    }
}

/// The largest of all texels and channels.
pub fn largest_reflectance(mesh: &Mesh) -> f64 {
    let each = mesh.texels.iter().map(|t| t.reflectance.max_element());
    f64::from(each.fold(0.0, f32::max))
}

/// ΣA|B − B'| of two solves of the same equations: what either left unshot would be reflected, and
/// reflected on; and each sum is rounded by 4u at each shot, or pass of all cells.
pub fn left(mesh: &Mesh, gain: f64, runs: &[&Run]) -> f64 {
    let each = runs.iter().map(|run| {
        let rounding = 4.0 * U * (run.shots.len() + mesh.cells.len()) as f64;
        unshot(mesh, &run.field) + rounding * total(mesh, &run.field)
    });
    gain * each.sum::<f64>()
}

/// ΣA|B|, scene units.
pub fn total(mesh: &Mesh, field: &Field) -> f64 {
    let texels = mesh.texels.iter().zip(&field.radiosity);
    let each = texels.map(|(texel, b)| f64::from(texel.area) * sum(b.truncate().abs()));
    each.sum::<f64>() * mesh.area_unit()
}

/// A cell's outline, mesh units; a triangle's has three corners.
pub fn outline(mesh: &Mesh, cell: usize) -> Vec<DVec3> {
    let c = mesh.cells[cell].shooter.corners.map(|c| c.as_dvec3());
    let count = if c[2] == c[3] { 3 } else { 4 };
    c[..count].to_vec()
}
