//! Texture pictures and their exact means over polygons, by integrals along the outline. [`crate::paint`] averages
//! textures over texels by them.
//!
//! ```text
//! ∫∫ c dx dy = ∮ C dy        C(x, y) = ∫₀ˣ c(t, y) dt
//! ```
//! c is constant on a pixel. So C is linear within a pixel, and on each part of an edge between two pixel lines
//! the integral is C at its middle times its height.

use crate::jpeg;
use glam::{DVec2, DVec3};
use image::error::ImageError;
use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader};
use std::io::Cursor;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Largest accepted number of pixels: 4096².
const MAX_PICTURE_PIXELS: u64 = 1 << 24;

/// Pixels per side up to which a polygon's mean is computed; beyond, it repeats the picture 64 times or more and
/// has the mean of the whole picture.
const MAX_POLYGON_SIDE: f64 = (1 << 18) as f64;

/// Texture coordinates from here on are ignored: f32 has no digits left for a pixel.
const MAX_COORDINATE: f64 = 1e6;

/// A polygon counts as a line below this area, per square of its size.
const MIN_POLYGON_AREA: f64 = 1e-9;

/// Pixels between two stored prefix sums of a row.
const SUM_STRIDE: usize = 32;

/// Continuation of a picture beyond its edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WrapMode {
    /// The picture repeats.
    Repeat,
    /// The picture alternates with its mirror image.
    Mirror,
    /// The last pixel continues.
    Clamp,
}

impl WrapMode {
    fn index(self, k: i64, count: usize) -> usize {
        let n = count as i64;
        let inside = match self {
            Self::Repeat => k.rem_euclid(n),
            Self::Mirror => match k.rem_euclid(2 * n) {
                forward if forward < n => forward,
                back => 2 * n - 1 - back,
            },
            Self::Clamp => k.clamp(0, n - 1),
        };
        inside as usize
    }
}

