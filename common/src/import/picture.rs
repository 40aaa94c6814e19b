//! Pictures of textures, and their mean over a face.

use crate::jpeg;
use glam::{DVec2, DVec3};
use image::error::ImageError;
use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader};
use std::io::Cursor;

/// Pictures of more pixels are refused: 4096².
const MOST: u64 = 1 << 24;

/// A mean is exact over a face of up to so many pixels a side; above, it is taken of a coarser copy, whose
/// pixels are means themselves.
const FINEST: f64 = 256.0;

/// Coordinates further out say nothing: f32 has no digits left for a pixel.
const FAR: f64 = 1e6;

/// Twice the area of a triangle, per square of its size, below which it is a line.
const LINE: f64 = 1e-9;

/// Points a side of a triangle without area at which the picture is looked up instead.
const POINTS: usize = 8;

/// How a picture goes on beyond its edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wrap {
    /// It begins anew.
    Repeat,
    /// It runs back and forth.
    Mirror,
    /// Its last pixel goes on.
    Clamp,
}

/// A picture in linear Rec. 709, and copies of half, a quarter, … of its pixels a side.
pub struct Picture {
    levels: Vec<Level>,
}

struct Level {
    size: [usize; 2],
    /// Rows from the top.
    pixels: Vec<DVec3>,
}

impl Picture {
    /// Decodes a PNG or a JPEG; the error follows the picture's name.
    pub fn decode(bytes: &[u8]) -> Result<Self, String> {
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
        let pixels = picture.pixels().map(|p| DVec3::from(p.0.map(from_srgb)));
        Ok(Self::new(
            [width as usize, height as usize],
            pixels.collect(),
        ))
    }

    /// `size` is one at least either way.
    fn new(size: [usize; 2], pixels: Vec<DVec3>) -> Self {
        let mut levels = vec![Level { size, pixels }];
        while let Some(half) = levels.last().and_then(Level::half) {
            levels.push(half);
        }
        Self { levels }
    }

    /// Its mean over a face, each triangle about corner 0 weighing as much as it is large. `places` are the
    /// face's corners on the picture: (0, 0) is its upper left corner, (1, 1) its lower right one.
    pub fn mean(&self, corners: &[DVec3], places: &[DVec2], wrap: [Wrap; 2]) -> DVec3 {
        let (mut sum, mut all) = (DVec3::ZERO, 0.0);
        let fan = corners.windows(2).zip(places.windows(2)).skip(1);
        for (c, p) in fan {
            let area = (c[0] - corners[0]).cross(c[1] - corners[0]).length();
            if area > 0.0 {
                sum += area * self.over([places[0], p[0], p[1]], wrap);
                all += area;
            }
        }
        if all > 0.0 { sum / all } else { self.whole() }
    }

    /// The mean of all of it.
    pub fn whole(&self) -> DVec3 {
        self.levels.last().map_or(DVec3::ZERO, |level| {
            level.pixels.iter().sum::<DVec3>() / level.pixels.len().max(1) as f64
        })
    }

    fn over(&self, triangle: [DVec2; 3], wrap: [Wrap; 2]) -> DVec3 {
        let near = |p: &DVec2| p.is_finite() && p.abs().max_element() < FAR;
        if !triangle.iter().all(near) {
            return self.whole();
        }
        let [a, b, c] = triangle;
        let span = a.max(b).max(c) - a.min(b).min(c);
        let fits = |level: &&Level| (span * level.scale()).max_element() <= FINEST;
        // What repeats it more often than that sees all of it.
        let Some(level) = self.levels.iter().find(fits) else {
            return self.whole();
        };
        let pixels = triangle.map(|p| p * level.scale());
        if (b - a).perp_dot(c - a).abs() <= LINE * span.max_element().powi(2) {
            level.along(pixels, wrap)
        } else {
            level.over(pixels, wrap)
        }
    }
}

impl Level {
    fn scale(&self) -> DVec2 {
        DVec2::new(self.size[0] as f64, self.size[1] as f64)
    }

    /// The same with half the pixels a side, rounded down; none of a single pixel.
    fn half(&self) -> Option<Self> {
        let size = self.size.map(|n| (n / 2).max(1));
        if self.size == [1, 1] {
            return None;
        }
        let [columns, rows] = [0, 1].map(|k| shares(self.size[k], size[k]));
        let pixel = |column: &[(usize, f64)], row: &[(usize, f64)]| {
            let of_row = |(y, share): &(usize, f64)| {
                let pixel = |(x, share): &(usize, f64)| *share * self.pixels[y * self.size[0] + x];
                *share * column.iter().map(pixel).sum::<DVec3>()
            };
            row.iter().map(of_row).sum()
        };
        let row = |row| columns.iter().map(move |column| pixel(column, row));
        Some(Self {
            size,
            pixels: rows.iter().flat_map(|r| row(r)).collect(),
        })
    }

    fn at(&self, place: [f64; 2], wrap: [Wrap; 2]) -> DVec3 {
        let [x, y] = [0, 1].map(|k| wrap[k].index(place[k].floor() as i64, self.size[k]));
        self.pixels[y * self.size[0] + x]
    }

    /// The mean over a triangle in pixels: the part of it in each pixel, times that pixel.
    fn over(&self, triangle: [DVec2; 3], wrap: [Wrap; 2]) -> DVec3 {
        let (mut sum, mut all) = (DVec3::ZERO, 0.0);
        let [top, bottom] = range(&triangle, 1);
        for y in top..=bottom {
            let row = strip(&triangle, 1, y as f64);
            let [left, right] = range(&row, 0);
            for x in left..=right {
                let area = area(&strip(&row, 0, x as f64));
                sum += area * self.at([x as f64, y as f64], wrap);
                all += area;
            }
        }
        sum / all
    }

