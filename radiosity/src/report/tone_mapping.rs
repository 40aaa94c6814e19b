//! Tone mapping: from linear light to display values. All pictures use these curves.
//!
//! ```text
//! linear     y = x, clipped
//! reinhard   L' = L (1 + L/W²) / (1 + L), colours keep their ratios       (Reinhard et al. 2002, eq. 4)
//! filmic     y = x up to S, then 1 − (1 − S) e^(−(x − S)/(1 − S))         (Uchimura 2017, without a toe)
//! ```
//! x is 1 at the exposure's white. Reinhard's operator is scaled so that middle grey stays where the linear curve
//! has it. Uchimura's shoulder is linear below S, continues with slope 1 and reaches 1 only in the limit.

use glam::Vec3;

/// Tone mapping curve.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ToneCurve {
    /// Identity, clipped at white.
    #[default]
    Linear,
    /// Reinhard's photographic operator.
    Reinhard,
    /// Linear, then Uchimura's shoulder.
    Filmic,
}

/// Reinhard's W: the luminance that is shown as white, relative to linear white.
const REINHARD_WHITE: f32 = 8.0;
/// Display value of middle grey.
const MIDDLE_GREY: f32 = 0.18;
/// Uchimura's S = m + l₀, the start of the shoulder, for m = 0.22 and l = 0.4.
pub(crate) const SHOULDER_START: f32 = 0.532;

impl ToneCurve {
    /// Maps light, in units of white, to linear display values 0…1.
    pub fn map_light(self, light: Vec3) -> Vec3 {
        let light = light.max(Vec3::ZERO);
        let shown = match self {
            Self::Linear => light,
            Self::Reinhard => light * reinhard_scale(luminance(light)),
            Self::Filmic => light.map(filmic_shoulder),
        };
        shown.min(Vec3::ONE)
    }

    /// Returns the option's spelling.
    pub fn name(self) -> &'static str {
        match self {
            Self::Linear => "linear",
            Self::Reinhard => "reinhard",
            Self::Filmic => "filmic",
        }
    }
}

/// Returns Reinhard's L'/L for a luminance L.
fn reinhard_scale(luminance: f32) -> f32 {
    let of = |l: f32| (1.0 + l / (REINHARD_WHITE * REINHARD_WHITE)) / (1.0 + l);
    // Maps middle grey to itself, W neglected.
    let scale = 1.0 / (1.0 - MIDDLE_GREY);
    scale * of(scale * luminance.min(f32::MAX / 2.0))
}

/// Applies Uchimura's shoulder to one channel.
fn filmic_shoulder(x: f32) -> f32 {
    if x <= SHOULDER_START {
        return x;
    }
    let headroom = 1.0 - SHOULDER_START;
    1.0 - headroom * (-(x - SHOULDER_START) / headroom).exp()
}

/// Returns the luminance of a linear Rec. 709 colour.
pub fn luminance(linear: Vec3) -> f32 {
    linear.dot(Vec3::new(0.2126, 0.7152, 0.0722))
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL_CURVES: [ToneCurve; 3] = [ToneCurve::Linear, ToneCurve::Reinhard, ToneCurve::Filmic];

    #[test]
    fn curves_are_monotonic_and_keep_middle_grey() {
        for curve in ALL_CURVES {
            let at = |x: f32| curve.map_light(Vec3::splat(x));
            assert_eq!([at(0.0), at(-1.0)], [Vec3::ZERO; 2]);
            assert!(
                (at(MIDDLE_GREY).x - MIDDLE_GREY).abs() < 1e-3,
                "{curve:?} {}",
                at(MIDDLE_GREY)
            );
            let steps = (0..1000).map(|k| at(k as f32 * 0.01).x);
            let steps: Vec<f32> = steps.collect();
            assert!(steps.is_sorted(), "{curve:?}");
            assert!(at(f32::MAX).is_finite() && at(f32::INFINITY).max_element() <= 1.0);
        }
    }

    #[test]
    fn only_linear_curve_clips_highlights() {
        let apart = |curve: ToneCurve| {
            let at = |x: f32| curve.map_light(Vec3::splat(x)).x;
            at(2.0) - at(1.2)
        };
        assert_eq!(apart(ToneCurve::Linear), 0.0);
        assert!(apart(ToneCurve::Reinhard) > 0.05 && apart(ToneCurve::Filmic) > 0.05);
        // The shoulder begins with slope 1.
        let filmic = |x: f32| ToneCurve::Filmic.map_light(Vec3::splat(x)).x;
        assert_eq!(filmic(0.5), 0.5);
        assert!((filmic(SHOULDER_START + 1e-3) - SHOULDER_START - 1e-3).abs() < 1e-5);
    }

    #[test]
    fn reinhard_keeps_channel_ratios() {
        let colour = Vec3::new(0.5, 0.25, 0.1);
        let shown = ToneCurve::Reinhard.map_light(colour);
        assert!((shown / colour - Vec3::splat(shown.x / 0.5)).length() < 1e-6);
    }
}