/// A picture in linear Rec. 709.
pub struct TexturePicture {
    /// Width and height, at least 1.
    size: [usize; 2],
    /// Rows from the top.
    pixels: Vec<[f32; 3]>,
    /// Prefix sums of each row: before its first pixel, its 33rd, …, and after its last one.
    sums: Vec<DVec3>,
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
        let format = reader.format();
        match format {
            Some(ImageFormat::Png | ImageFormat::WebP) => {}
            Some(ImageFormat::Jpeg) => jpeg::check_whole(bytes)?,
            _ => return Err("is neither PNG, JPEG nor WebP: convert it".into()),
        }
        let of = |e: ImageError| damaged(&e);
        let decoder = reader.into_decoder().map_err(of)?;
        let (width, height) = decoder.dimensions();
        if u64::from(width) * u64::from(height) > MAX_PICTURE_PIXELS {
            return Err(format!(
                "has {width}×{height} pixels, more than 4096×4096: scale it down"
            ));
        }
        if format == Some(ImageFormat::Jpeg) {
            jpeg::check_sides((width, height))?;
        }
        // The decoder may panic on a damaged file; the error is the file's.
        let decoded = catch_unwind(AssertUnwindSafe(|| DynamicImage::from_decoder(decoder)));
        let decoded = decoded.map_err(|_| damaged(&"it is damaged"))?;
        let picture = decoded.map_err(of)?.into_rgb32f();
        let mut white = false;
        let mut lower = |(x, maximum): (f32, f32)| {
            let linear = from_srgb(x) as f32;
            let is_white = linear > maximum && linear == 1.0;
            white |= is_white;
            if is_white { maximum } else { linear }
        };
        let pixels = picture.pixels().map(|pixel| {
            let [r, g, b] = pixel.0;
            [(r, maxima[0]), (g, maxima[1]), (b, maxima[2])].map(&mut lower)
        });
        let pixels = pixels.collect();
        let picture = Self::new([width as usize, height as usize], pixels);
        Ok(Self { white, ..picture })
    }

    /// Makes a picture from pixels in linear Rec. 709, rows from the top; `size` is at least 1×1.
    pub fn new(size: [usize; 2], pixels: Vec<[f32; 3]>) -> Self {
        let mut sums = Vec::with_capacity((size[0].div_ceil(SUM_STRIDE) + 1) * size[1]);
        let mut whole = DVec3::ZERO;
        for row in pixels.chunks(size[0]) {
            let mut sum = DVec3::ZERO;
            sums.push(sum);
            for part in row.chunks(SUM_STRIDE) {
                sum += part.iter().map(widen_pixel).sum::<DVec3>();
                sums.push(sum);
            }
            whole += sum;
        }
        Self {
            whole: whole / pixels.len().max(1) as f64,
            size,
            pixels,
            sums,
            white: false,
        }
    }

    /// Returns the number of pixels.
    pub fn pixel_count(&self) -> usize {
        self.pixels.len()
    }

    /// Halves the resolution until the picture has at most `max_pixels`. Returns true if it had more.
    pub fn shrink_to(&mut self, max_pixels: usize) -> bool {
        let is_larger = self.pixel_count() > max_pixels.max(1);
        while self.pixel_count() > max_pixels.max(1) {
            let (whole, white) = (self.whole, self.white);
            *self = Self {
                whole,
                white,
                ..self.half_resolution()
            };
        }
        is_larger
    }

    /// Returns the picture with half the pixels per side, rounded down; each is the mean over its place.
    fn half_resolution(&self) -> Self {
        let [w, h] = self.size.map(|n| (n / 2).max(1));
        let pixel = |k: usize| {
            let [left, top] = [(k % w) as f64 / w as f64, (k / w) as f64 / h as f64];
            let [right, bottom] = [(k % w + 1) as f64 / w as f64, (k / w + 1) as f64 / h as f64];
            let place = [[left, top], [right, top], [right, bottom], [left, bottom]].map(DVec2::from);
            let mean = self.mean_over(&place, [WrapMode::Clamp; 2]);
            mean.as_vec3().to_array()
        };
        Self::new([w, h], (0..w * h).map(pixel).collect())
    }

    /// Returns whether a value of 1 was lowered on decoding.
    pub fn was_white(&self) -> bool {
        self.white
    }

    /// Returns whether the picture is constant on a polygon: it lies within one pixel, or its coordinates are
    /// ignored.
    pub fn is_uniform(&self, places: &[DVec2]) -> bool {
        let pixel = |p: &DVec2| (*p * self.pixels_per_unit()).floor();
        !places.iter().all(is_in_range) || places.iter().all(|p| pixel(p) == pixel(&places[0]))
    }

    /// Returns the mean over the whole picture.
    pub fn mean_colour(&self) -> DVec3 {
        self.whole
    }

    /// Returns the colour at a position; (0, 0) is the upper left corner, (1, 1) the lower right one.
    pub fn colour_at(&self, place: DVec2, wrap: [WrapMode; 2]) -> DVec3 {
        if !is_in_range(&place) {
            return self.whole;
        }
        self.wrapped_pixel(place * self.pixels_per_unit(), wrap)
    }

    /// Returns the mean over a polygon, or over its outline if it is a line; coordinates as in
    /// [`TexturePicture::colour_at`].
    pub fn mean_over(&self, polygon: &[DVec2], wrap: [WrapMode; 2]) -> DVec3 {
        if !polygon.iter().all(is_in_range) {
            return self.whole;
        }
        let corners: Vec<DVec2> = polygon.iter().map(|p| *p * self.pixels_per_unit()).collect();
        let low = corners.iter().copied().fold(DVec2::INFINITY, DVec2::min);
        let high = corners.iter().copied().fold(DVec2::NEG_INFINITY, DVec2::max);
        let side = (high - low).max_element();
        if low.floor() == high.floor() {
            return self.wrapped_pixel(low, wrap);
        } else if side > MAX_POLYGON_SIDE {
            return self.whole;
        }
        let area = signed_area(&corners);
        let is_line = area.abs() <= MIN_POLYGON_AREA * side * side;
        let (mut sum, mut all) = (DVec3::ZERO, area);
        if is_line {
            all = 0.0;
        }
        let ends = corners.iter().zip(corners.iter().cycle().skip(1));
        for (from, to) in ends.flat_map(|(a, b)| divide_by_pixel_lines(*a, *b)) {
            let middle = from.midpoint(to);
            if is_line {
                sum += from.distance(to) * self.wrapped_pixel(middle, wrap);
                all += from.distance(to);
            } else {
                sum += (to.y - from.y) * self.row_integral(middle, wrap);
            }
        }
        sum / all
    }

    fn pixels_per_unit(&self) -> DVec2 {
        DVec2::new(self.size[0] as f64, self.size[1] as f64)
    }

    /// Returns the colour of the pixel that holds a position in pixels.
    fn wrapped_pixel(&self, place: DVec2, wrap: [WrapMode; 2]) -> DVec3 {
        let [x, y] = [0, 1].map(|k| wrap[k].index(place[k].floor() as i64, self.size[k]));
        widen_pixel(&self.pixels[y * self.size[0] + x])
    }

    /// Returns the integral of the row at a position from column 0 to it.
    fn row_integral(&self, place: DVec2, wrap: [WrapMode; 2]) -> DVec3 {
        let column = place.x.floor();
        let row = wrap[1].index(place.y.floor() as i64, self.size[1]);
        let whole_pixels = self.wrapped_prefix_sum(wrap[0], row, column as i64);
        whole_pixels + (place.x - column) * self.wrapped_pixel(place, wrap)
    }

    /// Returns the sum from pixel 0 of a row to before pixel `k`, which may lie beyond the row's ends.
    fn wrapped_prefix_sum(&self, wrap: WrapMode, y: usize, k: i64) -> DVec3 {
        let n = self.size[0] as i64;
        let before = |k: i64| self.prefix_sum(y, k as usize);
        let pixel = |x: i64| before(x + 1) - before(x);
        match wrap {
            WrapMode::Repeat => k.div_euclid(n) as f64 * before(n) + before(k.rem_euclid(n)),
            WrapMode::Mirror => {
                let periods = k.div_euclid(2 * n) as f64 * 2.0 * before(n);
                match k.rem_euclid(2 * n) {
                    forward if forward <= n => periods + before(forward),
                    back => periods + 2.0 * before(n) - before(2 * n - back),
                }
            }
            WrapMode::Clamp if k < 0 => k as f64 * pixel(0),
            WrapMode::Clamp if k > n => before(n) + (k - n) as f64 * pixel(n - 1),
            WrapMode::Clamp => before(k),
        }
    }

    /// Returns the sum of the first `count` pixels of a row.
    fn prefix_sum(&self, y: usize, count: usize) -> DVec3 {
        let row = y * self.size[0];
        let steps = count / SUM_STRIDE;
        let rest = &self.pixels[row + steps * SUM_STRIDE..row + count];
        let sums = y * (self.size[0].div_ceil(SUM_STRIDE) + 1);
        self.sums[sums + steps] + rest.iter().map(widen_pixel).sum::<DVec3>()
    }
}

