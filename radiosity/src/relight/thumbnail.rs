//! Draws the panorama with axes and room edges, to check the map's orientation and the room's size.
//!
//! The thumbnail is in latitude and longitude whatever the map's own layout: its centre is +z, +x is to the left, y
//! is up.

use super::{Backdrop, RelitScene};
use crate::report::picture::{Exposure, RgbaPicture, encode_srgb};
use glam::{DVec2, DVec3, Vec3};
use maud::{Markup, html};
use std::f64::consts::{PI, TAU};
use std::fmt::Write;

/// Line segments per drawn edge.
const SEGMENTS_PER_EDGE: u32 = 48;
/// Maximum number of room faces that are outlined.
const MAX_OUTLINED_FACES: usize = 64;

/// Radiance of all directions, W/m²/sr: width, height, pixels row-major from the upper left.
pub type Thumbnail = (u32, u32, Vec<Vec3>);

/// Samples the backdrop in latitude and longitude, `width` pixels wide.
pub fn render_thumbnail(backdrop: Backdrop, width: u32) -> Thumbnail {
    let (w, h) = (width, width / 2);
    let at = |x: u32, n: u32| (f64::from(x) + 0.5) / f64::from(n);
    let pixels = (0..h).flat_map(|y| (0..w).map(move |x| (x, y)));
    let colours = pixels.map(|(x, y)| backdrop(map_direction(DVec2::new(at(x, w), at(y, h)))));
    (w, h, colours.collect())
}

/// Returns the direction at (x right, y down), 0…1.
pub fn map_direction(at: DVec2) -> DVec3 {
    let (longitude, polar) = ((0.5 - at.x) * TAU, at.y * PI);
    let (x, z) = longitude.sin_cos();
    DVec3::new(x * polar.sin(), polar.cos(), z * polar.sin())
}

/// Returns the position of a unit direction; the inverse of [`map_direction`].
pub fn map_position(direction: DVec3) -> DVec2 {
    DVec2::new(
        0.5 - direction.x.atan2(direction.z) / TAU,
        direction.y.clamp(-1.0, 1.0).acos() / PI,
    )
}

/// Renders the picture with axes and room edges as an SVG element.
pub fn render_marked_map(relit: &RelitScene, (w, h, pixels): &Thumbnail, exposure: Exposure) -> Markup {
    let colour = |x: u32, y: u32| {
        let pixel = pixels.get((y * w + x) as usize)?;
        Some(encode_srgb(exposure.display_light(*pixel)))
    };
    let source = RgbaPicture::from_pixels(*w, *h, colour).data_uri();
    let axes = [
        (DVec3::Z, "+z"),
        (DVec3::X, "+x"),
        (DVec3::NEG_X, "−x"),
        (DVec3::Y, "+y"),
        (DVec3::NEG_Y, "−y"),
        (DVec3::NEG_Z, "−z"),
    ];
    html! {
        svg.map viewBox="0 0 1000 500" role="img" aria-label="The panorama with the six axes marked" {
            image href=(source) width="1000" height="500" preserveAspectRatio="none" {}
            path d=(room_outlines(relit)) {}
            @for (axis, name) in axes {
                // A pole is a whole row, and −z is at both rims: marked where the label fits.
                @let at = map_position(axis) * DVec2::new(1000.0, 500.0);
                @let (x, y) = (at.x.clamp(24.0, 976.0), at.y.clamp(20.0, 480.0));
                circle cx=(format!("{x:.1}")) cy=(format!("{y:.1}")) r="17" {}
                text x=(format!("{x:.1}")) y=(format!("{:.1}", y + 6.0)) { (name) }
            }
        }
    }
}

/// Returns the outlines of the room's faces, projected from the eye, as SVG path data.
fn room_outlines(relit: &RelitScene) -> String {
    let mut path = String::new();
    let Some(eye) = relit.eye.filter(|_| relit.room <= MAX_OUTLINED_FACES) else {
        return path;
    };
    for face in relit.scene.faces.iter().take(relit.room) {
        let outline = face.outline();
        for (k, from) in outline.iter().enumerate() {
            let to = outline[(k + 1) % outline.len()];
            let mut last: Option<DVec2> = None;
            for step in 0..=SEGMENTS_PER_EDGE {
                let point = from.lerp(to, f64::from(step) / f64::from(SEGMENTS_PER_EDGE));
                let at = map_position((point - eye).normalize_or(DVec3::Z));
                // Across the rim the line continues on the other side.
                let on = last.is_some_and(|last| (last.x - at.x).abs() < 0.5);
                let (letter, [x, y]) = (if on { 'L' } else { 'M' }, [at.x * 1000.0, at.y * 500.0]);
                // Writing to a string does not fail.
                let _ = write!(path, "{letter}{x:.1} {y:.1}");
                last = Some(at);
            }
        }
    }
    path
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_lie_at_documented_positions() {
        let near = |direction: DVec3, x: f64, y: f64| {
            assert!((map_position(direction) - DVec2::new(x, y)).length() < 1e-12);
        };
        near(DVec3::Z, 0.5, 0.5);
        near(DVec3::X, 0.25, 0.5);
        near(DVec3::NEG_X, 0.75, 0.5);
        assert_eq!([map_position(DVec3::Y).y, map_position(DVec3::NEG_Y).y], [0.0, 1.0]);
        assert!((map_position(DVec3::NEG_Z).x - 0.5).abs() == 0.5);
        for at in [[0.1, 0.2], [0.4, 0.9], [0.77, 0.5]].map(DVec2::from) {
            assert!((map_position(map_direction(at)) - at).length() < 1e-12);
        }
    }
}
