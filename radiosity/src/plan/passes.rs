//! Estimates passes and shots of a solve.
//!
//! Both hardly depend on the number of texels, so they are counted in a small solve on few texels: passes stay the
//! same, shots grow with the patches. If even that has too many links, the largest reflectance ρ bounds them
//! (n patches):
//!
//! ```text
//! Southwell: n ln(1/ε)/(1 − ρ)    Chebyshev, CG: ln(2/ε)/ln(1/σ), σ = ρ/(1 + √(1 − ρ²))
//! ```

use super::SceneCounts;
use common::Result;
use common::paint::MAX_WHITE_REFLECTANCE;
use common::scene::Scene;
use common::settings::{Iteration, Meshing, Settings, Transport, Visibility};
use oracle::solve::progress::without_progress;
use oracle::solve::solved::Solved;
use oracle::solve::solver::SolverChoice;
use oracle::solve::task::SolveTask;

/// Largest number of links of the small solve: some tenths of a second.
const MAX_SMALL_LINKS: u64 = 1 << 22;
/// Smallest and largest side of its texels.
const SMALL_SOLVE_TEXELS: [u32; 2] = [2, 4];

/// Expected passes and shots.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExpectedPasses {
    /// Passes over the patches.
    pub passes: f64,
    /// Shots: the sum of shooters over the passes.
    pub shots: f64,
    /// Patches that shoot at least once.
    pub linked: f64,
    /// Texels per side in the small solve; none: the figures are bounds.
    pub small_side: Option<u32>,
}

/// Estimates passes and shots of `settings` on `scene`.
pub fn estimate_passes(scene: &Scene, settings: &Settings) -> Result<ExpectedPasses> {
    let counts = SceneCounts::new(scene, &settings.meshing);
    match small_settings(scene, settings) {
        Some(small) => scale_small_solve(scene, &small, settings.schedule.iteration, &counts),
        None => Ok(bound_passes(scene, settings, &counts)),
    }
}

/// Returns the settings of the small solve: the finest patches within [`MAX_SMALL_LINKS`], centre to centre, by rays; none
/// if even whole faces have more.
fn small_settings(scene: &Scene, settings: &Settings) -> Option<Settings> {
    let with = |patches: u32| Settings {
        meshing: Meshing {
            patches,
            texels: patches
                .clamp(SMALL_SOLVE_TEXELS[0], SMALL_SOLVE_TEXELS[1])
                .min(settings.meshing.texels),
            samples: 1,
        },
        transport: Transport {
            visibility: Visibility::Rays,
            ..settings.transport
        },
        ..*settings
    };
    let fewer = (1..=settings.meshing.patches.min(SMALL_SOLVE_TEXELS[1]))
        .rev()
        .map(with);
    let few = |small: &Settings| SceneCounts::new(scene, &small.meshing).link_count() <= MAX_SMALL_LINKS;
    fewer.into_iter().find(few)
}

fn scale_small_solve(
    scene: &Scene,
    small: &Settings,
    iteration: Iteration,
    counts: &SceneCounts,
) -> Result<ExpectedPasses> {
    let Solved { mesh, run, .. } = scene.solve_once(small, SolverChoice::Cpu, &without_progress())?;
    let times = counts.patches as f64 / mesh.patches.len().max(1) as f64;
    let mut linked = vec![false; mesh.patches.len()];
    for shot in &run.shots {
        linked[shot.patch as usize] = true;
    }
    let linked = linked.into_iter().filter(|linked| *linked).count();
    let passes = f64::from(run.passes);
    Ok(ExpectedPasses {
        passes: match iteration {
            Iteration::Southwell => passes * times,
            Iteration::Chebyshev | Iteration::Cg => passes,
        },
        shots: run.shooters as f64 * times,
        linked: linked as f64 * times,
        small_side: Some(small.meshing.texels),
    })
}

fn bound_passes(scene: &Scene, settings: &Settings, counts: &SceneCounts) -> ExpectedPasses {
    // A painted texel may reflect more than its face's mean, up to the whitest paint.
    let largest = scene.faces.iter().map(|f| match f.paint {
        Some(_) => f.reflectance.max_element().max(MAX_WHITE_REFLECTANCE),
        None => f.reflectance.max_element(),
    });
    // At ρ = 0 one pass suffices; the formulas need ρ > 0.
    let rho = f64::from(largest.fold(0.0, f32::max)).clamp(1e-6, 0.9999);
    let (patches, fall) = (counts.patches as f64, (1.0 / settings.schedule.epsilon).ln());
    let single = patches * fall / (1.0 - rho);
    let (passes, shots) = match settings.schedule.iteration {
        Iteration::Southwell => (single, single),
        Iteration::Chebyshev | Iteration::Cg => {
            let sigma = rho / (1.0 + (1.0 - rho * rho).sqrt());
            let passes = (2.0 / settings.schedule.epsilon).ln() / (1.0 / sigma).ln();
            let passes = passes.max(1.0).ceil();
            (passes, passes * patches)
        }
    };
    ExpectedPasses {
        passes,
        shots,
        linked: patches,
        small_side: None,
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
        let at = |h: f64| [(0., 0.), (0., 1.), (1., 1.), (1., 0.)].map(|(x, z)| DVec3::new(x, h, z));
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
            let counts = SceneCounts::new(&plates(), &settings.meshing);
            let bound = bound_passes(&plates(), &settings, &counts);
            let told = estimate_passes(&plates(), &settings).unwrap();
            assert!(told.small_side.is_some());
            assert!(told.passes <= bound.passes, "{iteration:?}: {told:?} {bound:?}");
            assert!(told.shots <= bound.shots, "{iteration:?}: {told:?} {bound:?}");
        }
    }

    #[test]
    fn what_is_too_large_even_for_a_small_solve_is_bounded() {
        let mut scene = plates();
        let faces = scene.faces.clone();
        scene.faces = (0..1200).flat_map(|_| faces.clone()).collect();
        assert_eq!(estimate_passes(&scene, &Settings::default()).unwrap().small_side, None);
    }
}