/// Returns the parts into which the lines between pixels divide a segment.
fn divide_by_pixel_lines(a: DVec2, b: DVec2) -> Vec<(DVec2, DVec2)> {
    let way = b - a;
    let crossings = |k: usize| {
        let [low, high] = [a[k].min(b[k]), a[k].max(b[k])];
        let lines = low.floor() as i64 + 1..high.ceil() as i64;
        lines.map(move |line| (line as f64 - a[k]) / way[k])
    };
    let mut cuts: Vec<f64> = crossings(0).chain(crossings(1)).chain([1.0]).collect();
    cuts.sort_by(f64::total_cmp);
    let mut from = a;
    let parts = cuts.into_iter().map(|t| {
        let start = from;
        from = a + way * t;
        (start, from)
    });
    parts.collect()
}

/// Returns the area of a polygon, negative if its corners run clockwise (y upwards).
pub fn signed_area(polygon: &[DVec2]) -> f64 {
    let twice = triangle_fan(polygon).map(|[a, b, c]| (b - a).perp_dot(c - a));
    0.5 * twice.sum::<f64>()
}

/// Iterates over the triangles of a fan around a convex polygon's first corner.
pub fn triangle_fan(polygon: &[DVec2]) -> impl Iterator<Item = [DVec2; 3]> {
    let pairs = polygon.windows(2).skip(1);
    pairs.map(|pair| [polygon[0], pair[0], pair[1]])
}

