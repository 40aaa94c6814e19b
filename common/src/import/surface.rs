//! Diffuse reflectance and emitted radiosity of a face, with the limits of their values. The importers of OBJ and glTF
//! materials and of vertex colours check theirs here.

use crate::paint::MAX_WHITE_REFLECTANCE;
use glam::{DVec3, Vec3};

/// Reflectance of a face without a material; the note on such faces states it.
pub const DEFAULT_REFLECTANCE: f32 = 0.7;

/// Smallest and largest emitted radiosity E that can be solved, W/m². The solvers hold in f32, at most 3.4e38, the square
/// of the radiosity E/(1 − ρ) between walls of reflectance ρ ≤ 1 − 2⁻²⁴: (1e12 · 2²⁴)² = 2.8e38. And they hold in f32, as
/// normal numbers from 1.2e-38, the part that a texel receives by form factors F down to 1.2e-26: 1e-12 · F ≥ 1.2e-38.
/// The sun's surface emits 6e7.
const EMISSION_RANGE: [f32; 2] = [1e-12, 1e12];

/// Returns the reflectance ρ of a material, 0 ≤ ρ < 1, and its emitted radiosity E = πL, W/m², from its radiance L.
/// [`MAX_WHITE_REFLECTANCE`] replaces 1, which exporters write for an unset colour and which would absorb no light.
/// `names` are the file's names of both, for messages.
///
/// Errors: a value is negative, not finite or out of range.
pub fn diffuse_surface(reflectance: DVec3, radiance: DVec3, names: [&str; 2]) -> Result<[Vec3; 2], String> {
    let [reflectance_name, radiance_name] = names;
    let rho = reflectance.as_vec3();
    if !(rho.cmpge(Vec3::ZERO) & rho.cmple(Vec3::ONE)).all() {
        return Err(format!(
            "reflectance {reflectance_name} {} must be at least 0 and at most 1 in every channel: \
             scale it down, to 0.9 for instance",
            format_triple(reflectance)
        ));
    }
    let emission = (radiance * std::f64::consts::PI).as_vec3();
    if !(emission.cmpge(Vec3::ZERO).all() && emission.is_finite()) {
        return Err(format!(
            "emitted radiance {radiance_name} {} must be at least 0 and finite in every channel",
            format_triple(radiance)
        ));
    }
    let [min_emission, max_emission] = EMISSION_RANGE;
    if !is_solvable_emission(emission) {
        return Err(format!(
            "emitted radiance {radiance_name} {} cannot be solved: its largest channel must be 0 \
             or between {:.0e} and {:.0e}; use another unit",
            format_triple(radiance),
            min_emission / std::f32::consts::PI,
            max_emission / std::f32::consts::PI,
        ));
    }
    let white = Vec3::splat(MAX_WHITE_REFLECTANCE);
    Ok([Vec3::select(rho.cmpeq(Vec3::ONE), white, rho), emission])
}

/// Returns whether an emitted radiosity is at least 0, and its largest channel 0 or within the range that can be solved.
pub(crate) fn is_solvable_emission(emission: Vec3) -> bool {
    let [min_emission, max_emission] = EMISSION_RANGE;
    let largest = emission.max_element();
    emission.cmpge(Vec3::ZERO).all() && (largest == 0.0 || (min_emission..=max_emission).contains(&largest))
}

fn format_triple(v: DVec3) -> String {
    format!("{} {} {}", v.x, v.y, v.z)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grey_surface(rho: f64, radiance: f64) -> Result<[Vec3; 2], String> {
        let [rho, radiance] = [DVec3::new(0.5, rho, 0.5), DVec3::new(0.0, radiance, 0.0)];
        diffuse_surface(rho, radiance, ["Kd", "Ke"])
    }

    #[test]
    fn values_in_range_are_taken_and_others_refused() {
        let taken = |rho, radiance| grey_surface(rho, radiance).map(|[rho, emission]| [rho.y, emission.y]);
        for (rho, as_much) in [(0.0, 0.0), (0.95, 0.95), (0.999, 0.999), (1.0, 0.95)] {
            assert_eq!(taken(rho, 1.0), Ok([as_much, std::f32::consts::PI]), "{rho}");
        }
        for radiance in [0.0, 1e-11, 1e11] {
            assert!(taken(0.5, radiance).is_ok(), "{radiance}");
        }
        for rho in [1.000_001, 1.5, -0.1, f64::NAN, f64::INFINITY] {
            assert!(
                taken(rho, 0.0).is_err_and(|message| message.contains("Kd 0.5")),
                "{rho}"
            );
        }
        for radiance in [-1.0, f64::NAN, f64::INFINITY, 1e39] {
            assert!(
                taken(0.5, radiance).is_err_and(|message| message.contains("Ke 0")),
                "{radiance}"
            );
        }
        for radiance in [1e38, 1e12, 1e-13, 1e-40] {
            assert!(
                taken(0.5, radiance).is_err_and(|message| message.contains("another unit")),
                "{radiance}"
            );
        }
    }
}
