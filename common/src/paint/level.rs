//! One resolution level of a picture, with prefix sums of its rows: the mean over a polygon takes one step
//! per row instead of one per pixel.

use super::polygon::PlanePolygon;
use glam::{DVec2, DVec3};

/// Pixels between two stored prefix sums.
const SUM_STRIDE: usize = 32;

/// Sample points per side of a triangle without area.
const POINTS_PER_SIDE: usize = 8;

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

/// A factor on a picture, linear over its plane.
pub type Shade<'s> = &'s dyn Fn(DVec2) -> DVec3;

/// A picture's pixels at one resolution.
pub struct MipLevel {
    /// Width and height, at least 1.
    pub size: [usize; 2],
    /// Rows from the top.
    pixels: Vec<[f32; 3]>,
    /// Prefix sums of each row: before its first pixel, its 33rd, …, and after its last one.
    sums: Vec<DVec3>,
}

impl MipLevel {
    /// Makes a level from `pixels` of `size`, rows from the top.
    pub fn new(size: [usize; 2], pixels: Vec<[f32; 3]>) -> Self {
        let mut sums = Vec::with_capacity((size[0].div_ceil(SUM_STRIDE) + 1) * size[1]);
        for row in pixels.chunks(size[0]) {
            let mut sum = DVec3::ZERO;
            sums.push(sum);
            for part in row.chunks(SUM_STRIDE) {
                sum += part.iter().map(widen_pixel).sum::<DVec3>();
                sums.push(sum);
            }
        }
        Self { size, pixels, sums }
    }

    /// Pixels per unit, right and downwards.
    pub fn pixels_per_unit(&self) -> DVec2 {
        DVec2::new(self.size[0] as f64, self.size[1] as f64)
    }

    /// Number of pixels.
    pub fn pixel_count(&self) -> usize {
        self.pixels.len()
    }

    /// Mean over all pixels.
    pub fn mean_colour(&self) -> DVec3 {
        let rows = (0..self.size[1]).map(|y| self.prefix_sum(y, self.size[0]));
        rows.sum::<DVec3>() / self.pixels.len().max(1) as f64
    }

    /// Returns the level with half the pixels per side, rounded down; `None` for a single pixel.
    pub fn half_resolution(&self) -> Option<Self> {
        let size = self.size.map(|n| (n / 2).max(1));
        if self.size == [1, 1] {
            return None;
        }
        let [columns, rows] = [0, 1].map(|k| resampling_weights(self.size[k], size[k]));
        let pixel = |column: &[(usize, f64)], row: &[(usize, f64)]| {
            let of_row = |(y, share): &(usize, f64)| {
                let pixel = |(x, share): &(usize, f64)| *share * self.pixel_colour(*x, *y);
                *share * column.iter().map(pixel).sum::<DVec3>()
            };
            row.iter().map(of_row).sum::<DVec3>().as_vec3().to_array()
        };
        let row = |row| columns.iter().map(move |column| pixel(column, row));
        Some(Self::new(size, rows.iter().flat_map(|r| row(r)).collect()))
    }

    fn pixel_colour(&self, x: usize, y: usize) -> DVec3 {
        widen_pixel(&self.pixels[y * self.size[0] + x])
    }

    /// Colour at a position in pixels.
    pub fn colour_at(&self, place: DVec2, wrap: [WrapMode; 2]) -> DVec3 {
        let [x, y] = [0, 1].map(|k| wrap[k].index(place[k].floor() as i64, self.size[k]));
        self.pixel_colour(x, y)
    }

    /// Mean over a polygon in pixels: each pixel is weighted by the polygon's area in it, and multiplied by
    /// the shade there.
    pub fn mean_over(&self, polygon: &PlanePolygon, wrap: [WrapMode; 2], shade: Option<Shade>) -> DVec3 {
        let (mut sum, mut all) = (DVec3::ZERO, 0.0);
        let [low, high] = polygon.bounding_box();
        for y in low.y.floor() as i64..=high.y.floor() as i64 {
            let row = polygon.unit_strip(1, y as f64);
            let [left, right] = row.bounding_box().map(|p| p.x.floor() as i64);
            let [from, to] = match shade {
                None => full_pixels(polygon, y),
                Some(_) => [right, left],
            };
            if from < to {
                sum += self.sum_between(wrap, y, [from, to]);
                all += (to - from) as f64;
            }
            for x in left..=right {
                if from < to && (from..to).contains(&x) {
                    continue;
                }
                let (area, middle) = row.unit_strip(0, x as f64).area_and_centroid();
                let shade = shade.map_or(DVec3::ONE, |shade| shade(middle));
                sum += area * shade * self.colour_at(DVec2::new(x as f64, y as f64), wrap);
                all += area;
            }
        }
        if all > 0.0 {
            sum / all
        } else {
            self.mean_along(polygon, wrap, shade)
        }
    }

