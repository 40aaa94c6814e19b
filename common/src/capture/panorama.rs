//! A radiance map of all directions, captured by a camera in a room: read, checked and repaired, then sampled by
//! direction. `capture::wall_radiosity` turns it into the radiosity of a room's walls, and a relight's composite shows it
//! behind the objects.

use super::projection::MapProjection;
use super::repair::{RepairCounts, repair_pixels};
use super::{DecodedMap, check_size, openexr, radiance};
use crate::error::{Error, Result};
use crate::file::{self, MAX_FILE_BYTES};
use glam::{DVec2, DVec3, Vec3};
use std::f32::consts::PI;
use std::panic::catch_unwind;
use std::path::Path;

/// Radiance L (W/m²/sr, linear Rec. 709) over the sphere of directions.
///
/// All values are finite, not negative, and small enough for πL to be finite.
#[derive(Clone, Debug)]
pub struct Panorama {
    size: [usize; 2],
    pixels: Vec<Vec3>,
    projection: MapProjection,
    /// Turn about the vertical axis, radians.
    turn: f64,
    /// Numbers of repaired pixels, see [`RepairCounts`].
    pub counts: RepairCounts,
    /// Remarks for the user: repaired pixels, doubtful formats, a guessed projection.
    pub notes: Vec<String>,
}

impl Panorama {
    /// Reads a Radiance picture or an OpenEXR file, recognised by their first bytes.
    ///
    /// `projection` overrides the file's `envmap` attribute and its aspect (2:1 lat-long, 1:6 cube, 1:1 angular).
    ///
    /// Errors: [`Error::Input`] with the file and, where known, scanline and byte: not readable,
    /// neither format, damaged, cut short, more than [`MAX_PIXELS`](super::MAX_PIXELS) pixels or 2 GiB, or of a shape
    /// that fits no projection.
    pub fn read(path: &Path, projection: Option<MapProjection>) -> Result<Self> {
        // A decoder's message may hold names from a damaged file.
        let refuse = |message: String| Error::bad_input(path, "", message.replace(char::is_control, " "));
        let decoded = decode_file(path).map_err(refuse)?;
        Self::new(decoded, projection).map_err(refuse)
    }

    /// Makes a map from its pixels, row by row from the upper left; `size` is width and height. Bad
    /// pixels are repaired as in a file.
    ///
    /// Errors ([`Error::Usage`]): sizes that do not match, or fit no projection; radiance too large.
    pub fn from_pixels(size: [usize; 2], pixels: Vec<Vec3>, projection: Option<MapProjection>) -> Result<Self> {
        let fail = |message: String| Error::Usage(format!("the map {message}"));
        check_size(size[0] as u64, size[1] as u64).map_err(fail)?;
        if pixels.len() != size[0] * size[1] {
            return Err(fail("has another number of pixels than its size says".into()));
        }
        let decoded = DecodedMap {
            size,
            pixels,
            ..DecodedMap::default()
        };
        Self::new(decoded, projection).map_err(fail)
    }

    fn new(decoded: DecodedMap, wanted: Option<MapProjection>) -> std::result::Result<Self, String> {
        let DecodedMap {
            size,
            mut pixels,
            projection: stated,
            mut notes,
        } = decoded;
        let [w, h] = size;
        let Some(projection) = wanted.or(stated).or_else(|| MapProjection::guess_from_size(size)) else {
            return Err(format!(
                "has {w}×{h} pixels, which is neither lat-long (2:1), cube (1:6) nor angular (1:1): say which it is"
            ));
        };
        if !projection.fits_size(size) {
            let needs = match projection {
                MapProjection::Cube => "six squares one below the other (1:6, +x −x +y −y +z −z)",
                MapProjection::Angular => "a square",
                MapProjection::LatLong => "any size",
            };
            let kind = projection.name();
            return Err(format!("has {w}×{h} pixels, and a map of kind {kind} needs {needs}"));
        }
        let counts = repair_pixels(size, &mut pixels, &mut notes);
        if let Some(at) = pixels.iter().position(|p| !(*p * PI).is_finite()) {
            let (x, y) = (at % w, at / w);
            return Err(format!(
                "pixel {x}, {y}: its radiance is too large for 32-bit floats: scale the map down"
            ));
        }
        Ok(Self {
            size,
            pixels,
            projection,
            turn: 0.0,
            counts,
            notes,
        })
    }

    /// Turns the map about the vertical axis, counter-clockwise as seen from above.
    pub fn turn_by(mut self, degrees: f64) -> Self {
        self.turn = degrees.to_radians();
        self
    }

    /// Returns the direction that a position shows, on square `square` of a cube.
    pub(super) fn direction_at(&self, square: usize, at: DVec2) -> DVec3 {
        let direction = self.projection.direction_on_square(self.size, square, at);
        if self.turn == 0.0 {
            direction
        } else {
            direction.rotate_y(self.turn)
        }
    }

