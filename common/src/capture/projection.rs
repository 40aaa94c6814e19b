//! Where a direction lies on a map, and what a pixel spans.
//!
//! Directions: y is up, the map's centre looks along +z. So right of the centre is −x, and +x is a
//! quarter turn to the *left* of it in a lat-long map; OpenEXR has the same convention. Map positions
//! are in pixels from the upper left corner: pixel (x, y) covers [x, x+1] × [y, y+1]. (OpenEXR's
//! own functions let the centres of the outermost pixels lie on the seam; most maps are made, and
//! read here, with the pixels' areas filling the sphere. The two differ by at most half a pixel.)
//!
//! | Projection | Size | Position of a direction |
//! |---|---|---|
//! | lat-long | 2:1 by default | x by longitude atan2(dx, dz), from +π at the left to −π; y by latitude, +π/2 at the top |
//! | cube | 1:6 | squares from top to bottom +x −x +y −y +z −z, each as seen from within, upright; +y has +z at its top, −y has −z |
//! | angular | 1:1 | centre +z, distance from the centre = angle/π of the half width, right and up as in the lat-long; nothing outside the disc |

use glam::{DVec2, DVec3};
use std::f64::consts::{PI, TAU};

/// How the sphere of directions is spread on a rectangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Projection {
    /// Longitude and latitude.
    LatLong,
    /// Six squares, one below the other.
    Cube,
    /// Debevec's angular map, "light probe".
    Angular,
}

/// Samples a side by which an angular pixel's solid angle is measured.
const SAMPLES: usize = 8;

/// Forward, right and up of a cube map's squares.
const SQUARES: [[DVec3; 3]; 6] = [
    [DVec3::X, DVec3::Z, DVec3::Y],
    [DVec3::NEG_X, DVec3::NEG_Z, DVec3::Y],
    [DVec3::Y, DVec3::X, DVec3::Z],
    [DVec3::NEG_Y, DVec3::X, DVec3::NEG_Z],
    [DVec3::Z, DVec3::NEG_X, DVec3::Y],
    [DVec3::NEG_Z, DVec3::X, DVec3::Y],
];

