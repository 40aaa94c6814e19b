//! Captured rooms: converts an HDR radiance map of a real place to the radiosity of a box room's walls.
//!
//! ```text
//! file ─ panorama (radiance, openexr, colour, repair) ─ projection ─┐
//!                         room (six quads, an eye) ─ wall_radiosity ┴─ B per texel ─ maps (one EXR per face)
//! ```
//!
//! Radiance L is in W/m²/sr, radiosity B = πL in W/m², both in linear Rec. 709. `GUIDE.md`, "Relighting", states the
//! orientation; `docs/architecture.md`, "Captured rooms", the weighting and the rules for bad pixels.

mod colour;
pub mod maps;
mod openexr;
pub mod panorama;
pub mod projection;
mod radiance;
mod repair;
pub mod room;
pub mod sky;
mod wall_radiosity;

pub use panorama::Panorama;
pub use projection::MapProjection;
pub use repair::RepairCounts;
pub use wall_radiosity::texel_radiosity;

use glam::Vec3;

/// Largest accepted number of pixels: 8192 × 8192, or 0.8 GB as three 32-bit floats.
pub const MAX_PIXELS: u64 = 1 << 26;

/// A decoded file, before its projection is known and its pixels are repaired.
#[derive(Debug, Default)]
struct DecodedMap {
    /// Width and height in pixels.
    size: [usize; 2],
    /// Radiance, row by row from the upper left.
    pixels: Vec<Vec3>,
    /// The projection that the file states.
    projection: Option<MapProjection>,
    /// Remarks about the file for the user.
    notes: Vec<String>,
}

/// Checks that a map has at least one pixel and at most [`MAX_PIXELS`].
///
/// Errors: the end of a sentence that begins with the file's name.
pub fn check_size(width: u64, height: u64) -> Result<(), String> {
    if width == 0 || height == 0 {
        return Err(format!("has {width}×{height} pixels: a map needs at least one"));
    }
    if width.saturating_mul(height) > MAX_PIXELS {
        return Err(format!(
            "has {width}×{height} pixels, and {MAX_PIXELS} (2^26) is the most: scale it down"
        ));
    }
    Ok(())
}