    /// Width and height in pixels.
    pub fn size(&self) -> [usize; 2] {
        self.size
    }

    /// Radiance, row by row from the upper left.
    pub fn pixels(&self) -> &[Vec3] {
        &self.pixels
    }

    /// The map's projection of the sphere.
    pub fn projection(&self) -> MapProjection {
        self.projection
    }

    /// Iterates over x and y, radiance and solid angle (sr) of every pixel that shows a part of the sphere; those in an
    /// angular map's corners show none.
    pub fn captured_pixels(&self) -> impl Iterator<Item = ([usize; 2], Vec3, f64)> {
        let [w, h] = self.size;
        (0..h).flat_map(move |y| {
            // The solid angle is the same for all pixels of a row.
            let row =
                (self.projection == MapProjection::LatLong).then(|| self.projection.solid_angle(self.size, [0, y]));
            (0..w).filter_map(move |x| {
                let exact = || self.projection.solid_angle(self.size, [x, y]);
                let solid_angle = row.unwrap_or_else(exact);
                (solid_angle > 0.0).then(|| ([x, y], self.pixels[y * w + x], solid_angle))
            })
        })
    }

    /// Radiance from `direction` (any length above 0), W/m²/sr: bilinear between pixel centres,
    /// across the seam, over the poles and over the borders of a cube map's squares.
    pub fn radiance(&self, direction: DVec3) -> Vec3 {
        let own = if self.turn == 0.0 {
            direction
        } else {
            direction.rotate_y(-self.turn)
        };
        let at = self.projection.position_of(self.size, own);
        let square = ((at.y / self.size[0] as f64) as i64).clamp(0, 5);
        interpolate_bilinear(at - 0.5, |x, y| self.pixel_or_neighbour(x, y, square))
            .unwrap_or_else(|| self.pixel_radiance(self.pixel_containing(at)))
    }

    /// Returns the radiance of the pixel at column x and row y. Beyond the map or the square it wraps: that of the
    /// pixel which shows the same direction. `None` in an angular map's corners, where nothing was captured.
    fn pixel_or_neighbour(&self, x: i64, y: i64, square: i64) -> Option<Vec3> {
        let [w, h] = self.size.map(|n| n as i64);
        let is_cube = self.projection == MapProjection::Cube;
        let rows = if is_cube { square * w..(square + 1) * w } else { 0..h };
        let pixel = if (0..w).contains(&x) && rows.contains(&y) {
            [x, y]
        } else {
            let at = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
            let direction = self.projection.direction_on_square(self.size, square as usize, at);
            self.pixel_containing(self.projection.position_of(self.size, direction))
        };
        let is_captured = self.projection != MapProjection::Angular || self.is_captured(pixel);
        is_captured.then(|| self.pixel_radiance(pixel))
    }

    /// Tests if a pixel's centre lies in an angular map's disc.
    fn is_captured(&self, pixel: [i64; 2]) -> bool {
        let [x, y] = pixel.map(|k| (2 * k + 1) as f64 / self.size[0] as f64 - 1.0);
        x.hypot(y) < 1.0
    }

    /// Returns the pixel that contains a position.
    fn pixel_containing(&self, at: DVec2) -> [i64; 2] {
        let within = |k: f64, n: usize| (k.floor() as i64).clamp(0, n as i64 - 1);
        [within(at.x, self.size[0]), within(at.y, self.size[1])]
    }

    fn pixel_radiance(&self, [x, y]: [i64; 2]) -> Vec3 {
        self.pixels[y as usize * self.size[0] + x as usize]
    }
}

/// Interpolates between the four pixels around `at` (in pixels, whole numbers at their centres). Missing
/// pixels get no weight; `None` if all four are missing.
fn interpolate_bilinear(at: DVec2, pixel: impl Fn(i64, i64) -> Option<Vec3>) -> Option<Vec3> {
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

fn decode_file(path: &Path) -> std::result::Result<DecodedMap, String> {
    let bytes = file::read(path, MAX_FILE_BYTES).map_err(|reason| format!("cannot be read: {reason}"))?;
    let decoder = match bytes[..] {
        [0x76, 0x2f, 0x31, 0x01, ..] => openexr::decode_bytes,
        [b'#', b'?', ..] => radiance::decode_bytes,
        _ => {
            return Err("is neither a Radiance picture (.hdr) nor an OpenEXR file: a radiance map is needed".into());
        }
    };
    // The decoder of OpenEXR uses indices of a damaged file unchecked; its panics are reported as damage.
    catch_unwind(|| decoder(&bytes)).unwrap_or_else(|_| Err("is damaged: write or copy it again".into()))
}
