//! Draws the PNG pictures of pages and of `preview.png`: exposed radiosity, false colours and item buffers.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use common::import::from_srgb;
use glam::Vec3;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};
use rayon::prelude::*;

/// Colour of NaN, magenta, used for nothing else.
pub const NOT_A_NUMBER: [u8; 3] = [255, 0, 255];
/// Share of the surfaces that the usual exposure shows no brighter than `PERCENTILE_DISPLAY_VALUE`.
pub const EXPOSURE_PERCENTILE: f64 = 0.9;
/// Display value of the percentile of an exposure, relative to linear white.
const PERCENTILE_DISPLAY_VALUE: f64 = 0.8;
/// Uchimura's S = m + l₀, the start of the shoulder, for m = 0.22 and l = 0.4.
pub const SHOULDER_START: f32 = 0.532;
/// Diverging colour map in sRGB from negative (blue) through zero (near white) to positive (red): ColorBrewer RdBu.
pub const DIVERGING_COLOURS: [[u8; 3]; 7] = [
    [5, 48, 97],
    [67, 147, 195],
    [171, 210, 229],
    [247, 247, 247],
    [248, 191, 164],
    [214, 96, 77],
    [103, 0, 31],
];

/// 8-bit sRGB picture with alpha, row-major from the upper left.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RgbaPicture {
    /// Pixels per row.
    pub width: u32,
    /// Number of rows.
    pub height: u32,
    /// Four bytes per pixel; alpha is not premultiplied.
    pub rgba: Vec<u8>,
}

impl RgbaPicture {
    /// Builds a picture from the colour of each pixel; none is transparent.
    pub fn from_pixels(width: u32, height: u32, colour: impl Fn(u32, u32) -> Option<[u8; 3]>) -> Self {
        let rgba = (0..height)
            .flat_map(|y| (0..width).map(move |x| (x, y)))
            .flat_map(|(x, y)| colour(x, y).map_or([0; 4], |[r, g, b]| [r, g, b, 255]))
            .collect();
        Self { width, height, rgba }
    }

    /// Encodes a PNG file; empty for a picture without pixels.
    pub fn encode_png(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        let encoder = PngEncoder::new_with_quality(&mut bytes, CompressionType::Fast, FilterType::Adaptive);
        let (w, h) = (self.width, self.height);
        match encoder.write_image(&self.rgba, w, h, ExtendedColorType::Rgba8) {
            Ok(()) => bytes,
            Err(_) => Vec::new(),
        }
    }

    /// Returns the PNG as a data URI for an `img` element.
    pub fn data_uri(&self) -> String {
        png_data_uri(&self.encode_png())
    }
}

/// Returns the bytes of a PNG file as a data URI for an `img` element.
pub fn png_data_uri(png: &[u8]) -> String {
    format!("data:image/png;base64,{}", STANDARD.encode(png))
}

/// Converts linear Rec. 709, 0…1, to 8-bit sRGB (IEC 61966-2-1); NaN becomes magenta.
pub fn encode_srgb(linear: Vec3) -> [u8; 3] {
    if linear.is_nan() {
        return NOT_A_NUMBER;
    }
    linear.to_array().map(|x| {
        let x = x.clamp(0.0, 1.0);
        let y = if x <= 0.003_130_8 {
            12.92 * x
        } else {
            1.055 * x.powf(1.0 / 2.4) - 0.055
        };
        (y * 255.0).round() as u8
    })
}

/// Converts 8-bit sRGB to linear Rec. 709, the inverse of [`encode_srgb`].
pub fn decode_srgb(srgb: [u8; 3]) -> Vec3 {
    Vec3::from(srgb.map(|x| from_srgb(f32::from(x) / 255.0) as f32))
}

/// Returns the luminance of a linear Rec. 709 colour.
pub fn compute_luminance(linear: Vec3) -> f32 {
    linear.dot(Vec3::new(0.2126, 0.7152, 0.0722))
}

/// Returns √(ΣA x² / ΣA) of pairs (x, A); 0 for no weight.
pub fn weighted_rms(values: impl Iterator<Item = (f64, f64)>) -> f64 {
    let (square, total) = values.fold((0.0, 0.0), |(square, total), (x, weight)| {
        (square + x * x * weight, total + weight)
    });
    if total > 0.0 { (square / total).sqrt() } else { 0.0 }
}