    /// The mean over a triangle that is a line or a point.
    fn along(&self, [a, b, c]: [DVec2; 3], wrap: [Wrap; 2]) -> DVec3 {
        let n = POINTS;
        let step = |k: usize| (k as f64 + 1.0 / 3.0) / n as f64;
        let points = (0..n).flat_map(|i| (0..n - i).map(move |j| [i, j]));
        let values = points.map(|[i, j]| {
            let p = a + (b - a) * step(i) + (c - a) * step(j);
            self.at(p.to_array(), wrap)
        });
        values.sum::<DVec3>() / (n * (n + 1) / 2) as f64
    }
}

impl Wrap {
    fn index(self, k: i64, count: usize) -> usize {
        let n = count as i64;
        let inside = match self {
            Self::Repeat => k.rem_euclid(n),
            Self::Mirror => match k.rem_euclid(2 * n) {
                there if there < n => there,
                back => 2 * n - 1 - back,
            },
            Self::Clamp => k.clamp(0, n - 1),
        };
        inside as usize
    }
}

/// Of which pixels each of `to` new ones is made, and by which share.
fn shares(from: usize, to: usize) -> Vec<Vec<(usize, f64)>> {
    let width = from as f64 / to as f64;
    let of = |k: usize| {
        let [low, high] = [k, k + 1].map(|edge| edge as f64 * width);
        let last = (high.ceil() as usize).min(from);
        let share = |x: usize| (high.min(x as f64 + 1.0) - low.max(x as f64)) / width;
        (low as usize..last).map(|x| (x, share(x))).collect()
    };
    (0..to).map(of).collect()
}

/// The first and last pixel along an axis.
fn range(polygon: &[DVec2], axis: usize) -> [i64; 2] {
    let along = || polygon.iter().map(|p| p[axis]);
    let low = along().fold(f64::INFINITY, f64::min);
    let high = along().fold(f64::NEG_INFINITY, f64::max);
    [low.floor() as i64, high.floor() as i64]
}

/// The part of a convex polygon within one pixel along an axis.
fn strip(polygon: &[DVec2], axis: usize, low: f64) -> Vec<DVec2> {
    cut(&cut(polygon, axis, low, 1.0), axis, low + 1.0, -1.0)
}

/// The part of a convex polygon above a limit along an axis, or below it (`side` −1).
fn cut(polygon: &[DVec2], axis: usize, limit: f64, side: f64) -> Vec<DVec2> {
    let mut left = Vec::with_capacity(polygon.len() + 1);
    for (k, p) in polygon.iter().enumerate() {
        let q = polygon[(k + 1) % polygon.len()];
        let [from, to] = [p[axis], q[axis]].map(|x| side * (x - limit));
        if from >= 0.0 {
            left.push(*p);
        }
        if (from < 0.0) != (to < 0.0) {
            left.push(p.lerp(q, from / (from - to)));
        }
    }
    left
}

fn area(polygon: &[DVec2]) -> f64 {
    let Some(first) = polygon.first() else {
        return 0.0;
    };
    let twice = |w: &[DVec2]| (w[0] - *first).perp_dot(w[1] - *first);
    polygon.windows(2).map(twice).sum::<f64>().abs()
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
        let pixel = |k: usize| DVec3::new((k % w) as f64, (k / w) as f64, 1.0);
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

    /// The mean over the rectangle from a to b, in space one by one.
    fn rectangle(picture: &Picture, a: [f64; 2], b: [f64; 2], wrap: Wrap) -> DVec3 {
        let places = [[a[0], a[1]], [b[0], a[1]], [b[0], b[1]], [a[0], b[1]]].map(DVec2::from);
        let corners = [DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y];
        picture.mean(&corners, &places, [wrap; 2])
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
        let corners = [DVec3::ZERO, DVec3::X, DVec3::ONE];
        let mean = picture.mean(&corners, &places, [Wrap::Repeat; 2]);
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
        let picture = ramp(1000, 30);
        let whole = rectangle(&picture, [0., 0.], [1., 1.], Wrap::Repeat);
        close(whole, [499.5, 14.5, 1.]);
        let part = rectangle(&picture, [0.1, 0.], [0.9, 1.], Wrap::Repeat);
        assert!((part - whole).length() < 1e-6, "{part}");
        close(
            rectangle(&picture, [0., 0.], [1e5, 1.], Wrap::Repeat),
            [499.5, 14.5, 1.],
        );
    }

    #[test]
    fn what_is_too_large_is_refused_before_it_is_read() {
        let mut bytes = Cursor::new(Vec::new());
        let image = image::GrayImage::new(1 << 13, (1 << 11) + 1);
        image.write_to(&mut bytes, ImageFormat::Png).unwrap();
        let told = Picture::decode(bytes.get_ref()).err().unwrap();
        assert!(told.starts_with("has 8192×2049 pixels"), "{told}");
    }

    #[test]
    fn files_are_srgb() {
        let mut bytes = Cursor::new(Vec::new());
        let image = RgbImage::from_fn(2, 2, |x, _| Rgb([if x == 0 { 188 } else { 10 }, 255, 0]));
        image.write_to(&mut bytes, ImageFormat::Png).unwrap();
        let bytes = bytes.into_inner();
        let mean = Picture::decode(&bytes)
            .map(|picture| picture.whole())
            .unwrap();
        // 188: 0.502886 by IEC 61966-2-1; 10: on its straight part.
        let expected = DVec3::new((0.502_886 + 10.0 / 255.0 / 12.92) / 2.0, 1.0, 0.0);
        assert!((mean - expected).length() < 1e-6, "{mean}");
        for damaged in [&bytes[..bytes.len() / 2], b"GIF89a", b""] {
            assert!(Picture::decode(damaged).is_err());
        }
    }
}
