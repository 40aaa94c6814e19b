//! Closure: the form factors of a texel of a closed scene sum to 1.

use super::escape::escaped_shares;
use crate::scene::MeshedScene;
use crate::solution::{SceneSolver, Solution, check_tolerance};
use crate::violation::Violation;
use glam::{DVec3, Vec3};

const PROPERTY: &str = "closure";
/// Radiosity b of all texels, W/m².
const FURNACE_RADIOSITY: Vec3 = Vec3::new(0.5, 1.0, 3.0);

/// Checks that a closed scene in which each face emits E = (1 − ρ)·b has the radiosity B = b everywhere, whatever its
/// shape: the furnace. A solver whose form factors sum to 1 + δ is off by ρδ/(1 − ρ) of b.
///
/// ```text
/// |B − b| ≤ tolerance·b
/// ```
///
/// Errors: a [`Violation`]; [`Violation::Nothing`] of a scene from which light escapes.
pub fn check_closure(solver: &SceneSolver, scene: &MeshedScene, tolerance: f64) -> Result<(), Violation> {
    check_tolerance(PROPERTY, tolerance)?;
    let furnace = scene.with_emission(|_, face| (Vec3::ONE - face.reflectance) * FURNACE_RADIOSITY);
    let solution = Solution::new(solver, &furnace)?;
    let shares = escaped_shares(&furnace.scene, &solution.mesh);
    if shares.iter().any(|share| *share > 0.0) {
        return Err(Violation::nothing(PROPERTY, "the scene is open"));
    }
    let expected: DVec3 = FURNACE_RADIOSITY.as_dvec3();
    solution.compare(PROPERTY, |_| expected, |_| tolerance * expected)
}