/// Sorts pairs (x, weight) and returns the least x up to which at least `share` of all weight lies; none without pairs.
pub fn weighted_percentile(values: &mut [(f64, f64)], share: f64) -> Option<f64> {
    values.par_sort_by(|a, b| a.0.total_cmp(&b.0));
    let wanted = share * values.iter().map(|(_, weight)| weight).sum::<f64>();
    let mut below = 0.0;
    let at = values.iter().find(|(_, weight)| {
        below += weight;
        below >= wanted
    });
    at.map(|(value, _)| *value)
}

/// Exposure of a picture: the radiosity shown as white, and the curve from light to display values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exposure {
    /// Radiosity that becomes 1 on a linear display, W/m².
    pub white: f32,
    /// True for the shoulder of [`Exposure::with_shoulder`], false to clip at white.
    pub has_shoulder: bool,
}

impl Exposure {
    /// Creates a linear exposure that clips above `white`, W/m².
    pub fn with_white(white: f32) -> Self {
        Self {
            white,
            has_shoulder: false,
        }
    }

    /// Returns this exposure with Uchimura's shoulder (2017, without a toe): linear up to S, then
    /// 1 − (1 − S) e^(−(x − S)/(1 − S)), which continues with slope 1 and reaches 1 only in the limit.
    pub fn with_shoulder(self) -> Self {
        Self {
            has_shoulder: true,
            ..self
        }
    }

    /// Chooses the exposure that shows a `share` of (value, weight) pairs no brighter than 0.8 of white.
    pub fn from_percentile(values: impl Iterator<Item = (f32, f32)>, share: f64) -> Self {
        let positive = |(value, weight): &(f32, f32)| value.is_finite() && *value > 0.0 && *weight > 0.0;
        let values = values.filter(positive);
        let mut values: Vec<(f64, f64)> = values.map(|(value, weight)| (value.into(), weight.into())).collect();
        let at = weighted_percentile(&mut values, share);
        let white = at.map_or(1.0, |value| value / PERCENTILE_DISPLAY_VALUE);
        Self::with_white(white.clamp(f64::from(f32::MIN_POSITIVE), f64::from(f32::MAX)) as f32)
    }

    /// Maps radiosity to linear display values; NaN becomes magenta.
    pub fn display_light(&self, radiosity: Vec3) -> Vec3 {
        if radiosity.is_nan() {
            return decode_srgb(NOT_A_NUMBER);
        }
        let headroom = 1.0 - SHOULDER_START;
        let shown = (radiosity / self.white)
            .max(Vec3::ZERO)
            .map(|x| match x > SHOULDER_START {
                true if self.has_shoulder => 1.0 - headroom * (-(x - SHOULDER_START) / headroom).exp(),
                _ => x,
            });
        shown.min(Vec3::ONE)
    }
}

/// Returns the false colour of x in −1…1 (clipped); NaN becomes magenta.
pub fn diverging_colour(x: f64) -> [u8; 3] {
    if x.is_nan() {
        return NOT_A_NUMBER;
    }
    let last = DIVERGING_COLOURS.len() - 1;
    let place = (x.clamp(-1.0, 1.0) * 0.5 + 0.5) * last as f64;
    let k = (place as usize).min(last - 1);
    std::array::from_fn(|c| {
        let (a, b) = (
            f64::from(DIVERGING_COLOURS[k][c]),
            f64::from(DIVERGING_COLOURS[k + 1][c]),
        );
        (a + (b - a) * (place - k as f64)).round() as u8
    })
}

/// Chooses a symmetric range for [`diverging_colour`]: 1, 2 or 5 × 10ⁿ, exceeded by at most one value in 200.
pub fn false_colour_range(values: impl Iterator<Item = f64>) -> f64 {
    let mut sizes: Vec<f64> = values.map(f64::abs).filter(|x| x.is_finite() && *x > 0.0).collect();
    sizes.sort_by(f64::total_cmp);
    let Some(wanted) = sizes.get((sizes.len() * 199 / 200).min(sizes.len().saturating_sub(1))) else {
        return 1e-6;
    };
    let decade = wanted.max(1e-9).log10().floor();
    let power = 10f64.powf(decade);
    // Only rounding can make 10 × power necessary.
    [1.0, 2.0, 5.0]
        .map(|m| m * power)
        .into_iter()
        .find(|r| r >= wanted)
        .unwrap_or(10.0 * power)
}

