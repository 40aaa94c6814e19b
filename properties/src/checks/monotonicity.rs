//! Monotonicity: more emission and more reflectance darken nothing.

use crate::scene::MeshedScene;
use crate::solution::{SceneSolver, Solution, check_tolerance};
use crate::violation::Violation;
use glam::Vec3;

const PROPERTY: &str = "monotonicity";
/// Emission that is added at least, W/m².
const MIN_ADDED_EMISSION: Vec3 = Vec3::splat(0.25);
/// Reflectance towards which a darker one is raised, half of the way.
const BRIGHT_REFLECTANCE: Vec3 = Vec3::splat(0.85);

/// Returns the scene with more emission of one face and more reflectance of another.
fn brighten_scene(scene: &MeshedScene, at: usize) -> MeshedScene {
    let faces = &scene.scene.faces;
    let n = faces.len();
    let most = faces.iter().fold(Vec3::ZERO, |most, face| most.max(face.emission));
    scene.with_faces(|k, face| {
        if k == at % n {
            face.emission += most * 0.5 + MIN_ADDED_EMISSION;
        }
        if k == (at / 7) % n {
            face.reflectance += (BRIGHT_REFLECTANCE - face.reflectance).max(Vec3::ZERO) * 0.5;
        }
    })
}

/// Checks that no texel is darker after one face emits more and one reflects more, chosen by `at`. The tolerance is a share
/// of each value: 0 for solvers in which the same numbers are added in the same order.
///
/// Errors: a [`Violation`].
pub fn check_monotonicity(
    solver: &SceneSolver,
    scene: &MeshedScene,
    at: usize,
    tolerance: f64,
) -> Result<(), Violation> {
    check_tolerance(PROPERTY, tolerance)?;
    let less = Solution::new(solver, scene)?;
    let more = Solution::new(solver, &brighten_scene(scene, at))?;
    let lower_limit = |k: usize| more.values[k].max(less.values[k]);
    more.compare(PROPERTY, lower_limit, |k| tolerance * less.values[k])
}