impl Projection {
    /// The option's value of this name.
    pub fn name(self) -> &'static str {
        match self {
            Self::LatLong => "latlong",
            Self::Cube => "cube",
            Self::Angular => "angular",
        }
    }

    /// What a map of this size (width, height) is taken for.
    pub fn of_size([w, h]: [usize; 2]) -> Option<Self> {
        match () {
            () if w == 2 * h => Some(Self::LatLong),
            () if h == 6 * w => Some(Self::Cube),
            () if w == h => Some(Self::Angular),
            () => None,
        }
    }

    /// Whether a map of this size can have this projection; a lat-long map may have any.
    pub fn fits(self, [w, h]: [usize; 2]) -> bool {
        match self {
            Self::LatLong => true,
            Self::Cube => h == 6 * w,
            Self::Angular => w == h,
        }
    }

    /// The direction (unit length) at `position` of a map of `size`, both in pixels.
    ///
    /// Outside an angular map's disc it goes on beyond −z; outside a cube map's squares, sideways,
    /// on the square's plane.
    pub fn direction(self, size: [usize; 2], position: DVec2) -> DVec3 {
        let square = (position.y / size[0] as f64).floor().clamp(0.0, 5.0) as usize;
        self.direction_on(size, square, position)
    }

    /// As [`Projection::direction`]; on a cube map's border `square` says which one is meant.
    pub(super) fn direction_on(self, size: [usize; 2], square: usize, at: DVec2) -> DVec3 {
        let [w, h] = size.map(|n| n as f64);
        match self {
            Self::LatLong => {
                let (sin, cos) = ((0.5 - at.x / w) * TAU).sin_cos();
                let (up, flat) = ((0.5 - at.y / h) * PI).sin_cos();
                DVec3::new(sin * flat, up, cos * flat)
            }
            Self::Cube => {
                let [forward, right, up] = SQUARES[square];
                let s = 2.0 * at.x / w - 1.0;
                let t = 1.0 - 2.0 * (at.y / w - square as f64);
                (forward + right * s + up * t).normalize()
            }
            Self::Angular => {
                let p = DVec2::new(2.0 * at.x / w - 1.0, 1.0 - 2.0 * at.y / h);
                let r = p.length();
                let (sin, cos) = (r * PI).sin_cos();
                let flat = if r > 0.0 { p / r * sin } else { DVec2::ZERO };
                DVec3::new(-flat.x, flat.y, cos)
            }
        }
    }

    /// The position, in pixels, of `direction` (any length above 0) on a map of `size`.
    pub fn position(self, size: [usize; 2], direction: DVec3) -> DVec2 {
        let [w, h] = size.map(|n| n as f64);
        let d = direction;
        match self {
            Self::LatLong => {
                let longitude = d.x.atan2(d.z);
                let latitude = d.y.atan2(d.x.hypot(d.z));
                DVec2::new((0.5 - longitude / TAU) * w, (0.5 - latitude / PI) * h)
            }
            Self::Cube => {
                let square = square(d);
                let [forward, right, up] = SQUARES[square];
                let f = d.dot(forward);
                let s = d.dot(right) / f;
                let t = d.dot(up) / f;
                let (top, next) = (square as f64 * w, (square + 1) as f64 * w);
                // Its lower edge must not become the next square's upper edge.
                let y = (top + (1.0 - t) / 2.0 * w).min(next.next_down());
                DVec2::new((s + 1.0) / 2.0 * w, y)
            }
            Self::Angular => {
                let flat = DVec2::new(-d.x, d.y);
                let r = flat.length().atan2(d.z) / PI;
                // All of the rim is −z; any of its points will do.
                let p = flat.try_normalize().unwrap_or(DVec2::X) * r;
                DVec2::new((1.0 + p.x) / 2.0 * w, (1.0 - p.y) / 2.0 * h)
            }
        }
    }

    /// The solid angle (sr) of pixel (x, y): exact for lat-long (rows between parallels) and cube
    /// (corner formula); for angular the integral of (π sin θ / r), the map's Jacobian, by 8×8
    /// points of which those outside the disc count nothing.
    pub fn solid_angle(self, size: [usize; 2], [x, y]: [usize; 2]) -> f64 {
        let [w, h] = size.map(|n| n as f64);
        match self {
            Self::LatLong => {
                let parallel = |y: usize| ((0.5 - y as f64 / h) * PI).sin();
                TAU / w * (parallel(y) - parallel(y + 1))
            }
            Self::Cube => {
                let n = size[0];
                let edge = |k: usize| 2.0 * k as f64 / w - 1.0;
                let ([s, u], [t, v]) = ([edge(x), edge(x + 1)], [edge(y % n), edge(y % n + 1)]);
                let corner = |a: f64, b: f64| (a * b).atan2((a * a + b * b + 1.0).sqrt());
                corner(u, v) - corner(s, v) - corner(u, t) + corner(s, t)
            }
            Self::Angular => {
                let at = |k: usize, i: usize| {
                    2.0 * (k as f64 + (i as f64 + 0.5) / SAMPLES as f64) / w - 1.0
                };
                let area = (2.0 / (w * SAMPLES as f64)).powi(2);
                let mut sum = 0.0;
                for (i, j) in (0..SAMPLES).flat_map(|j| (0..SAMPLES).map(move |i| (i, j))) {
                    let r = at(x, i).hypot(at(y, j));
                    if r < 1.0 {
                        sum += if r > 0.0 {
                            (PI * r).sin() * PI / r
                        } else {
                            PI * PI
                        };
                    }
                }
                sum * area
            }
        }
    }
}

/// The cube map's square that shows `d`.
fn square(d: DVec3) -> usize {
    let a = d.abs();
    let axis = match () {
        () if a.x >= a.y && a.x >= a.z => 0,
        () if a.y >= a.z => 1,
        () => 2,
    };
    2 * axis + usize::from(d[axis] < 0.0)
}
