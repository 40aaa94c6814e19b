//! Pictures of textures, and their mean over parts of their plane.

use super::level::{Level, Shade, Wrap};
use super::polygon::Polygon;
use crate::jpeg;
use glam::{DVec2, DVec3};
use image::error::ImageError;
use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader};
use std::io::Cursor;

/// Pictures of more pixels are refused: 4096².
const MOST: u64 = 1 << 24;

/// A mean is exact over up to so many pixels a side; above, it is taken of a coarser copy, whose pixels are
/// means themselves.
const FINEST: f64 = 1024.0;

/// Where it is multiplied by something that varies, every pixel is looked at, so fewer are.
const FINEST_SHADED: f64 = 128.0;

/// Coordinates further out say nothing: f32 has no digits left for a pixel.
const FAR: f64 = 1e6;

/// The area of a polygon, per square of its size, below which it is a line.
const LINE: f64 = 1e-9;

/// A picture in linear Rec. 709, and copies of half, a quarter, … of its pixels a side.
pub struct Picture {
    levels: Vec<Level>,
    whole: DVec3,
    white: bool,
}

impl Picture {
    /// Decodes a PNG or a JPEG; the error follows the picture's name. Where `most` is less than 1, what is 1
    /// in that channel is taken as that much.
    pub fn decode(bytes: &[u8], most: [f32; 3]) -> Result<Self, String> {
        let damaged = |e: &dyn std::fmt::Display| format!("cannot be decoded: {e}");
        let reader = ImageReader::new(Cursor::new(bytes));
        let reader = reader.with_guessed_format().map_err(|e| damaged(&e))?;
        if !matches!(reader.format(), Some(ImageFormat::Png | ImageFormat::Jpeg)) {
            return Err("is neither PNG nor JPEG: convert it".into());
        }
        if reader.format() == Some(ImageFormat::Jpeg) {
            jpeg::whole(bytes)?;
        }
        let of = |e: ImageError| damaged(&e);
        let decoder = reader.into_decoder().map_err(of)?;
        let (width, height) = decoder.dimensions();
        if u64::from(width) * u64::from(height) > MOST {
            return Err(format!(
                "has {width}×{height} pixels, more than 4096×4096: scale it down"
            ));
        }
        let picture = DynamicImage::from_decoder(decoder)
            .map_err(of)?
            .into_rgb32f();
        let mut pixels: Vec<[f32; 3]> = Vec::with_capacity(picture.pixels().len());
        let mut white = false;
        for pixel in picture.pixels() {
            let mut linear = pixel.0.map(|x| from_srgb(x) as f32);
            for (x, most) in linear.iter_mut().zip(most) {
                if *x > most && *x == 1.0 {
                    (*x, white) = (most, true);
                }
            }
            pixels.push(linear);
        }
        let picture = Self::new([width as usize, height as usize], pixels);
        Ok(Self { white, ..picture })
    }

    /// Of pixels in linear Rec. 709, rows from the top; `size` is one at least either way.
    pub fn new(size: [usize; 2], pixels: Vec<[f32; 3]>) -> Self {
        let mut levels = vec![Level::new(size, pixels)];
        let whole = levels[0].whole();
        while let Some(half) = levels.last().and_then(Level::half) {
            levels.push(half);
        }
        Self {
            levels,
            whole,
            white: false,
        }
    }

    /// How many pixels it has, its copies aside.
    pub fn count(&self) -> usize {
        self.levels.first().map_or(0, Level::count)
    }

    /// Leaves of it what has `most` pixels at most, and says whether something went.
    pub fn shrink(&mut self, most: usize) -> bool {
        let goes = |level: &&Level| level.count() > most.max(1);
        let gone = self.levels.iter().take_while(goes).count();
        self.levels.drain(..gone);
        gone > 0
    }

    /// Whether something in it was 1 and is taken as less.
    pub fn was_white(&self) -> bool {
        self.white
    }

    /// Whether it has one colour on a polygon, since that lies within a pixel, or nowhere.
    pub fn is_even(&self, places: &[DVec2]) -> bool {
        let Some(level) = self.levels.first().filter(|_| places.iter().all(is_near)) else {
            return true;
        };
        let pixel = |p: &DVec2| (*p * level.scale()).floor();
        places.iter().all(|p| pixel(p) == pixel(&places[0]))
    }

    /// The mean of all of it.
    pub fn whole(&self) -> DVec3 {
        self.whole
    }

    /// What it has at a place.
    pub fn at(&self, place: DVec2, wrap: [Wrap; 2]) -> DVec3 {
        match self.levels.first() {
            Some(level) if is_near(&place) => level.at(place * level.scale(), wrap),
            _ => self.whole,
        }
    }

