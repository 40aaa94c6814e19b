//! Texture pictures with mip levels, and their means over polygons.

use super::level::{MipLevel, Shade, WrapMode};
use super::polygon::PlanePolygon;
use crate::jpeg;
use glam::{DVec2, DVec3};
use image::error::ImageError;
use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader};
use std::io::Cursor;

/// Largest accepted number of pixels: 4096².
const MAX_PICTURE_PIXELS: u64 = 1 << 24;

/// Pixels per side of a polygon up to which its mean is exact. Larger polygons take the mean of a coarser
/// level, whose pixels are means themselves.
const MAX_EXACT_SIDE: f64 = 1024.0;

/// The same limit with a shade: then every pixel is visited, so fewer are allowed.
const MAX_SHADED_SIDE: f64 = 128.0;

/// Texture coordinates from here on are ignored: f32 has no digits left for a pixel.
const MAX_COORDINATE: f64 = 1e6;

/// A polygon counts as a line below this area, per square of its size.
const MIN_POLYGON_AREA: f64 = 1e-9;

/// A picture in linear Rec. 709, with levels of half, a quarter, … of its pixels per side.
pub struct TexturePicture {
    levels: Vec<MipLevel>,
    whole: DVec3,
    white: bool,
}

impl TexturePicture {
    /// Decodes a PNG or a JPEG. In a channel with a maximum below 1, a value of 1 becomes that maximum.
    ///
    /// Errors: the end of a sentence that begins with the picture's name.
    pub fn decode_image(bytes: &[u8], maxima: [f32; 3]) -> Result<Self, String> {
        let damaged = |e: &dyn std::fmt::Display| format!("cannot be decoded: {e}");
        let reader = ImageReader::new(Cursor::new(bytes));
        let reader = reader.with_guessed_format().map_err(|e| damaged(&e))?;
        if !matches!(reader.format(), Some(ImageFormat::Png | ImageFormat::Jpeg)) {
            return Err("is neither PNG nor JPEG: convert it".into());
        }
        if reader.format() == Some(ImageFormat::Jpeg) {
            jpeg::check_whole(bytes)?;
        }
        let of = |e: ImageError| damaged(&e);
        let decoder = reader.into_decoder().map_err(of)?;
        let (width, height) = decoder.dimensions();
        if u64::from(width) * u64::from(height) > MAX_PICTURE_PIXELS {
            return Err(format!(
                "has {width}×{height} pixels, more than 4096×4096: scale it down"
            ));
        }
        let picture = DynamicImage::from_decoder(decoder).map_err(of)?.into_rgb32f();
        let mut pixels: Vec<[f32; 3]> = Vec::with_capacity(picture.pixels().len());
        let mut white = false;
        for pixel in picture.pixels() {
            let mut linear = pixel.0.map(|x| from_srgb(x) as f32);
            for (x, maximum) in linear.iter_mut().zip(maxima) {
                if *x > maximum && *x == 1.0 {
                    (*x, white) = (maximum, true);
                }
            }
            pixels.push(linear);
        }
        let picture = Self::new([width as usize, height as usize], pixels);
        Ok(Self { white, ..picture })
    }

    /// Makes a picture from pixels in linear Rec. 709, rows from the top; `size` is at least 1×1.
    pub fn new(size: [usize; 2], pixels: Vec<[f32; 3]>) -> Self {
        let mut levels = vec![MipLevel::new(size, pixels)];
        let whole = levels[0].mean_colour();
        while let Some(half) = levels.last().and_then(MipLevel::half_resolution) {
            levels.push(half);
        }
        Self {
            levels,
            whole,
            white: false,
        }
    }

    /// Number of pixels of the finest level.
    pub fn pixel_count(&self) -> usize {
        self.levels.first().map_or(0, MipLevel::pixel_count)
    }

