//! A radiance map of all directions, as a camera in a room captured it.

use super::projection::Projection;
use super::repair::{Counts, repair};
use super::{Decoded, Failure, check_size, openexr, radiance};
use crate::error::{Error, Result};
use crate::file::{MAX_BYTES, open};
use glam::{DVec2, DVec3, Vec3};
use std::f32::consts::PI;
use std::io::Read;
use std::path::Path;

/// Radiance L (W/m²/sr, linear Rec. 709) over the sphere of directions.
///
/// All values are finite, not negative, and small enough for πL to be finite.
#[derive(Clone, Debug)]
pub struct Panorama {
    size: [usize; 2],
    pixels: Vec<Vec3>,
    projection: Projection,
    /// Pixels that were mended, see [`Counts`].
    pub counts: Counts,
    /// What is worth saying: mended pixels, doubtful formats, a guessed projection.
    pub notes: Vec<String>,
}

impl Panorama {
    /// Reads a Radiance picture or an OpenEXR file, told apart by their first bytes.
    ///
    /// `projection` overrides what the file's `envmap` attribute or its aspect says (2:1 lat-long,
    /// 1:6 cube, 1:1 angular).
    ///
    /// Errors: [`Error::Input`] with the file and, where known, scanline and byte: not readable,
    /// neither format, damaged, cut short, more than [`MAX_PIXELS`](super::MAX_PIXELS) pixels or 2 GiB, or of a shape
    /// that fits no projection.
    pub fn read(path: &Path, projection: Option<Projection>) -> Result<Self> {
        let refuse = |failure: Failure| {
            // Decoders repeat names that a damaged file gives.
            let message = failure.message.replace(char::is_control, " ");
            Error::input(path, failure.place, message)
        };
        let decoded = decode(path).map_err(refuse)?;
        Self::new(decoded, projection).map_err(refuse)
    }

    /// A map from its pixels, row by row from the upper left; `size` is width and height. Bad
    /// pixels are mended as in a file.
    ///
    /// Errors ([`Error::Usage`]): sizes that do not match, or fit no projection; radiance too large.
    pub fn from_pixels(
        size: [usize; 2],
        pixels: Vec<Vec3>,
        projection: Option<Projection>,
    ) -> Result<Self> {
        let fail = |failure: Failure| Error::Usage(format!("the map {}", failure.message));
        check_size(size[0] as u64, size[1] as u64).map_err(|e| fail(e.into()))?;
        if pixels.len() != size[0] * size[1] {
            return Err(fail(
                "has another number of pixels than its size says".into(),
            ));
        }
        let decoded = Decoded {
            size,
            pixels,
            ..Decoded::default()
        };
        Self::new(decoded, projection).map_err(fail)
    }

    fn new(decoded: Decoded, wanted: Option<Projection>) -> std::result::Result<Self, Failure> {
        let Decoded {
            size,
            mut pixels,
            projection: told,
            mut notes,
        } = decoded;
        let [w, h] = size;
        let Some(projection) = wanted.or(told).or_else(|| Projection::of_size(size)) else {
            let message = format!(
                "has {w}×{h} pixels, which is neither lat-long (2:1), cube (1:6) nor angular (1:1): say which it is"
            );
            return Err(message.into());
        };
        if !projection.fits(size) {
            let needs = match projection {
                Projection::Cube => "six squares one below the other (1:6, +x −x +y −y +z −z)",
                _ => "a square",
            };
            let message = format!(
                "has {w}×{h} pixels, and a map of kind {} needs {needs}",
                projection.name()
            );
            return Err(message.into());
        }
        let counts = repair(size, &mut pixels, &mut notes);
        if let Some(at) = pixels.iter().position(|p| !(*p * PI).is_finite()) {
            return Err(Failure {
                place: format!("pixel {}, {}", at % w, at / w),
                message: "its radiance is too large for 32-bit floats: scale the map down".into(),
            });
        }
        Ok(Self {
            size,
            pixels,
            projection,
            counts,
            notes,
        })
    }

    /// Width and height in pixels.
    pub fn size(&self) -> [usize; 2] {
        self.size
    }

    /// Radiance, row by row from the upper left.
    pub fn pixels(&self) -> &[Vec3] {
        &self.pixels
    }

    /// How the map shows the sphere.
    pub fn projection(&self) -> Projection {
        self.projection
    }

    /// Every pixel's x and y, its radiance and its solid angle (sr); of those without extent (an
    /// angular map's corners) none.
    pub fn lit(&self) -> impl Iterator<Item = ([usize; 2], Vec3, f64)> {
        let [w, h] = self.size;
        (0..h).flat_map(move |y| {
            // The same for the whole row.
            let row = (self.projection == Projection::LatLong)
                .then(|| self.projection.solid_angle(self.size, [0, y]));
            (0..w).filter_map(move |x| {
                let exact = || self.projection.solid_angle(self.size, [x, y]);
                let solid_angle = row.unwrap_or_else(exact);
                (solid_angle > 0.0).then(|| ([x, y], self.pixels[y * w + x], solid_angle))
            })
        })
    }