    /// Its mean over a polygon, times the `shade` there: (0, 0) is its upper left corner, (1, 1) its lower
    /// right one.
    pub fn mean(&self, polygon: &Polygon, wrap: [Wrap; 2], shade: Option<Shade>) -> DVec3 {
        let (area, middle) = polygon.middle();
        let shaded = || shade.map_or(DVec3::ONE, |shade| shade(middle));
        if !polygon.corners().iter().all(is_near) {
            return self.whole * shaded();
        }
        let [low, high] = polygon.bounds();
        let most = shade.map_or(FINEST, |_| FINEST_SHADED);
        let fits = |level: &&Level| ((high - low) * level.scale()).max_element() <= most;
        // What repeats it more often than that sees all of it.
        let Some(level) = self.levels.iter().find(fits) else {
            return self.whole * shaded();
        };
        let scale = level.scale();
        if (low * scale).floor() == (high * scale).floor() {
            return level.at(low * scale, wrap) * shaded();
        }
        let pixels = polygon.map(|p| p * scale);
        let by = |p: DVec2| shade.map_or(DVec3::ONE, |shade| shade(p / scale));
        let shade = shade.map(|_| &by as Shade);
        if area <= 0.5 * LINE * (high - low).max_element().powi(2) {
            level.along(&pixels, wrap, shade)
        } else {
            level.over(&pixels, wrap, shade)
        }
    }
}

fn is_near(p: &DVec2) -> bool {
    p.is_finite() && p.abs().max_element() < FAR
}

