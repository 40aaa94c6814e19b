//! Captured rooms: an HDR radiance map of a real place becomes the radiosity of a box room's walls.
//!
//! ```text
//! file ─ panorama (radiance, openexr, colour, repair) ─ projection ─┐
//!                       room (six quads, an eye) ─ resample (sphere) ┴─ B per texel ─ maps (one EXR per face)
//! ```
//!
//! Radiance L is in W/m²/sr, radiosity B = πL in W/m², both in linear Rec. 709. `docs/architecture.md`,
//! "Captured rooms", states the orientation, the weighting and the rules for bad pixels.

mod colour;
pub mod maps;
mod openexr;
pub mod panorama;
pub mod projection;
mod radiance;
mod repair;
mod resample;
pub mod room;
mod scanline;
mod sphere;

pub use panorama::Panorama;
pub use projection::Projection;
pub use repair::Counts;
pub use resample::texel_radiosity;

use glam::Vec3;

/// More pixels than this are refused: 8192 × 8192, or 0.8 GB as three 32-bit floats.
pub const MAX_PIXELS: u64 = 1 << 26;

/// A decoded file, before its projection is known and its pixels are repaired.
#[derive(Debug, Default)]
struct Decoded {
    /// Width and height in pixels.
    size: [usize; 2],
    /// Radiance, row by row from the upper left.
    pixels: Vec<Vec3>,
    /// What the file says its projection is.
    projection: Option<Projection>,
    /// What is worth saying about the file.
    notes: Vec<String>,
}

/// Why a file cannot be decoded: the place in it (may be empty) and the reason.
#[derive(Debug)]
struct Failure {
    place: String,
    message: String,
}

impl From<String> for Failure {
    fn from(message: String) -> Self {
        Self {
            place: String::new(),
            message,
        }
    }
}

impl From<&str> for Failure {
    fn from(message: &str) -> Self {
        message.to_owned().into()
    }
}

/// Refuses sizes that are empty or beyond [`MAX_PIXELS`], with the end of a sentence about the file.
pub fn check_size(width: u64, height: u64) -> Result<(), String> {
    if width == 0 || height == 0 {
        return Err(format!(
            "has {width}×{height} pixels: a map needs at least one"
        ));
    }
    if width.saturating_mul(height) > MAX_PIXELS {
        return Err(format!(
            "has {width}×{height} pixels, and {MAX_PIXELS} (2^26) is the most: scale it down"
        ));
    }
    Ok(())
}
