//! The pixels of a picture, and their sums: means over polygons take a step a row, not one a pixel.

use super::polygon::Polygon;
use glam::{DVec2, DVec3};

/// Pixels from one sum to the next.
const STEP: usize = 32;

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

/// What a picture is multiplied by, linear over its plane.
pub type Shade<'s> = &'s dyn Fn(DVec2) -> DVec3;

/// A picture's pixels.
pub struct Level {
    /// Width and height, one at least.
    pub size: [usize; 2],
    /// Rows from the top.
    pixels: Vec<[f32; 3]>,
    /// Of the pixels of each row before its first, its 33rd, … and after its last one.
    sums: Vec<DVec3>,
}

impl Level {
    /// `pixels` of `size`, rows from the top.
    pub fn new(size: [usize; 2], pixels: Vec<[f32; 3]>) -> Self {
        let mut sums = Vec::with_capacity((size[0].div_ceil(STEP) + 1) * size[1]);
        for row in pixels.chunks(size[0]) {
            let mut sum = DVec3::ZERO;
            sums.push(sum);
            for part in row.chunks(STEP) {
                sum += part.iter().map(light).sum::<DVec3>();
                sums.push(sum);
            }
        }
        Self { size, pixels, sums }
    }

    /// Pixels to the unit, right and downwards.
    pub fn scale(&self) -> DVec2 {
        DVec2::new(self.size[0] as f64, self.size[1] as f64)
    }

    /// How many pixels there are.
    pub fn count(&self) -> usize {
        self.pixels.len()
    }

    /// The mean of all of it.
    pub fn whole(&self) -> DVec3 {
        let rows = (0..self.size[1]).map(|y| self.before(y, self.size[0]));
        rows.sum::<DVec3>() / self.pixels.len().max(1) as f64
    }

    /// The same with half the pixels a side, rounded down; none of a single pixel.
    pub fn half(&self) -> Option<Self> {
        let size = self.size.map(|n| (n / 2).max(1));
        if self.size == [1, 1] {
            return None;
        }
        let [columns, rows] = [0, 1].map(|k| shares(self.size[k], size[k]));
        let pixel = |column: &[(usize, f64)], row: &[(usize, f64)]| {
            let of_row = |(y, share): &(usize, f64)| {
                let pixel = |(x, share): &(usize, f64)| *share * self.pixel(*x, *y);
                *share * column.iter().map(pixel).sum::<DVec3>()
            };
            row.iter().map(of_row).sum::<DVec3>().as_vec3().to_array()
        };
        let row = |row| columns.iter().map(move |column| pixel(column, row));
        Some(Self::new(size, rows.iter().flat_map(|r| row(r)).collect()))
    }

    fn pixel(&self, x: usize, y: usize) -> DVec3 {
        light(&self.pixels[y * self.size[0] + x])
    }

    /// What it has at a place in pixels.
    pub fn at(&self, place: DVec2, wrap: [Wrap; 2]) -> DVec3 {
        let [x, y] = [0, 1].map(|k| wrap[k].index(place[k].floor() as i64, self.size[k]));
        self.pixel(x, y)
    }

    /// The mean over a polygon in pixels: the part of it in each pixel, times that pixel and the shade there.
    pub fn over(&self, polygon: &Polygon, wrap: [Wrap; 2], shade: Option<Shade>) -> DVec3 {
        let (mut sum, mut all) = (DVec3::ZERO, 0.0);
        let [low, high] = polygon.bounds();
        for y in low.y.floor() as i64..=high.y.floor() as i64 {
            let row = polygon.strip(1, y as f64);
            let [left, right] = row.bounds().map(|p| p.x.floor() as i64);
            let [from, to] = match shade {
                None => full(polygon, y),
                Some(_) => [right, left],
            };
            if from < to {
                sum += self.between(wrap, y, [from, to]);
                all += (to - from) as f64;
            }
            for x in left..=right {
                if from < to && (from..to).contains(&x) {
                    continue;
                }
                let (area, middle) = row.strip(0, x as f64).middle();
                let shade = shade.map_or(DVec3::ONE, |shade| shade(middle));
                sum += area * shade * self.at(DVec2::new(x as f64, y as f64), wrap);
                all += area;
            }
        }
        if all > 0.0 {
            sum / all
        } else {
            self.along(polygon, wrap, shade)
        }
    }

    /// The mean over a polygon that is a line or a point.
    pub fn along(&self, polygon: &Polygon, wrap: [Wrap; 2], shade: Option<Shade>) -> DVec3 {
        let n = POINTS;
        let step = |k: usize| (k as f64 + 1.0 / 3.0) / n as f64;
        let (mut sum, mut count) = (DVec3::ZERO, 0);
        for [a, b, c] in polygon.fan() {
            for [i, j] in (0..n).flat_map(|i| (0..n - i).map(move |j| [i, j])) {
                let p = a + (b - a) * step(i) + (c - a) * step(j);
                sum += self.at(p, wrap) * shade.map_or(DVec3::ONE, |shade| shade(p));
                count += 1;
            }
        }
        sum / f64::from(count.max(1))
    }

    /// The sum of row `y` from pixel `from` to before pixel `to`.
    fn between(&self, wrap: [Wrap; 2], y: i64, [from, to]: [i64; 2]) -> DVec3 {
        let y = wrap[1].index(y, self.size[1]);
        self.until(wrap[0], y, to) - self.until(wrap[0], y, from)
    }

    /// The sum from pixel 0 of a row to before pixel `k`, which may lie beyond its ends.
    fn until(&self, wrap: Wrap, y: usize, k: i64) -> DVec3 {
        let n = self.size[0] as i64;
        let before = |k: i64| self.before(y, k as usize);
        let all = before(n);
        match wrap {
            Wrap::Repeat => k.div_euclid(n) as f64 * all + before(k.rem_euclid(n)),
            Wrap::Mirror => {
                let periods = k.div_euclid(2 * n) as f64 * 2.0 * all;
                match k.rem_euclid(2 * n) {
                    there if there <= n => periods + before(there),
                    back => periods + 2.0 * all - before(2 * n - back),
                }
            }
            Wrap::Clamp if k < 0 => k as f64 * self.pixel(0, y),
            Wrap::Clamp if k > n => all + (k - n) as f64 * self.pixel(self.size[0] - 1, y),
            Wrap::Clamp => before(k),
        }
    }

    /// The sum of the first `count` pixels of a row.
    fn before(&self, y: usize, count: usize) -> DVec3 {
        let row = y * self.size[0];
        let steps = count / STEP;
        let rest = &self.pixels[row + steps * STEP..row + count];
        let sums = y * (self.size[0].div_ceil(STEP) + 1);
        self.sums[sums + steps] + rest.iter().map(light).sum::<DVec3>()
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

fn light(pixel: &[f32; 3]) -> DVec3 {
    DVec3::from(pixel.map(f64::from))
}

/// The pixels of row `y` that lie in the polygon as a whole: those between its sides at the row's edges.
fn full(polygon: &Polygon, y: i64) -> [i64; 2] {
    let [Some(above), Some(below)] = [y, y + 1].map(|y| polygon.across(y as f64)) else {
        return [0, 0];
    };
    let [from, to] = [
        above[0].max(below[0]).ceil(),
        above[1].min(below[1]).floor(),
    ];
    [from as i64, to as i64]
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
