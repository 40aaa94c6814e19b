//! Reciprocity: A_i F_ij = A_j F_ji, of single exchanges and of all bounces together.

use crate::scene::MeshedScene;
use crate::solution::{CHANNELS, SceneSolver, Solution, check_tolerance, check_value};
use crate::violation::Violation;
use glam::{DVec3, Vec3};

const PROPERTY: &str = "reciprocity";
/// Smallest reflectance of the two faces: their irradiance is computed from their radiosity.
const MIN_REFLECTANCE: f32 = 0.5;

/// Checks that face j receives from face i, by all ways, the power that i receives from j, if each in turn is the only lamp
/// and emits 1 W/m². The received power is ΣA·B/ρ over the texels of the receiver; reflectances of the two faces below 0.5
/// are raised to it. The tolerance is a share of the larger power.
///
/// `faces` are two different indices, modulo the number of faces.
///
/// Errors: a [`Violation`]; [`Violation::Nothing`] if they are one face, or no light passes between them.
pub fn check_reciprocity(
    solver: &SceneSolver,
    scene: &MeshedScene,
    faces: [usize; 2],
    tolerance: f64,
) -> Result<(), Violation> {
    check_tolerance(PROPERTY, tolerance)?;
    let [i, j] = faces.map(|face| face % scene.scene.faces.len().max(1));
    if i == j {
        return Err(Violation::nothing(
            PROPERTY,
            format!("face {} is lamp and receiver", i + 1),
        ));
    }
    let received = |lamp: usize, receiver: usize| -> Result<DVec3, Violation> {
        let lit = scene.with_faces(|k, face| {
            face.emission = if k == lamp { Vec3::ONE } else { Vec3::ZERO };
            if k == lamp || k == receiver {
                face.reflectance = face.reflectance.max(Vec3::splat(MIN_REFLECTANCE));
            }
        });
        let solution = Solution::new(solver, &lit)?;
        let texels = solution.mesh.texels.iter().zip(&solution.values);
        let power = texels
            .filter(|(texel, _)| texel.face as usize == receiver)
            .map(|(texel, b)| f64::from(texel.area) * b / texel.reflectance.as_dvec3());
        Ok(power.sum::<DVec3>() * solution.mesh.area_unit())
    };
    let (from_i, from_j) = (received(i, j)?, received(j, i)?);
    if from_i == DVec3::ZERO && from_j == DVec3::ZERO {
        let reason = format!("no light passes between faces {} and {}", i + 1, j + 1);
        return Err(Violation::nothing(PROPERTY, reason));
    }
    let bound = tolerance * from_i.max(from_j);
    (0..3).try_for_each(|c| {
        let place = || format!("power from face {} to face {}, and back, {}", i + 1, j + 1, CHANNELS[c]);
        check_value(PROPERTY, place, [from_i[c], from_j[c]], bound[c])
    })
}