/// Returns a face's colour in item buffers; successive faces differ in hue by the golden angle.
pub fn face_colour(face: u32) -> [u8; 3] {
    let hue = (f64::from(face) * 0.618_033_988_749_895).fract() * 6.0;
    let value = [0.95, 0.7, 0.82][(face / 7 % 3) as usize];
    let saturation = [0.75, 0.5][(face / 3 % 2) as usize];
    [0.0, 4.0, 2.0].map(|offset| {
        let ramp = (((hue + offset) % 6.0 - 3.0).abs() - 1.0).clamp(0.0, 1.0);
        (255.0 * value * (1.0 - saturation + saturation * ramp)).round() as u8
    })
}

/// Draws an item buffer (face IDs + 1, row-major) in the faces' colours; 0 is black.
pub fn draw_item_buffer(ids: &[u32], size: u32) -> RgbaPicture {
    RgbaPicture::from_pixels(size, size, |x, y| {
        let id = ids.get((y as usize) * (size as usize) + x as usize);
        Some(id.and_then(|id| id.checked_sub(1)).map_or([0; 3], face_colour))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::abs_diff_eq;

    #[test]
    fn srgb_round_trips_and_nan_is_magenta() {
        for x in 0..=255 {
            assert_eq!(encode_srgb(decode_srgb([x, 255 - x, 7])), [x, 255 - x, 7]);
        }
        assert_eq!(encode_srgb(Vec3::new(0.5, f32::NAN, 0.0)), NOT_A_NUMBER);
        assert_eq!(
            encode_srgb(Exposure::with_white(1.0).display_light(Vec3::NAN)),
            NOT_A_NUMBER
        );
        assert_eq!(diverging_colour(f64::NAN), NOT_A_NUMBER);
    }

    #[test]
    fn false_colours_are_symmetric_and_in_range() {
        assert_eq!(diverging_colour(0.0), DIVERGING_COLOURS[3]);
        assert_eq!(
            [diverging_colour(-7.0), diverging_colour(7.0)],
            [DIVERGING_COLOURS[0], DIVERGING_COLOURS[6]]
        );
        assert_eq!(false_colour_range([0.003, -0.0011, f64::NAN].into_iter()), 0.005);
        assert_eq!(false_colour_range(std::iter::empty()), 1e-6);
        assert_eq!(false_colour_range(std::iter::once(f64::INFINITY)), 1e-6);
    }

    #[test]
    fn exposure_follows_weighted_percentile() {
        let values = (1..=100).map(|k| (k as f32, if k <= 90 { 1.0 } else { 0.1 }));
        let exposure = Exposure::from_percentile(values, 0.9);
        // The weights sum to 91; 0.9 of that is reached at 82.
        assert!(abs_diff_eq!(exposure.white, 82.0 / 0.8, epsilon = 1e-4));
        let nothing = Exposure::from_percentile([(f32::NAN, 1.0), (0.0, 1.0), (1.0, f32::NAN)].into_iter(), 0.9);
        assert_eq!(nothing.white, 1.0);
    }

    #[test]
    fn curves_rise_and_only_linear_one_clips_highlights() {
        let linear = Exposure::with_white(1.0);
        for (exposure, is_clipped) in [(linear, true), (linear.with_shoulder(), false)] {
            let at = |x: f32| exposure.display_light(Vec3::splat(x));
            assert_eq!([at(0.0), at(-1.0)], [Vec3::ZERO; 2]);
            assert_eq!([at(0.18).x, at(0.5).x], [0.18, 0.5]);
            let steps: Vec<f32> = (0..1000).map(|k| at(k as f32 * 0.01).x).collect();
            assert!(steps.is_sorted(), "{exposure:?}");
            assert!(at(f32::MAX).is_finite() && at(f32::INFINITY).max_element() <= 1.0);
            let apart = at(2.0).x - at(1.2).x;
            assert!(if is_clipped { apart == 0.0 } else { apart > 0.05 }, "{apart}");
            // The shoulder begins with slope 1.
            assert!((at(SHOULDER_START + 1e-3).x - SHOULDER_START - 1e-3).abs() < 1e-5);
        }
    }

    #[test]
    fn face_colours_differ_and_pngs_are_complete() {
        let set: std::collections::BTreeSet<_> = (0..200).map(face_colour).collect();
        assert!(set.len() > 190);
        let picture = draw_item_buffer(&[0, 1, 2], 2);
        assert_eq!(picture.rgba[..4], [0, 0, 0, 255]);
        assert!(picture.data_uri().starts_with("data:image/png;base64,iVBOR"));
        let nothing = RgbaPicture {
            width: 0,
            height: 0,
            rgba: Vec::new(),
        };
        assert!(nothing.encode_png().is_empty());
    }
}