/// sRGB decoded (IEC 61966-2-1).
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
    fn ramp(w: usize, h: usize) -> Picture {
        let pixel = |k: usize| [(k % w) as f32, (k / w) as f32, 1.0];
        Picture::new([w, h], (0..w * h).map(pixel).collect())
    }

    fn close(found: DVec3, expected: [f64; 3]) {
        assert!(
            abs_diff_eq!(
                (found - DVec3::from(expected)).length(),
                0.0,
                epsilon = 1e-9
            ),
            "{found} instead of {expected:?}"
        );
    }

    /// The mean over the rectangle from a to b.
    fn rectangle(picture: &Picture, a: [f64; 2], b: [f64; 2], wrap: Wrap) -> DVec3 {
        let places = [[a[0], a[1]], [b[0], a[1]], [b[0], b[1]], [a[0], b[1]]].map(DVec2::from);
        picture.mean(&Polygon::new(places), [wrap; 2], None)
    }

    #[test]
    fn means_are_exact() {
        let picture = ramp(4, 4);
        close(
            rectangle(&picture, [0., 0.], [1., 1.], Wrap::Repeat),
            [1.5, 1.5, 1.],
        );
        // Half of column 1, all of column 2, a quarter of column 3.
        let part = rectangle(&picture, [0.375, 0.5], [0.8125, 0.75], Wrap::Repeat);
        close(part, [(0.5 + 2.0 + 0.75) / 1.75, 2., 1.]);
        // The triangle below the diagonal: column x has x + ½ pixels.
        let places = [[0., 0.], [1., 0.], [1., 1.]].map(DVec2::from);
        let mean = picture.mean(&Polygon::new(places), [Wrap::Repeat; 2], None);
        close(
            mean,
            [
                (1.5 + 5.0 + 10.5) / 8.,
                (3.5 * 0. + 2.5 + 3. + 1.5) / 8.,
                1.,
            ],
        );
    }

    #[test]
    fn beyond_the_edge_it_wraps() {
        let picture = ramp(4, 1);
        for (wrap, expected) in [(Wrap::Repeat, 0.5), (Wrap::Mirror, 2.5), (Wrap::Clamp, 3.0)] {
            let found = rectangle(&picture, [1., 0.], [1.5, 1.], wrap);
            close(found, [expected, 0., 1.]);
        }
        let before = rectangle(&picture, [-0.5, 0.], [0., 1.], Wrap::Repeat);
        close(before, [2.5, 0., 1.]);
    }

    #[test]
    fn points_lines_and_no_numbers_have_a_mean_too() {
        let picture = ramp(4, 4);
        let point = rectangle(&picture, [0.6, 0.3], [0.6, 0.3], Wrap::Repeat);
        close(point, [2., 1., 1.]);
        let line = rectangle(&picture, [0., 0.3], [1., 0.3], Wrap::Repeat);
        assert!((line.x - 1.5).abs() < 0.1 && line.y == 1.0, "{line}");
        for odd in [f64::NAN, f64::INFINITY, 1e30] {
            close(
                rectangle(&picture, [0., 0.], [odd, 1.], Wrap::Repeat),
                [1.5, 1.5, 1.],
            );
        }
    }

    #[test]
    fn large_faces_see_a_coarser_copy() {
        let picture = ramp(3000, 30);
        let whole = rectangle(&picture, [0., 0.], [1., 1.], Wrap::Repeat);
        // Copies are rounded to f32.
        assert!((whole - picture.whole()).length() < 1e-6, "{whole}");
        let part = rectangle(&picture, [0.1, 0.], [0.9, 1.], Wrap::Repeat);
        assert!((part - whole).length() < 1e-3, "{part}");
        close(
            rectangle(&picture, [0., 0.], [1e5, 1.], Wrap::Repeat),
            [1499.5, 14.5, 1.],
        );
    }

    #[test]
    fn sums_of_rows_are_those_of_their_pixels() {
        // Pixels are asked one by one where there is a shade.
        let picture = ramp(70, 40);
        let polygons = [
            vec![[0.11, 0.2], [0.83, 0.31], [0.9, 0.95], [0.3, 0.7]],
            vec![[-1.3, -0.4], [0.1, -0.4], [0.1, 0.6], [-1.3, 0.6]],
            vec![[0.5, 0.5], [1.7, 0.9], [0.6, 2.1]],
        ];
        for wrap in [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp] {
            for corners in &polygons {
                let polygon = Polygon::new(corners.iter().copied().map(DVec2::from));
                let by_rows = picture.mean(&polygon, [wrap; 2], None);
                let by_pixels = picture.mean(&polygon, [wrap; 2], Some(&|_| DVec3::ONE));
                close(by_rows, by_pixels.to_array());
            }
        }
    }

    #[test]
    fn a_shade_multiplies_each_pixel() {
        // ∫ over pixel k of k·x: Σ k (k + ½) / 4 of x in pixels.
        let picture = ramp(4, 1);
        let places = [[0., 0.], [1., 0.], [1., 1.], [0., 1.]].map(DVec2::from);
        let shade = |p: DVec2| DVec3::splat(4.0 * p.x);
        let mean = picture.mean(&Polygon::new(places), [Wrap::Clamp; 2], Some(&shade));
        close(mean, [(1.5 + 5.0 + 10.5) / 4.0, 0., 2.]);
    }

    #[test]
    fn what_is_white_may_be_less() {
        let mut bytes = Cursor::new(Vec::new());
        let image = RgbImage::from_fn(2, 1, |x, _| Rgb([255, 254 + x as u8, 0]));
        image.write_to(&mut bytes, ImageFormat::Png).unwrap();
        let picture = Picture::decode(bytes.get_ref(), [0.5, 1.0, 0.5]).unwrap();
        let light = from_srgb(254.0 / 255.0);
        assert!((picture.whole() - DVec3::new(0.5, (light + 1.0) / 2.0, 0.0)).length() < 1e-6);
        let picture = Picture::decode(bytes.get_ref(), [1.0, 0.5, 0.5]).unwrap();
        assert!((picture.whole().y - (light + 0.5) / 2.0).abs() < 1e-6);
    }

    #[test]
    fn what_is_shrunk_keeps_its_mean() {
        let mut picture = ramp(64, 64);
        assert!(!picture.shrink(64 * 64));
        assert!(picture.shrink(1000) && picture.count() == 16 * 16);
        close(picture.whole(), [31.5, 31.5, 1.]);
        close(
            rectangle(&picture, [0., 0.], [0.5, 1.], Wrap::Repeat),
            [15.5, 31.5, 1.],
        );
        assert!(picture.shrink(0) && picture.count() == 1);
    }

    #[test]
    fn what_is_too_large_is_refused_before_it_is_read() {
        let mut bytes = Cursor::new(Vec::new());
        let image = image::GrayImage::new(1 << 13, (1 << 11) + 1);
        image.write_to(&mut bytes, ImageFormat::Png).unwrap();
        let told = Picture::decode(bytes.get_ref(), [1.0; 3]).err().unwrap();
        assert!(told.starts_with("has 8192×2049 pixels"), "{told}");
    }

    #[test]
    fn files_are_srgb() {
        let mut bytes = Cursor::new(Vec::new());
        let image = RgbImage::from_fn(2, 2, |x, _| Rgb([if x == 0 { 188 } else { 10 }, 255, 0]));
        image.write_to(&mut bytes, ImageFormat::Png).unwrap();
        let bytes = bytes.into_inner();
        let mean = Picture::decode(&bytes, [1.0; 3])
            .map(|picture| picture.whole())
            .unwrap();
        // 188: 0.502886 by IEC 61966-2-1; 10: on its straight part.
        let expected = DVec3::new((0.502_886 + 10.0 / 255.0 / 12.92) / 2.0, 1.0, 0.0);
        assert!((mean - expected).length() < 1e-6, "{mean}");
        for damaged in [&bytes[..bytes.len() / 2], b"GIF89a", b""] {
            assert!(Picture::decode(damaged, [1.0; 3]).is_err());
        }
    }
}
