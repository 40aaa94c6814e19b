//! Pictures as PNG: a stated exposure, false colours, the atlas, item buffers.

use super::tone::Curve;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use common::import::from_srgb;
use common::mesh::Mesh;
use glam::{Vec3, Vec4};
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};

pub use super::tone::luminance;

/// Not a number, in every picture: nothing else is magenta.
pub const NOT_A_NUMBER: [u8; 3] = [255, 0, 255];
/// The atlas is thinned out to at most this many pixels a side.
const ATLAS_SIDE: u32 = 2048;
/// The share of surfaces that are not brighter than [`BRIGHT`].
const PERCENTILE: f64 = 0.9;
/// Where that percentile goes, of a linear display's white.
const BRIGHT: f64 = 0.8;
/// From negative (blue) over zero (near white) to positive (red), sRGB (ColorBrewer RdBu).
pub const DIVERGING: [[u8; 3]; 7] = [
    [5, 48, 97],
    [67, 147, 195],
    [171, 210, 229],
    [247, 247, 247],
    [248, 191, 164],
    [214, 96, 77],
    [103, 0, 31],
];

/// 8-bit sRGB with alpha, row-major from the upper left.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// Pixels a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Four bytes a pixel; alpha is not premultiplied.
    pub rgba: Vec<u8>,
}

impl Picture {
    /// One colour per pixel; none is transparent.
    pub fn from_pixels(
        width: u32,
        height: u32,
        colour: impl Fn(u32, u32) -> Option<[u8; 3]>,
    ) -> Self {
        let rgba = (0..height)
            .flat_map(|y| (0..width).map(move |x| (x, y)))
            .flat_map(|(x, y)| colour(x, y).map_or([0; 4], |[r, g, b]| [r, g, b, 255]))
            .collect();
        Self {
            width,
            height,
            rgba,
        }
    }

    /// As a PNG file; empty for a picture without pixels.
    pub fn png(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        let encoder = PngEncoder::new_with_quality(
            &mut bytes,
            CompressionType::Default,
            FilterType::Adaptive,
        );
        let (w, h) = (self.width, self.height);
        match encoder.write_image(&self.rgba, w, h, ExtendedColorType::Rgba8) {
            Ok(()) => bytes,
            Err(_) => Vec::new(),
        }
    }

    /// As the source of an `img` element.
    pub fn data_uri(&self) -> String {
        format!("data:image/png;base64,{}", STANDARD.encode(self.png()))
    }
}

/// Linear Rec. 709, 0…1, in 8-bit sRGB (IEC 61966-2-1); NaN is magenta.
pub fn encode(linear: Vec3) -> [u8; 3] {
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

/// The inverse of [`encode`].
pub fn decode(srgb: [u8; 3]) -> Vec3 {
    Vec3::from(srgb.map(|x| from_srgb(f32::from(x) / 255.0) as f32))
}

/// √(ΣA x² / ΣA) of (x, A); 0 where there is nothing.
pub fn rms(values: impl Iterator<Item = (f64, f64)>) -> f64 {
    let (square, total) = values.fold((0.0, 0.0), |(square, total), (x, weight)| {
        (square + x * x * weight, total + weight)
    });
    if total > 0.0 {
        (square / total).sqrt()
    } else {
        0.0
    }
}

/// How much radiosity is white, and by which curve it is shown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exposure {
    /// W/m² that become 1 on a linear display.
    pub white: f32,
    /// What becomes of it.
    pub curve: Curve,
}

impl Exposure {
    /// So much is white, and what is more is clipped.
    pub fn linear(white: f32) -> Self {
        Self {
            white,
            curve: Curve::Linear,
        }
    }

    /// Opened by so many stops, and shown by that curve.
    pub fn opened(self, stops: f64, curve: Curve) -> Self {
        let white = f64::from(self.white) * (-stops).exp2();
        Self {
            white: white.clamp(f64::from(f32::MIN_POSITIVE), f64::from(f32::MAX)) as f32,
            curve,
        }
    }

    /// Brings the 90th percentile of (value, weight) pairs to 0.8 of white.
    pub fn of(values: impl Iterator<Item = (f32, f32)>) -> Self {
        let positive =
            |(value, weight): &(f32, f32)| value.is_finite() && *value > 0.0 && *weight > 0.0;
        let mut values: Vec<(f32, f32)> = values.filter(positive).collect();
        values.sort_by(|a, b| a.0.total_cmp(&b.0));
        let sum = |values: &[(f32, f32)]| values.iter().map(|v| f64::from(v.1)).sum::<f64>();
        let wanted = PERCENTILE * sum(&values);
        let mut below = 0.0;
        let at = values.iter().find(|(_, weight)| {
            below += f64::from(*weight);
            below >= wanted
        });
        let white = at.map_or(1.0, |(value, _)| f64::from(*value) / BRIGHT);
        Self::linear(white.clamp(f64::from(f32::MIN_POSITIVE), f64::from(f32::MAX)) as f32)
    }

    /// Radiosity on a linear display; NaN is magenta.
    pub fn display(&self, radiosity: Vec3) -> Vec3 {
        if radiosity.is_nan() {
            return decode(NOT_A_NUMBER);
        }
        self.curve.display(radiosity / self.white)
    }
}

/// The false colour of x in −1…1 (clipped); NaN is magenta.
pub fn diverging(x: f64) -> [u8; 3] {
    if x.is_nan() {
        return NOT_A_NUMBER;
    }
    let last = DIVERGING.len() - 1;
    let place = (x.clamp(-1.0, 1.0) * 0.5 + 0.5) * last as f64;
    let k = (place as usize).min(last - 1);
    std::array::from_fn(|c| {
        let (a, b) = (f64::from(DIVERGING[k][c]), f64::from(DIVERGING[k + 1][c]));
        (a + (b - a) * (place - k as f64)).round() as u8
    })
}