    /// Removes the levels of more than `max_pixels` pixels. Returns true if any was removed.
    pub fn shrink_to(&mut self, max_pixels: usize) -> bool {
        let is_too_fine = |level: &&MipLevel| level.pixel_count() > max_pixels.max(1);
        let removed = self.levels.iter().take_while(is_too_fine).count();
        self.levels.drain(..removed);
        removed > 0
    }

    /// True if a value of 1 was lowered on decoding.
    pub fn was_white(&self) -> bool {
        self.white
    }

    /// True if the picture is constant on a polygon, because the polygon lies within one pixel or its
    /// coordinates are ignored.
    pub fn is_uniform(&self, places: &[DVec2]) -> bool {
        let Some(level) = self.levels.first().filter(|_| places.iter().all(is_in_range)) else {
            return true;
        };
        let pixel = |p: &DVec2| (*p * level.pixels_per_unit()).floor();
        places.iter().all(|p| pixel(p) == pixel(&places[0]))
    }

    /// Mean over the whole picture.
    pub fn mean_colour(&self) -> DVec3 {
        self.whole
    }

    /// Colour at a position; (0, 0) is the upper left corner, (1, 1) the lower right one.
    pub fn colour_at(&self, place: DVec2, wrap: [WrapMode; 2]) -> DVec3 {
        match self.levels.first() {
            Some(level) if is_in_range(&place) => level.colour_at(place * level.pixels_per_unit(), wrap),
            _ => self.whole,
        }
    }

    /// Mean over a polygon, times the `shade` there; coordinates as in [`TexturePicture::colour_at`].
    pub fn mean_over(&self, polygon: &PlanePolygon, wrap: [WrapMode; 2], shade: Option<Shade>) -> DVec3 {
        let (area, middle) = polygon.area_and_centroid();
        let shaded = || shade.map_or(DVec3::ONE, |shade| shade(middle));
        if !polygon.corners().iter().all(is_in_range) {
            return self.whole * shaded();
        }
        let [low, high] = polygon.bounding_box();
        let max_side = shade.map_or(MAX_EXACT_SIDE, |_| MAX_SHADED_SIDE);
        let fits = |level: &&MipLevel| ((high - low) * level.pixels_per_unit()).max_element() <= max_side;
        // A polygon that is larger even on the coarsest level repeats the picture often: it gets the whole mean.
        let Some(level) = self.levels.iter().find(fits) else {
            return self.whole * shaded();
        };
        let scale = level.pixels_per_unit();
        if (low * scale).floor() == (high * scale).floor() {
            return level.colour_at(low * scale, wrap) * shaded();
        }
        let pixels = polygon.map_corners(|p| p * scale);
        let by = |p: DVec2| shade.map_or(DVec3::ONE, |shade| shade(p / scale));
        let shade = shade.map(|_| &by as Shade);
        if area <= 0.5 * MIN_POLYGON_AREA * (high - low).max_element().powi(2) {
            level.mean_along(&pixels, wrap, shade)
        } else {
            level.mean_over(&pixels, wrap, shade)
        }
    }
}

fn is_in_range(p: &DVec2) -> bool {
    p.is_finite() && p.abs().max_element() < MAX_COORDINATE
}