    /// Mean over a polygon that is a line or a point, by samples.
    pub fn mean_along(&self, polygon: &PlanePolygon, wrap: [WrapMode; 2], shade: Option<Shade>) -> DVec3 {
        let n = POINTS_PER_SIDE;
        let step = |k: usize| (k as f64 + 1.0 / 3.0) / n as f64;
        let (mut sum, mut count) = (DVec3::ZERO, 0);
        for [a, b, c] in polygon.triangle_fan() {
            for [i, j] in (0..n).flat_map(|i| (0..n - i).map(move |j| [i, j])) {
                let p = a + (b - a) * step(i) + (c - a) * step(j);
                sum += self.colour_at(p, wrap) * shade.map_or(DVec3::ONE, |shade| shade(p));
                count += 1;
            }
        }
        sum / f64::from(count.max(1))
    }

    /// Sum of row `y` from pixel `from` to before pixel `to`.
    fn sum_between(&self, wrap: [WrapMode; 2], y: i64, [from, to]: [i64; 2]) -> DVec3 {
        let y = wrap[1].index(y, self.size[1]);
        self.wrapped_prefix_sum(wrap[0], y, to) - self.wrapped_prefix_sum(wrap[0], y, from)
    }

    /// Sum from pixel 0 of a row to before pixel `k`, which may lie beyond the row's ends.
    fn wrapped_prefix_sum(&self, wrap: WrapMode, y: usize, k: i64) -> DVec3 {
        let n = self.size[0] as i64;
        let before = |k: i64| self.prefix_sum(y, k as usize);
        let all = before(n);
        match wrap {
            WrapMode::Repeat => k.div_euclid(n) as f64 * all + before(k.rem_euclid(n)),
            WrapMode::Mirror => {
                let periods = k.div_euclid(2 * n) as f64 * 2.0 * all;
                match k.rem_euclid(2 * n) {
                    forward if forward <= n => periods + before(forward),
                    back => periods + 2.0 * all - before(2 * n - back),
                }
            }
            WrapMode::Clamp if k < 0 => k as f64 * self.pixel_colour(0, y),
            WrapMode::Clamp if k > n => all + (k - n) as f64 * self.pixel_colour(self.size[0] - 1, y),
            WrapMode::Clamp => before(k),
        }
    }

    /// Sum of the first `count` pixels of a row.
    fn prefix_sum(&self, y: usize, count: usize) -> DVec3 {
        let row = y * self.size[0];
        let steps = count / SUM_STRIDE;
        let rest = &self.pixels[row + steps * SUM_STRIDE..row + count];
        let sums = y * (self.size[0].div_ceil(SUM_STRIDE) + 1);
        self.sums[sums + steps] + rest.iter().map(widen_pixel).sum::<DVec3>()
    }
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

fn widen_pixel(pixel: &[f32; 3]) -> DVec3 {
    DVec3::from(pixel.map(f64::from))
}

/// Returns the range of pixels of row `y` that lie wholly in the polygon, between its sides at the row's
/// edges.
fn full_pixels(polygon: &PlanePolygon, y: i64) -> [i64; 2] {
    let [Some(above), Some(below)] = [y, y + 1].map(|y| polygon.range_at_height(y as f64)) else {
        return [0, 0];
    };
    let [from, to] = [above[0].max(below[0]).ceil(), above[1].min(below[1]).floor()];
    [from as i64, to as i64]
}

/// Returns for each of `to` new pixels the old ones that it covers and their weights.
fn resampling_weights(from: usize, to: usize) -> Vec<Vec<(usize, f64)>> {
    let width = from as f64 / to as f64;
    let of = |k: usize| {
        let [low, high] = [k, k + 1].map(|edge| edge as f64 * width);
        let last = (high.ceil() as usize).min(from);
        let share = |x: usize| (high.min(x as f64 + 1.0) - low.max(x as f64)) / width;
        (low as usize..last).map(|x| (x, share(x))).collect()
    };
    (0..to).map(of).collect()
}