    /// Mean radiance over all directions, W/m²/sr.
    pub fn mean(&self) -> DVec3 {
        let sum = |(sum, whole): (DVec3, f64), (_, radiance, angle): (_, Vec3, f64)| {
            (sum + radiance.as_dvec3() * angle, whole + angle)
        };
        let (sum, whole) = self.lit().fold((DVec3::ZERO, 0.0), sum);
        sum / whole
    }

    /// What a surface with this unit normal receives at the eye, W/m²: Σ L cosθ Δω over pixels in
    /// front of it, each taken at its centre.
    pub fn irradiance(&self, normal: DVec3) -> DVec3 {
        self.lit()
            .map(|([x, y], radiance, angle)| {
                let at = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
                let cos = self.projection.direction(self.size, at).dot(normal);
                radiance.as_dvec3() * (angle * cos.max(0.0))
            })
            .sum()
    }

    /// Radiance from `direction` (any length above 0), W/m²/sr: bilinear between pixel centres,
    /// across the seam, over the poles and over the borders of a cube map's squares.
    pub fn radiance(&self, direction: DVec3) -> Vec3 {
        let at = self.projection.position(self.size, direction);
        let square = ((at.y / self.size[0] as f64) as i64).clamp(0, 5);
        bilinear(at - 0.5, |x, y| self.pixel(x, y, square))
            .unwrap_or_else(|| self.at(self.holds(at)))
    }

    /// The pixel at column x and row y, which may lie one beyond the map or the square; none in an
    /// angular map's corners, where nothing was captured.
    fn pixel(&self, x: i64, y: i64, square: i64) -> Option<Vec3> {
        let [w, h] = self.size.map(|n| n as i64);
        let beyond = || {
            let at = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
            let direction = self.projection.direction_on(self.size, square as usize, at);
            self.projection.position(self.size, direction)
        };
        match self.projection {
            Projection::LatLong => {
                // Over a pole the map goes on half a turn further.
                let over = y.clamp(-1 - y, 2 * h - 1 - y);
                let turn = if over == y { 0 } else { w / 2 };
                Some(self.at([(x + turn).rem_euclid(w), over.clamp(0, h - 1)]))
            }
            Projection::Cube if (0..w).contains(&x) && y.div_euclid(w) == square => {
                Some(self.at([x, y]))
            }
            Projection::Cube => {
                // In the next square, whose rows and columns lie otherwise.
                let at = beyond();
                let first = (at.y as i64).clamp(0, h - 1) / w * w;
                let within = |x: i64, y: i64| [x.clamp(0, w - 1), y.clamp(first, first + w - 1)];
                bilinear(at - 0.5, |x, y| Some(self.at(within(x, y))))
            }
            Projection::Angular => {
                let inside = (0..w).contains(&x) && (0..h).contains(&y);
                let pixel = if inside { [x, y] } else { self.holds(beyond()) };
                self.captured(pixel).then(|| self.at(pixel))
            }
        }
    }

    /// Whether a pixel's centre lies in an angular map's disc.
    fn captured(&self, pixel: [i64; 2]) -> bool {
        let [x, y] = pixel.map(|k| (2 * k + 1) as f64 / self.size[0] as f64 - 1.0);
        x.hypot(y) < 1.0
    }

    /// The pixel that holds a position.
    fn holds(&self, at: DVec2) -> [i64; 2] {
        let within = |k: f64, n: usize| (k.floor() as i64).clamp(0, n as i64 - 1);
        [within(at.x, self.size[0]), within(at.y, self.size[1])]
    }

    fn at(&self, [x, y]: [i64; 2]) -> Vec3 {
        self.pixels[y as usize * self.size[0] + x as usize]
    }
}

/// The mean of the four pixels around `at` (in pixels, whole at their centres), of those there are.
fn bilinear(at: DVec2, pixel: impl Fn(i64, i64) -> Option<Vec3>) -> Option<Vec3> {
    let low = at.floor();
    let part = at - low;
    let (mut sum, mut whole) = (DVec3::ZERO, 0.0);
    for (i, u) in [(0, 1.0 - part.x), (1, part.x)] {
        for (j, v) in [(0, 1.0 - part.y), (1, part.y)] {
            if let Some(value) = pixel(low.x as i64 + i, low.y as i64 + j) {
                sum += value.as_dvec3() * (u * v);
                whole += u * v;
            }
        }
    }
    (whole > 0.0).then(|| (sum / whole).as_vec3())
}

fn decode(path: &Path) -> std::result::Result<Decoded, Failure> {
    let unreadable = |e: std::io::Error| format!("cannot be read: {e}");
    let mut file = open(path, MAX_BYTES).map_err(|reason| format!("cannot be read: {reason}"))?;
    let mut bytes = Vec::new();
    // The first bytes decide before the rest, which may be long, is read.
    file.by_ref()
        .take(4)
        .read_to_end(&mut bytes)
        .map_err(unreadable)?;
    let decoder = match () {
        () if openexr::is(&bytes) => openexr::decode,
        () if radiance::is(&bytes) => radiance::decode,
        () => {
            return Err(
                "is neither a Radiance picture (.hdr) nor an OpenEXR file: a radiance map is needed".into(),
            );
        }
    };
    let read = file
        .take(MAX_BYTES)
        .read_to_end(&mut bytes)
        .map_err(unreadable)?;
    if read as u64 == MAX_BYTES {
        return Err("grows while it is read, beyond 2 GiB".into());
    }
    decoder(&bytes)
}
