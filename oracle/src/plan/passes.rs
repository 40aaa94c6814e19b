//! How many passes and shots a solve will take.
//!
//! Both hardly depend on the texels, so a solve on few of them shows it: passes stay the same, shots
//! grow with the cells. Where even that is too much, the largest reflectance ρ bounds them (n cells):
//!
//! ```text
//! Southwell: n ln(1/ε)/(1 − ρ)    Chebyshev, CG: ln(2/ε)/ln(1/σ), σ = ρ/(1 + √(1 − ρ²))
//! ```

use super::Counts;
use crate::solve::solved::Solved;
use crate::solve::solver::Solver;
use crate::solve::task::Task;
use crate::solve::watch::unwatched;
use common::Result;
use common::paint::WHITEST;
use common::scene::Scene;
use common::settings::{Iteration, Meshing, Settings, Transport, Visibility};

/// Links of the small solve: some tenths of a second.
const MOST_LINKS: u64 = 1 << 22;
/// Its texels a side at least, and at most.
const TEXELS: [u32; 2] = [2, 4];

/// What is expected.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Expected {
    /// Passes over the cells.
    pub passes: f64,
    /// Shots: shooters, added over the passes.
    pub shots: f64,
    /// Cells that shoot at all.
    pub linked: f64,
    /// The side of the small solve's texels; none: these are bounds.
    pub from: Option<u32>,
}

/// For `settings` on `scene`.
pub fn expected(scene: &Scene, settings: &Settings) -> Result<Expected> {
    let counts = Counts::new(scene, &settings.meshing);
    match small(scene, settings) {
        Some(small) => scaled(scene, &small, settings.schedule.iteration, &counts),
        None => Ok(bound(scene, settings, &counts)),
    }
}

/// The finest cells that make few enough links; centres only, by rays.
fn small(scene: &Scene, settings: &Settings) -> Option<Settings> {
    let with = |cells: u32| Settings {
        meshing: Meshing {
            cells,
            texels: cells
                .clamp(TEXELS[0], TEXELS[1])
                .min(settings.meshing.texels),
            samples: 1,
        },
        transport: Transport {
            visibility: Visibility::Rays,
            ..settings.transport
        },
        ..*settings
    };
    let fewer = (1..=settings.meshing.cells.min(TEXELS[1])).rev().map(with);
    let few = |small: &Settings| Counts::new(scene, &small.meshing).links() <= MOST_LINKS;
    fewer.into_iter().find(few)
}

fn scaled(
    scene: &Scene,
    small: &Settings,
    iteration: Iteration,
    counts: &Counts,
) -> Result<Expected> {
    let Solved { mesh, run, .. } = scene.once(small, Solver::Cpu, &unwatched())?;
    let times = counts.cells as f64 / mesh.cells.len().max(1) as f64;
    let mut linked = vec![false; mesh.cells.len()];
    for shot in &run.shots {
        linked[shot.cell as usize] = true;
    }
    let linked = linked.into_iter().filter(|linked| *linked).count();
    let passes = f64::from(run.passes);
    Ok(Expected {
        passes: match iteration {
            Iteration::Southwell => passes * times,
            Iteration::Chebyshev | Iteration::Cg => passes,
        },
        shots: run.shooters as f64 * times,
        linked: linked as f64 * times,
        from: Some(small.meshing.texels),
    })
}

fn bound(scene: &Scene, settings: &Settings, counts: &Counts) -> Expected {
    // A texel may reflect more than its face in the mean, and no more than what is white.
    let largest = scene.faces.iter().map(|f| match f.paint {
        Some(_) => f.reflectance.max_element().max(WHITEST),
        None => f.reflectance.max_element(),
    });
    // At ρ = 0 one pass is all; the formulas need a little.
    let rho = f64::from(largest.fold(0.0, f32::max)).clamp(1e-6, 0.9999);
    let (cells, fall) = (counts.cells as f64, (1.0 / settings.schedule.epsilon).ln());
    let single = cells * fall / (1.0 - rho);
    let (passes, shots) = match settings.schedule.iteration {
        Iteration::Southwell => (single, single),
        Iteration::Chebyshev | Iteration::Cg => {
            let sigma = rho / (1.0 + (1.0 - rho * rho).sqrt());
            let passes = (2.0 / settings.schedule.epsilon).ln() / (1.0 / sigma).ln();
            let passes = passes.max(1.0).ceil();
            (passes, passes * cells)
        }
    };
    Expected {
        passes,
        shots,
        linked: cells,
        from: None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use common::scene::Face;
    use common::settings::Schedule;
    use glam::{DVec3, Vec3};

    /// Two unit squares that face each other.
    fn plates() -> Scene {
        let at =
            |h: f64| [(0., 0.), (0., 1.), (1., 1.), (1., 0.)].map(|(x, z)| DVec3::new(x, h, z));
        let floor = Face::quad("floor", at(0.0), Vec3::ZERO, Vec3::splat(0.8));
        let lamp = Face::quad("lamp", at(1.0), Vec3::ONE, Vec3::splat(0.8)).reversed();
        Scene {
            name: "plates".into(),
            faces: vec![floor, lamp],
            notes: Vec::new(),
        }
    }

    #[test]
    fn the_bounds_hold() {
        use Iteration::{Cg, Chebyshev, Southwell};
        for iteration in [Southwell, Chebyshev, Cg] {
            let settings = Settings {
                meshing: Meshing {
                    texels: 8,
                    ..Meshing::default()
                },
                schedule: Schedule {
                    iteration,
                    epsilon: 1e-4,
                    ..Schedule::default()
                },
                ..Settings::default()
            };
            let counts = Counts::new(&plates(), &settings.meshing);
            let bound = bound(&plates(), &settings, &counts);
            let told = expected(&plates(), &settings).unwrap();
            assert!(told.from.is_some());
            assert!(
                told.passes <= bound.passes,
                "{iteration:?}: {told:?} {bound:?}"
            );
            assert!(
                told.shots <= bound.shots,
                "{iteration:?}: {told:?} {bound:?}"
            );
        }
    }

    #[test]
    fn what_is_too_large_even_for_a_small_solve_is_bounded() {
        let mut scene = plates();
        let faces = scene.faces.clone();
        scene.faces = (0..1200).flat_map(|_| faces.clone()).collect();
        assert_eq!(expected(&scene, &Settings::default()).unwrap().from, None);
    }
}