fn widen_pixel(pixel: &[f32; 3]) -> DVec3 {
    DVec3::from(pixel.map(f64::from))
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
        picture.mean_over(&places, [wrap; 2])
    }

    #[test]
    fn mean_over_rectangle_is_exact() {
        use WrapMode::{Clamp, Mirror, Repeat};
        let (square, row, wide) = (ramp(4, 4), ramp(4, 1), ramp(3000, 30));
        let (of_square, of_wide) = ([1.5, 1.5, 1.], [1499.5, 14.5, 1.]);
        for (picture, a, b, wrap, expected) in [
            (&square, [0., 0.], [1., 1.], Repeat, of_square),
            // Half of column 1, all of column 2, a quarter of column 3.
            (&square, [0.375, 0.5], [0.8125, 0.75], Repeat, [3.25 / 1.75, 2., 1.]),
            // Beyond the edge.
            (&row, [1., 0.], [1.5, 1.], Repeat, [0.5, 0., 1.]),
            (&row, [1., 0.], [1.5, 1.], Mirror, [2.5, 0., 1.]),
            (&row, [1., 0.], [1.5, 1.], Clamp, [3.0, 0., 1.]),
            (&row, [-0.5, 0.], [0., 1.], Repeat, [2.5, 0., 1.]),
            // A point and a line.
            (&square, [0.6, 0.3], [0.6, 0.3], Repeat, [2., 1., 1.]),
            (&square, [0., 0.3], [1., 0.3], Repeat, [1.5, 1., 1.]),
            // Coordinates that are ignored.
            (&square, [0., 0.], [f64::NAN, 1.], Repeat, of_square),
            (&square, [0., 0.], [f64::INFINITY, 1.], Repeat, of_square),
            (&square, [0., 0.], [1e30, 1.], Repeat, of_square),
            // Many pixels, and 10⁵ repetitions.
            (&wide, [0., 0.], [1., 1.], Repeat, of_wide),
            (&wide, [0.1, 0.], [0.9, 1.], Repeat, of_wide),
            (&wide, [0., 0.], [1e5, 1.], Repeat, of_wide),
        ] {
            close(rectangle(picture, a, b, wrap), expected);
        }
        assert_eq!(wide.mean_colour().to_array(), of_wide);
        // The triangle below the diagonal: column x has x + ½ pixels.
        let places = [[0., 0.], [1., 0.], [1., 1.]].map(DVec2::from);
        let mean = square.mean_over(&places, [Repeat; 2]);
        close(mean, [(1.5 + 5.0 + 10.5) / 8., (2.5 + 3. + 1.5) / 8., 1.]);
    }

    #[test]
    fn mean_over_polygon_equals_mean_of_its_samples() {
        // 512² samples of each triangle of its fan: half a step along a line between pixels is off by their difference.
        let picture = ramp(7, 4);
        let polygons = [
            vec![[0.11, 0.2], [0.83, 0.31], [0.9, 0.95], [0.3, 0.7]],
            vec![[-1.3, 0.6], [0.1, 0.6], [0.1, -0.4], [-1.3, -0.4]],
            vec![[0.5, 0.5], [1.7, 0.9], [0.6, 2.1]],
        ];
        for wrap in [WrapMode::Repeat, WrapMode::Mirror, WrapMode::Clamp] {
            for corners in &polygons {
                let corners: Vec<DVec2> = corners.iter().copied().map(DVec2::from).collect();
                let (mut sum, mut all) = (DVec3::ZERO, 0.0);
                for [a, b, c] in triangle_fan(&corners) {
                    let share = |k: usize| (k as f64 + 1.0 / 3.0) / 512.0;
                    for [u, v] in (0..512).flat_map(|i| (0..512 - i).map(move |j| [i, j].map(share))) {
                        let area = signed_area(&[a, b, c]);
                        sum += area * picture.colour_at(a + (b - a) * u + (c - a) * v, [wrap; 2]);
                        all += area;
                    }
                }
                let exact = picture.mean_over(&corners, [wrap; 2]);
                assert!((exact - sum / all).length() < 0.02, "{wrap:?} {exact} {}", sum / all);
            }
        }
    }

    /// A PNG of two pixels.
    fn png_bytes(left: [u8; 3], right: [u8; 3]) -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        let image = RgbImage::from_fn(2, 1, |x, _| Rgb(if x == 0 { left } else { right }));
        image.write_to(&mut bytes, ImageFormat::Png).unwrap();
        bytes.into_inner()
    }

    #[test]
    fn white_is_lowered_to_the_given_maximum() {
        let bytes = png_bytes([255, 254, 0], [255, 255, 0]);
        let picture = TexturePicture::decode_image(&bytes, [0.5, 1.0, 0.5]).unwrap();
        let light = from_srgb(254.0 / 255.0);
        assert!((picture.mean_colour() - DVec3::new(0.5, (light + 1.0) / 2.0, 0.0)).length() < 1e-6);
        let picture = TexturePicture::decode_image(&bytes, [1.0, 0.5, 0.5]).unwrap();
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
        let bytes = png_bytes([188, 255, 0], [10, 255, 0]);
        let mean = TexturePicture::decode_image(&bytes, [1.0; 3]).unwrap().mean_colour();
        // 188: 0.502886 by IEC 61966-2-1; 10: on its straight part.
        let expected = DVec3::new((0.502_886 + 10.0 / 255.0 / 12.92) / 2.0, 1.0, 0.0);
        assert!((mean - expected).length() < 1e-6, "{mean}");
        for damaged in [&bytes[..bytes.len() / 2], b"GIF89a", b""] {
            assert!(TexturePicture::decode_image(damaged, [1.0; 3]).is_err());
        }
    }
}
