//! From light to what a display shows: the one place that bends it.
//!
//! ```text
//! linear     y = x, clipped
//! reinhard   L' = L (1 + L/W²) / (1 + L), colours keep their ratios       (Reinhard et al. 2002, eq. 4)
//! filmic     y = x up to S, then 1 − (1 − S) e^(−(x − S)/(1 − S))         (Uchimura 2017, without a toe)
//! ```
//! x is 1 where linear white is. The photographic operator begins with middle grey where the linear curve has
//! it; Uchimura's shoulder leaves all below it as it is, goes on with the same slope and never burns out.

use glam::Vec3;

/// How light becomes what a display shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Curve {
    /// As it is, clipped at white.
    #[default]
    Linear,
    /// Reinhard's photographic operator.
    Reinhard,
    /// Linear with Uchimura's shoulder.
    Filmic,
}

/// Reinhard's W, of linear white: what is so bright is white.
const WHITEST: f32 = 8.0;
/// Middle grey.
const GREY: f32 = 0.18;
/// Uchimura's S = m + l₀: where the shoulder begins, with his m = 0.22 and l = 0.4.
pub(crate) const SHOULDER: f32 = 0.532;

impl Curve {
    /// Light over white, as a linear display shows it, 0…1.
    pub fn display(self, light: Vec3) -> Vec3 {
        let light = light.max(Vec3::ZERO);
        let shown = match self {
            Self::Linear => light,
            Self::Reinhard => light * photographic(luminance(light)),
            Self::Filmic => light.map(shoulder),
        };
        shown.min(Vec3::ONE)
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Linear => "linear",
            Self::Reinhard => "reinhard",
            Self::Filmic => "filmic",
        }
    }
}

/// What Reinhard's operator multiplies light of a luminance by.
fn photographic(luminance: f32) -> f32 {
    let of = |l: f32| (1.0 + l / (WHITEST * WHITEST)) / (1.0 + l);
    // Solved for what becomes middle grey, but for W.
    let scale = 1.0 / (1.0 - GREY);
    scale * of(scale * luminance.min(f32::MAX / 2.0))
}

fn shoulder(x: f32) -> f32 {
    if x <= SHOULDER {
        return x;
    }
    let left = 1.0 - SHOULDER;
    1.0 - left * (-(x - SHOULDER) / left).exp()
}

/// Luminance of linear Rec. 709.
pub fn luminance(linear: Vec3) -> f32 {
    linear.dot(Vec3::new(0.2126, 0.7152, 0.0722))
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [Curve; 3] = [Curve::Linear, Curve::Reinhard, Curve::Filmic];

    #[test]
    fn every_curve_rises_and_keeps_middle_grey() {
        for curve in ALL {
            let at = |x: f32| curve.display(Vec3::splat(x));
            assert_eq!([at(0.0), at(-1.0)], [Vec3::ZERO; 2]);
            assert!((at(GREY).x - GREY).abs() < 1e-3, "{curve:?} {}", at(GREY));
            let steps = (0..1000).map(|k| at(k as f32 * 0.01).x);
            let steps: Vec<f32> = steps.collect();
            assert!(steps.is_sorted(), "{curve:?}");
            assert!(at(f32::MAX).is_finite() && at(f32::INFINITY).max_element() <= 1.0);
        }
    }

    #[test]
    fn only_the_linear_curve_burns_out() {
        let apart = |curve: Curve| {
            let at = |x: f32| curve.display(Vec3::splat(x)).x;
            at(2.0) - at(1.2)
        };
        assert_eq!(apart(Curve::Linear), 0.0);
        assert!(apart(Curve::Reinhard) > 0.05 && apart(Curve::Filmic) > 0.05);
        // The shoulder begins with the slope of what is below.
        let filmic = |x: f32| Curve::Filmic.display(Vec3::splat(x)).x;
        assert_eq!(filmic(0.5), 0.5);
        assert!((filmic(SHOULDER + 1e-3) - SHOULDER - 1e-3).abs() < 1e-5);
    }

    #[test]
    fn reinhard_keeps_colours() {
        let colour = Vec3::new(0.5, 0.25, 0.1);
        let shown = Curve::Reinhard.display(colour);
        assert!((shown / colour - Vec3::splat(shown.x / 0.5)).length() < 1e-6);
    }
}
