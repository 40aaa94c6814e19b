//! A circular fisheye picture as an angular map.
//!
//! Both show the angle from the centre as a length in proportion to it: the fisheye's rim, half its
//! field of view, becomes a circle within the map's rim at 180°. So no pixel is resampled: the
//! picture is cut to its circle and framed by black.

use common::capture::MAX_PIXELS;
use common::{Error, Result};
use glam::Vec3;

/// Side and pixels of the map in which a circle of `degrees`, inscribed in the picture and in its
/// middle, is an angular map; 0 outside the circle.
///
/// Errors ([`Error::Usage`]): a field of view not above 0 or above 360; a map too large.
pub fn angular(size: [usize; 2], pixels: &[Vec3], degrees: f64) -> Result<(usize, Vec<Vec3>)> {
    if !(degrees > 0.0 && degrees <= 360.0) {
        return Err(Error::Usage(format!(
            "--fisheye {degrees}: a field of view above 0 and up to 360 degrees is needed"
        )));
    }
    let [w, h] = size;
    let circle = w.min(h);
    // An even frame keeps the centre; half a pixel of its width is all that is rounded.
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