/// Decodes an sRGB value to a linear one (IEC 61966-2-1).
pub fn from_srgb(x: f32) -> f64 {
    let x = f64::from(x);
    if x <= 0.040_45 {
        x / 12.92
    } else {
        ((x + 0.055) / 1.055).powf(2.4)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::abs_diff_eq;
    use image::{Rgb, RgbImage};

    /// Pixel (x, y) of w×h is (x, y, 1) as light.
    fn ramp(w: usize, h: usize) -> TexturePicture {
        let pixel = |k: usize| [(k % w) as f32, (k / w) as f32, 1.0];
        TexturePicture::new([w, h], (0..w * h).map(pixel).collect())
    }

    fn close(found: DVec3, expected: [f64; 3]) {
        assert!(
            abs_diff_eq!((found - DVec3::from(expected)).length(), 0.0, epsilon = 1e-9),
            "{found} instead of {expected:?}"
        );
    }

    /// The mean over the rectangle from a to b.
    fn rectangle(picture: &TexturePicture, a: [f64; 2], b: [f64; 2], wrap: WrapMode) -> DVec3 {
        let places = [[a[0], a[1]], [b[0], a[1]], [b[0], b[1]], [a[0], b[1]]].map(DVec2::from);
        picture.mean_over(&PlanePolygon::new(places), [wrap; 2], None)
    }

    #[test]
    fn mean_over_polygon_is_exact() {
        let picture = ramp(4, 4);
        close(
            rectangle(&picture, [0., 0.], [1., 1.], WrapMode::Repeat),
            [1.5, 1.5, 1.],
        );
        // Half of column 1, all of column 2, a quarter of column 3.
        let part = rectangle(&picture, [0.375, 0.5], [0.8125, 0.75], WrapMode::Repeat);
        close(part, [(0.5 + 2.0 + 0.75) / 1.75, 2., 1.]);
        // The triangle below the diagonal: column x has x + ½ pixels.
        let places = [[0., 0.], [1., 0.], [1., 1.]].map(DVec2::from);
        let mean = picture.mean_over(&PlanePolygon::new(places), [WrapMode::Repeat; 2], None);
        close(mean, [(1.5 + 5.0 + 10.5) / 8., (3.5 * 0. + 2.5 + 3. + 1.5) / 8., 1.]);
    }

    #[test]
    fn coordinates_beyond_the_edge_follow_the_wrap_mode() {
        let picture = ramp(4, 1);
        for (wrap, expected) in [(WrapMode::Repeat, 0.5), (WrapMode::Mirror, 2.5), (WrapMode::Clamp, 3.0)] {
            let found = rectangle(&picture, [1., 0.], [1.5, 1.], wrap);
            close(found, [expected, 0., 1.]);
        }
        let before = rectangle(&picture, [-0.5, 0.], [0., 1.], WrapMode::Repeat);
        close(before, [2.5, 0., 1.]);
    }

    #[test]
    fn points_lines_and_non_finite_polygons_have_a_mean() {
        let picture = ramp(4, 4);
        let point = rectangle(&picture, [0.6, 0.3], [0.6, 0.3], WrapMode::Repeat);
        close(point, [2., 1., 1.]);
        let line = rectangle(&picture, [0., 0.3], [1., 0.3], WrapMode::Repeat);
        assert!((line.x - 1.5).abs() < 0.1 && line.y == 1.0, "{line}");
        for odd in [f64::NAN, f64::INFINITY, 1e30] {
            close(
                rectangle(&picture, [0., 0.], [odd, 1.], WrapMode::Repeat),
                [1.5, 1.5, 1.],
            );
        }
    }

    #[test]
    fn large_polygons_use_a_coarser_level() {
        let picture = ramp(3000, 30);
        let whole = rectangle(&picture, [0., 0.], [1., 1.], WrapMode::Repeat);
        // Levels are rounded to f32.
        assert!((whole - picture.mean_colour()).length() < 1e-6, "{whole}");
        let part = rectangle(&picture, [0.1, 0.], [0.9, 1.], WrapMode::Repeat);
        assert!((part - whole).length() < 1e-3, "{part}");
        close(
            rectangle(&picture, [0., 0.], [1e5, 1.], WrapMode::Repeat),
            [1499.5, 14.5, 1.],
        );
    }

    #[test]
    fn row_sums_equal_sums_of_pixels() {
        // With a shade, pixels are visited one by one.
        let picture = ramp(70, 40);
        let polygons = [
            vec![[0.11, 0.2], [0.83, 0.31], [0.9, 0.95], [0.3, 0.7]],
            vec![[-1.3, -0.4], [0.1, -0.4], [0.1, 0.6], [-1.3, 0.6]],
            vec![[0.5, 0.5], [1.7, 0.9], [0.6, 2.1]],
        ];
        for wrap in [WrapMode::Repeat, WrapMode::Mirror, WrapMode::Clamp] {
            for corners in &polygons {
                let polygon = PlanePolygon::new(corners.iter().copied().map(DVec2::from));
                let by_rows = picture.mean_over(&polygon, [wrap; 2], None);
                let by_pixels = picture.mean_over(&polygon, [wrap; 2], Some(&|_| DVec3::ONE));
                close(by_rows, by_pixels.to_array());
            }
        }
    }

    #[test]
    fn shade_multiplies_each_pixel() {
        // ∫ over pixel k of k·x: Σ k (k + ½) / 4 of x in pixels.
        let picture = ramp(4, 1);
        let places = [[0., 0.], [1., 0.], [1., 1.], [0., 1.]].map(DVec2::from);
        let shade = |p: DVec2| DVec3::splat(4.0 * p.x);
        let mean = picture.mean_over(&PlanePolygon::new(places), [WrapMode::Clamp; 2], Some(&shade));
        close(mean, [(1.5 + 5.0 + 10.5) / 4.0, 0., 2.]);
    }

    #[test]
    fn white_is_lowered_to_the_given_maximum() {
        let mut bytes = Cursor::new(Vec::new());
        let image = RgbImage::from_fn(2, 1, |x, _| Rgb([255, 254 + x as u8, 0]));
        image.write_to(&mut bytes, ImageFormat::Png).unwrap();
        let picture = TexturePicture::decode_image(bytes.get_ref(), [0.5, 1.0, 0.5]).unwrap();
        let light = from_srgb(254.0 / 255.0);
        assert!((picture.mean_colour() - DVec3::new(0.5, (light + 1.0) / 2.0, 0.0)).length() < 1e-6);
        let picture = TexturePicture::decode_image(bytes.get_ref(), [1.0, 0.5, 0.5]).unwrap();
        assert!((picture.mean_colour().y - (light + 0.5) / 2.0).abs() < 1e-6);
    }

    #[test]
    fn shrinking_keeps_the_mean() {
        let mut picture = ramp(64, 64);
        assert!(!picture.shrink_to(64 * 64));
        assert!(picture.shrink_to(1000) && picture.pixel_count() == 16 * 16);
        close(picture.mean_colour(), [31.5, 31.5, 1.]);
        close(
            rectangle(&picture, [0., 0.], [0.5, 1.], WrapMode::Repeat),
            [15.5, 31.5, 1.],
        );
        assert!(picture.shrink_to(0) && picture.pixel_count() == 1);
    }

    #[test]
    fn too_large_picture_is_refused_before_decoding() {
        let mut bytes = Cursor::new(Vec::new());
        let image = image::GrayImage::new(1 << 13, (1 << 11) + 1);
        image.write_to(&mut bytes, ImageFormat::Png).unwrap();
        let message = TexturePicture::decode_image(bytes.get_ref(), [1.0; 3]).err().unwrap();
        assert!(message.starts_with("has 8192×2049 pixels"), "{message}");
    }

    #[test]
    fn file_values_are_decoded_as_srgb() {
        let mut bytes = Cursor::new(Vec::new());
        let image = RgbImage::from_fn(2, 2, |x, _| Rgb([if x == 0 { 188 } else { 10 }, 255, 0]));
        image.write_to(&mut bytes, ImageFormat::Png).unwrap();
        let bytes = bytes.into_inner();
        let mean = TexturePicture::decode_image(&bytes, [1.0; 3])
            .map(|picture| picture.mean_colour())
            .unwrap();
        // 188: 0.502886 by IEC 61966-2-1; 10: on its straight part.
        let expected = DVec3::new((0.502_886 + 10.0 / 255.0 / 12.92) / 2.0, 1.0, 0.0);
        assert!((mean - expected).length() < 1e-6, "{mean}");
        for damaged in [&bytes[..bytes.len() / 2], b"GIF89a", b""] {
            assert!(TexturePicture::decode_image(damaged, [1.0; 3]).is_err());
        }
    }
}
