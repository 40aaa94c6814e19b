//! Linearity: the light of two sets of lamps is the sum of the light of each.

use crate::scene::MeshedScene;
use crate::solution::{SceneSolver, Solution, check_tolerance};
use crate::violation::Violation;
use glam::Vec3;

const SUPERPOSITION: &str = "superposition";
const SCALING: &str = "scaling of the emission";
/// Factor of the emission: no power of two, by which all roundings would be the same.
const EMISSION_SCALE: f32 = 3.0;
/// Share of its neighbour's emission that a face of the second scene emits.
const SECOND_EMISSION_SCALE: f32 = 0.75;

/// Checks that the scene with the emission E₁ + E₂ has the sum of the radiosities with E₁ and with E₂, and with 3·E₁ three
/// times that with E₁. E₁ is the scene's emission, and E₂ that of the next face times 0.75. The tolerance is a share of each
/// value: a solver must distribute the light of each channel, be it 10⁻⁶ of another's.
///
/// Errors: a [`Violation`]; [`Violation::Nothing`] if no face emits light.
pub fn check_linearity(solver: &SceneSolver, scene: &MeshedScene, tolerance: f64) -> Result<(), Violation> {
    check_tolerance(SUPERPOSITION, tolerance)?;
    let faces = &scene.scene.faces;
    if faces.iter().all(|face| face.emission == Vec3::ZERO) {
        return Err(Violation::nothing(SUPERPOSITION, "no face emits light"));
    }
    let first = |k: usize| faces[k].emission;
    let second = |k: usize| faces[(k + 1) % faces.len()].emission * SECOND_EMISSION_SCALE;
    let solve = |emission: &dyn Fn(usize) -> Vec3| Solution::new(solver, &scene.with_emission(|k, _| emission(k)));
    let [one, other] = [solve(&first)?, solve(&second)?];
    let sum = |k: usize| one.values[k] + other.values[k];
    let both = solve(&|k| first(k) + second(k))?;
    both.compare(SUPERPOSITION, sum, |k| tolerance * both.values[k])?;
    let scaled = solve(&|k| first(k) * EMISSION_SCALE)?;
    let multiple = |k: usize| one.values[k] * f64::from(EMISSION_SCALE);
    scaled.compare(SCALING, multiple, |k| tolerance * scaled.values[k])
}