/// A symmetric range for [`diverging`]: 1, 2 or 5 × 10ⁿ, exceeded by one value in 200 at most.
pub fn range(values: impl Iterator<Item = f64>) -> f64 {
    let mut sizes: Vec<f64> = values
        .map(f64::abs)
        .filter(|x| x.is_finite() && *x > 0.0)
        .collect();
    sizes.sort_by(f64::total_cmp);
    let Some(wanted) = sizes.get((sizes.len() * 199 / 200).min(sizes.len().saturating_sub(1)))
    else {
        return 1e-6;
    };
    let decade = wanted.max(1e-9).log10().floor();
    let power = 10f64.powf(decade);
    // 10 × power itself is reached by rounding only.
    [1.0, 2.0, 5.0]
        .map(|m| m * power)
        .into_iter()
        .find(|r| r >= wanted)
        .unwrap_or(10.0 * power)
}

/// A face's colour in item buffers: successive faces differ in hue by the golden angle.
pub fn face_colour(face: u32) -> [u8; 3] {
    let hue = (f64::from(face) * 0.618_033_988_749_895).fract() * 6.0;
    let value = [0.95, 0.7, 0.82][(face / 7 % 3) as usize];
    let saturation = [0.75, 0.5][(face / 3 % 2) as usize];
    [0.0, 4.0, 2.0].map(|offset| {
        let ramp = (((hue + offset) % 6.0 - 3.0).abs() - 1.0).clamp(0.0, 1.0);
        (255.0 * value * (1.0 - saturation + saturation * ramp)).round() as u8
    })
}

/// An item buffer (face IDs + 1, row-major) in the faces' colours, black where nothing is.
pub fn item_buffer(ids: &[u32], size: u32) -> Picture {
    Picture::from_pixels(size, size, |x, y| {
        let id = ids.get((y as usize) * (size as usize) + x as usize);
        Some(
            id.and_then(|id| id.checked_sub(1))
                .map_or([0; 3], face_colour),
        )
    })
}

/// The radiosity of all texels where they lie in the atlas; transparent where no face is.
pub fn atlas(mesh: &Mesh, radiosity: &[Vec4], exposure: Exposure) -> Picture {
    atlas_of(mesh, |texel| {
        let value = radiosity.get(texel).copied().unwrap_or(Vec4::NAN);
        encode(exposure.display(value.truncate()))
    })
}

/// A colour for each texel of the mesh where it lies in the atlas; transparent where no face is.
pub fn atlas_of(mesh: &Mesh, colour: impl Fn(usize) -> [u8; 3]) -> Picture {
    let [w, h] = mesh.atlas;
    let mut pixels = vec![None; w as usize * h as usize];
    for (k, texel) in mesh.texels.iter().enumerate() {
        pixels[texel.pixel as usize] = Some(colour(k));
    }
    let step = w.max(h).div_ceil(ATLAS_SIDE).max(1);
    Picture::from_pixels(w / step, h / step, |x, y| {
        pixels[(y * step) as usize * w as usize + (x * step) as usize]
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::abs_diff_eq;

    #[test]
    fn srgb_goes_back_and_forth_and_nan_is_magenta() {
        for x in 0..=255 {
            assert_eq!(encode(decode([x, 255 - x, 7])), [x, 255 - x, 7]);
        }
        assert_eq!(encode(Vec3::new(0.5, f32::NAN, 0.0)), NOT_A_NUMBER);
        assert_eq!(
            encode(Exposure::linear(1.0).display(Vec3::NAN)),
            NOT_A_NUMBER
        );
        assert_eq!(diverging(f64::NAN), NOT_A_NUMBER);
    }

    #[test]
    fn false_colours_are_symmetric_and_in_range() {
        assert_eq!(diverging(0.0), DIVERGING[3]);
        assert_eq!(
            [diverging(-7.0), diverging(7.0)],
            [DIVERGING[0], DIVERGING[6]]
        );
        assert_eq!(range([0.003, -0.0011, f64::NAN].into_iter()), 0.005);
        assert_eq!(range(std::iter::empty()), 1e-6);
        assert_eq!(range(std::iter::once(f64::INFINITY)), 1e-6);
    }

    #[test]
    fn the_exposure_is_a_weighted_percentile() {
        let exposure = Exposure::of((1..=100).map(|k| (k as f32, if k <= 90 { 1.0 } else { 0.1 })));
        // 91 in total; 0.9 of it is reached at 82.
        assert!(abs_diff_eq!(exposure.white, 82.0 / 0.8, epsilon = 1e-4));
        let opened = exposure.opened(2.0, Curve::Filmic);
        assert_eq!(opened.white, exposure.white / 4.0);
        let nothing = Exposure::of([(f32::NAN, 1.0), (0.0, 1.0), (1.0, f32::NAN)].into_iter());
        assert_eq!(nothing.white, 1.0);
    }

    #[test]
    fn neighbouring_faces_have_different_colours_and_pngs_are_complete() {
        let set: std::collections::BTreeSet<_> = (0..200).map(face_colour).collect();
        assert!(set.len() > 190);
        let picture = item_buffer(&[0, 1, 2], 2);
        assert_eq!(picture.rgba[..4], [0, 0, 0, 255]);
        assert!(
            picture
                .data_uri()
                .starts_with("data:image/png;base64,iVBOR")
        );
        let nothing = Picture {
            width: 0,
            height: 0,
            rgba: Vec::new(),
        };
        assert!(nothing.png().is_empty());
    }
}
