//! Projections of the sphere of directions on a map: positions, directions and solid angles.
//!
//! Directions: y is up, the map's centre looks along +z. So right of the centre is −x, and +x is a
//! quarter turn to the *left* of it in a lat-long map; OpenEXR has the same convention. Map positions
//! are in pixels from the upper left corner: pixel (x, y) covers [x, x+1] × [y, y+1]. (OpenEXR's
//! own functions put the centres of the outermost pixels on the seam. Here, as in most maps, the pixels'
//! areas fill the sphere. The two conventions differ by at most half a pixel.)
//!
//! | Projection | Size | Position of a direction |
//! |---|---|---|
//! | lat-long | 2:1 by default | x by longitude atan2(dx, dz), from +π at the left to −π; y by latitude, +π/2 at the top |
//! | cube | 1:6 | squares from top to bottom +x −x +y −y +z −z, each as seen from within, upright; +y has +z at its top, −y has −z |
//! | angular | 1:1 | centre +z, distance from the centre = angle/π of the half width, right and up as in the lat-long; nothing outside the disc |

use glam::{DVec2, DVec3};
use std::f64::consts::{PI, TAU};

/// The projection of the sphere of directions on a rectangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MapProjection {
    /// Longitude and latitude.
    LatLong,
    /// Six squares, one below the other.
    Cube,
    /// Debevec's angular map, "light probe".
    Angular,
}

/// Samples per side of an angular map's pixel, for its solid angle.
const SOLID_ANGLE_SAMPLES: usize = 8;

/// Forward, right and up directions of a cube map's squares.
const SQUARE_AXES: [[DVec3; 3]; 6] = [
    [DVec3::X, DVec3::Z, DVec3::Y],
    [DVec3::NEG_X, DVec3::NEG_Z, DVec3::Y],
    [DVec3::Y, DVec3::X, DVec3::Z],
    [DVec3::NEG_Y, DVec3::X, DVec3::NEG_Z],
    [DVec3::Z, DVec3::NEG_X, DVec3::Y],
    [DVec3::NEG_Z, DVec3::X, DVec3::Y],
];

impl MapProjection {
    /// Name of the projection as a value of `--map`.
    pub fn name(self) -> &'static str {
        match self {
            Self::LatLong => "latlong",
            Self::Cube => "cube",
            Self::Angular => "angular",
        }
    }

    /// Guesses the projection of a map of this size (width, height).
    pub fn guess_from_size([w, h]: [usize; 2]) -> Option<Self> {
        match () {
            () if w == 2 * h => Some(Self::LatLong),
            () if h == 6 * w => Some(Self::Cube),
            () if w == h => Some(Self::Angular),
            () => None,
        }
    }

    /// Tests if a map of this size can have this projection; a lat-long map may have any size.
    pub fn fits_size(self, [w, h]: [usize; 2]) -> bool {
        match self {
            Self::LatLong => true,
            Self::Cube => h == 6 * w,
            Self::Angular => w == h,
        }
    }

    /// Returns the direction (unit length) at `position` of a map of `size`, both in pixels.
    ///
    /// Outside an angular map's disc the direction continues beyond −z; outside a cube map's squares,
    /// sideways on the square's plane.
    pub fn direction_at(self, size: [usize; 2], position: DVec2) -> DVec3 {
        let square = (position.y / size[0] as f64).floor().clamp(0.0, 5.0) as usize;
        self.direction_on_square(size, square, position)
    }

    /// Returns the direction like [`MapProjection::direction_at`], on square `square` of a cube map.
    pub(super) fn direction_on_square(self, size: [usize; 2], square: usize, at: DVec2) -> DVec3 {
        let [w, h] = size.map(|n| n as f64);
        match self {
            Self::LatLong => {
                let (sin, cos) = ((0.5 - at.x / w) * TAU).sin_cos();
                let (up, flat) = ((0.5 - at.y / h) * PI).sin_cos();
                DVec3::new(sin * flat, up, cos * flat)
            }
            Self::Cube => {
                let [forward, right, up] = SQUARE_AXES[square];
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

    /// Returns the position, in pixels, of `direction` (any length above 0) on a map of `size`.
    pub fn position_of(self, size: [usize; 2], direction: DVec3) -> DVec2 {
        let [w, h] = size.map(|n| n as f64);
        let d = direction;
        match self {
            Self::LatLong => {
                let longitude = d.x.atan2(d.z);
                let latitude = d.y.atan2(d.x.hypot(d.z));
                DVec2::new((0.5 - longitude / TAU) * w, (0.5 - latitude / PI) * h)
            }
            Self::Cube => {
                let square = square_towards(d);
                let [forward, right, up] = SQUARE_AXES[square];
                let f = d.dot(forward);
                let s = d.dot(right) / f;
                let t = d.dot(up) / f;
                let (top, next) = (square as f64 * w, (square + 1) as f64 * w);
                // The square's lower edge must not become the next square's upper edge.
                let y = (top + (1.0 - t) / 2.0 * w).min(next.next_down());
                DVec2::new((s + 1.0) / 2.0 * w, y)
            }
            Self::Angular => {
                let flat = DVec2::new(-d.x, d.y);
                let r = flat.length().atan2(d.z) / PI;
                // All of the rim is −z: any of its points will do.
                let p = flat.try_normalize().unwrap_or(DVec2::X) * r;
                DVec2::new((1.0 + p.x) / 2.0 * w, (1.0 - p.y) / 2.0 * h)
            }
        }
    }

    /// Solid angle (sr) of pixel (x, y). It is exact for lat-long (rows between parallels) and cube
    /// (corner formula). For an angular map it is the integral of the Jacobian π sin θ / r, by 8×8 points;
    /// points outside the disc count 0.
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
                let at =
                    |k: usize, i: usize| 2.0 * (k as f64 + (i as f64 + 0.5) / SOLID_ANGLE_SAMPLES as f64) / w - 1.0;
                let area = (2.0 / (w * SOLID_ANGLE_SAMPLES as f64)).powi(2);
                let mut sum = 0.0;
                for (i, j) in (0..SOLID_ANGLE_SAMPLES).flat_map(|j| (0..SOLID_ANGLE_SAMPLES).map(move |i| (i, j))) {
                    let r = at(x, i).hypot(at(y, j));
                    if r < 1.0 {
                        sum += if r > 0.0 { (PI * r).sin() * PI / r } else { PI * PI };
                    }
                }
                sum * area
            }
        }
    }
}

/// Returns the number of the cube map's square that shows `d`.
fn square_towards(d: DVec3) -> usize {
    let a = d.abs();
    let axis = match () {
        () if a.x >= a.y && a.x >= a.z => 0,
        () if a.y >= a.z => 1,
        () => 2,
    };
    2 * axis + usize::from(d[axis] < 0.0)
}
