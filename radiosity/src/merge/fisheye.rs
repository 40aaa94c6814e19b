//! Converts a circular fisheye picture to an angular map.
//!
//! Both are equidistant projections: distance from the centre is proportional to angle. The fisheye's rim, half its
//! field of view, becomes a circle inside the map's rim at 180°. No pixel is resampled: the picture is cropped to its
//! circle and padded with black.

use common::capture::MAX_PIXELS;
use common::{Error, Result};
use glam::Vec3;

/// Returns side and pixels of the angular map of a fisheye circle of `degrees`, inscribed in the picture's centre; 0
/// outside the circle.
///
/// Errors ([`Error::Usage`]): a field of view not above 0 or above 360; a map too large.
pub fn to_angular_map(size: [usize; 2], pixels: &[Vec3], degrees: f64) -> Result<(usize, Vec<Vec3>)> {
    if !(degrees > 0.0 && degrees <= 360.0) {
        return Err(Error::Usage(format!(
            "--fisheye {degrees}: a field of view above 0 and up to 360 degrees is needed"
        )));
    }
    let [w, h] = size;
    let circle = w.min(h);
    // Equal margins keep the centre; rounding is at most half a pixel.
    let frame = ((360.0 / degrees - 1.0) * circle as f64 / 2.0).round();
    let side = circle as f64 + 2.0 * frame;
    if side * side > MAX_PIXELS as f64 {
        return Err(Error::Usage(format!(
            "--fisheye {degrees} makes a map of {side}×{side} pixels, and {MAX_PIXELS} (2^26) is the most: scale the pictures down"
        )));
    }
    let (frame, side) = (frame as usize, side as usize);
    let mut map = vec![Vec3::ZERO; side * side];
    for y in 0..circle {
        for x in 0..circle {
            let from_centre = |k: usize| (2 * k + 1) as f64 / circle as f64 - 1.0;
            if from_centre(x).hypot(from_centre(y)) < 1.0 {
                let from = (y + (h - circle) / 2) * w + x + (w - circle) / 2;
                map[(y + frame) * side + x + frame] = pixels[from];
            }
        }
    }
    Ok((side, map))
}
