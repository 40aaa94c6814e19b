//! What a material becomes: diffuse reflectance and emitted radiosity.

use crate::paint::WHITEST;
use glam::{DVec3, Vec3};

/// Reflectance of a face without a material.
pub const DEFAULT_REFLECTANCE: f32 = 0.7;

/// Emitted radiosities that are solved, W/m²: f32 holds the square of the power of a million such
/// faces between walls that reflect it a million times, and the part of it that one texel of many
/// receives. The sun's surface has 6e7.
const EMISSIONS: [f32; 2] = [1e-12, 1e12];

/// Reflectance ρ and emitted radiosity E = πL, W/m², per channel of linear Rec. 709.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface {
    /// 0 ≤ ρ < 1.
    pub reflectance: Vec3,
    /// 0 ≤ E < ∞.
    pub emission: Vec3,
}

impl Surface {
    /// For faces without a material.
    pub const DEFAULT: Self = Self {
        reflectance: Vec3::splat(DEFAULT_REFLECTANCE),
        emission: Vec3::ZERO,
    };

    /// From a material's reflectance, [`WHITEST`] in place of 1, and radiance L; `names` is what the file
    /// calls them. The error says which of them cannot be used.
    pub fn new(reflectance: DVec3, radiance: DVec3, names: [&str; 2]) -> Result<Self, String> {
        let [reflectance_name, radiance_name] = names;
        let rho = reflectance.as_vec3();
        if !(rho.cmpge(Vec3::ZERO) & rho.cmple(Vec3::ONE)).all() {
            return Err(format!(
                "reflectance {reflectance_name} {} must be at least 0 and at most 1 in every channel: \
                 scale it down, to 0.9 for instance",
                triple(reflectance)
            ));
        }
        let emission = (radiance * std::f64::consts::PI).as_vec3();
        if !(emission.cmpge(Vec3::ZERO).all() && emission.is_finite()) {
            return Err(format!(
                "emitted radiance {radiance_name} {} must be at least 0 and finite in every channel",
                triple(radiance)
            ));
        }
        let [least, most] = EMISSIONS;
        let largest = emission.max_element();
        if largest > most || (largest > 0.0 && largest < least) {
            return Err(format!(
                "emitted radiance {radiance_name} {} cannot be solved: its largest channel must be 0 \
                 or between {:.0e} and {:.0e}; use another unit",
                triple(radiance),
                least / std::f32::consts::PI,
                most / std::f32::consts::PI,
            ));
        }
        Ok(Self {
            reflectance: Vec3::select(rho.cmpeq(Vec3::ONE), Vec3::splat(WHITEST), rho),
            emission,
        })
    }
}

fn triple(v: DVec3) -> String {
    format!("{} {} {}", v.x, v.y, v.z)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn with(rho: f64, radiance: f64) -> Result<Surface, String> {
        Surface::new(
            DVec3::new(0.5, rho, 0.5),
            DVec3::new(0.0, radiance, 0.0),
            ["Kd", "Ke"],
        )
    }

    #[test]
    fn emission_is_pi_times_radiance() {
        let emission = with(0.5, 1.0).map(|s| s.emission);
        assert_eq!(emission, Ok(Vec3::new(0.0, std::f32::consts::PI, 0.0)));
    }

    #[test]
    fn nothing_reflects_all_light() {
        let taken = |rho| with(rho, 0.0).map(|surface| surface.reflectance.y);
        for (rho, as_much) in [(0.0, 0.0), (0.95, 0.95), (0.999, 0.999), (1.0, 0.95)] {
            assert_eq!(taken(rho), Ok(as_much), "{rho}");
        }
        for rho in [1.000_001, 1.5, -0.1, f64::NAN, f64::INFINITY] {
            assert!(with(rho, 0.0).is_err_and(|e| e.contains("Kd 0.5")), "{rho}");
        }
    }

    #[test]
    fn what_f32_cannot_sum_is_refused() {
        for radiance in [1e38, 1e12, 1e-13, 1e-40] {
            let told = with(0.5, radiance).unwrap_err();
            assert!(told.contains("Ke 0") && told.contains("unit"), "{told}");
        }
        for radiance in [0.0, 1e-11, 1e11] {
            assert!(with(0.5, radiance).is_ok(), "{radiance}");
        }
    }

    #[test]
    fn emission_is_finite() {
        for radiance in [-1.0, f64::NAN, f64::INFINITY, 1e39] {
            assert!(
                with(0.5, radiance).is_err_and(|e| e.contains("Ke 0")),
                "{radiance}"
            );
        }
    }
}
