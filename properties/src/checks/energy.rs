//! Energy: the emitted power is absorbed, or it escapes.

use super::escape::escaped_shares;
use crate::scene::MeshedScene;
use crate::solution::{CHANNELS, SceneSolver, Solution, check_tolerance, check_value};
use crate::violation::Violation;
use common::scene::Face;
use glam::{DVec3, Vec3};

const PROPERTY: &str = "energy";
/// Smallest reflectance of the scenes that are solved: what a darker face absorbs cannot be computed from its radiosity.
const MIN_REFLECTANCE: f32 = 0.1;
/// Largest error of an escaped share by 1024 directions: four standard errors of 0.3 %.
const MAX_SHARE_ERROR: f64 = 0.012;

/// Checks that the emitted power ΣAE equals the absorbed ΣA(1 − ρ)H, with H = (B − E)/ρ, and the escaped, in each channel.
/// Reflectances below 0.1 are raised to it. No body may stand on a face.
///
/// ```text
/// |ΣA(1 − ρ)H + ΣABs − ΣAE| ≤ tolerance·ΣAE + 0.012·ΣAB where s > 0
/// ```
/// s is the share of a texel's light that meets no front, by 1024 rays.
///
/// Errors: a [`Violation`].
pub fn check_energy(solver: &SceneSolver, scene: &MeshedScene, tolerance: f64) -> Result<(), Violation> {
    check_tolerance(PROPERTY, tolerance)?;
    let raise = |_, face: &mut Face| face.reflectance = face.reflectance.max(Vec3::splat(MIN_REFLECTANCE));
    let scene = scene.with_faces(raise);
    let solution = Solution::new(solver, &scene)?;
    let [mut emitted, mut absorbed, mut escaped, mut uncertain] = [DVec3::ZERO; 4];
    let shares = escaped_shares(&scene.scene, &solution.mesh);
    for ((texel, radiosity), share) in solution.mesh.texels.iter().zip(&solution.values).zip(shares) {
        let [emission, reflectance] = [texel.emission, texel.reflectance].map(Vec3::as_dvec3);
        let area = f64::from(texel.area) * solution.mesh.area_unit();
        let irradiance = (radiosity - emission) / reflectance;
        emitted += emission * area;
        absorbed += (1.0 - reflectance) * irradiance * area;
        escaped += radiosity * area * share;
        uncertain += if share > 0.0 {
            MAX_SHARE_ERROR * radiosity * area
        } else {
            DVec3::ZERO
        };
    }
    if emitted == DVec3::ZERO {
        return Err(Violation::nothing(PROPERTY, "no face emits light"));
    }
    let (found, bound) = (absorbed + escaped, tolerance * emitted + uncertain);
    (0..3).try_for_each(|c| {
        let place = || format!("absorbed and escaped power, {}", CHANNELS[c]);
        check_value(PROPERTY, place, [found[c], emitted[c]], bound[c])
    })
}
