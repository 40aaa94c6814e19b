//! Draws the panorama with axes and room edges, to check the map's orientation and the room's size.
//!
//! The thumbnail is in latitude and longitude whatever the map's own layout: its centre is +z, +x is to the left, y
//! is up.

use super::{Backdrop, RelitScene};
use crate::report::document::{Annotation, Figure};
use crate::report::picture::{Exposure, RgbaPicture, encode_srgb};
use glam::{DVec2, DVec3};
use std::f64::consts::{PI, TAU};
use std::fmt::Write;

/// Width of the sampled panorama in pixels.
const THUMBNAIL_WIDTH: u32 = 512;
/// Size in which it is shown and annotated.
const SHOWN_SIZE: [u32; 2] = [1000, 500];
/// Line segments per drawn edge.
const SEGMENTS_PER_EDGE: u32 = 48;
/// Maximum number of room faces that are outlined.
const MAX_OUTLINED_FACES: usize = 64;

/// Renders the panorama with axes and room edges.
pub fn panorama_figure(relit: &RelitScene, backdrop: Backdrop, exposure: Exposure) -> Figure {
    let (w, h) = (THUMBNAIL_WIDTH, THUMBNAIL_WIDTH / 2);
    let at = |x: u32, n: u32| (f64::from(x) + 0.5) / f64::from(n);
    let picture = RgbaPicture::from_pixels(w, h, |x, y| {
        let radiance = backdrop(map_direction(DVec2::new(at(x, w), at(y, h))));
        Some(encode_srgb(exposure.display_light(radiance)))
    });
    let axes = [
        (DVec3::Z, "+z"),
        (DVec3::X, "+x"),
        (DVec3::NEG_X, "−x"),
        (DVec3::Y, "+y"),
        (DVec3::NEG_Y, "−y"),
        (DVec3::NEG_Z, "−z"),
    ];
    // A pole is a whole row, and −z is at both rims: marked where the label fits.
    let labels = axes.map(|(axis, name)| {
        let at = map_position(axis) * DVec2::from(SHOWN_SIZE.map(f64::from));
        Annotation::Label([at.x.clamp(24.0, 976.0), at.y.clamp(20.0, 480.0)], name.into())
    });
    let outlines = Annotation::Path("edges", room_outlines(relit));
    let annotations: Vec<Annotation> = [outlines].into_iter().chain(labels).collect();
    let caption = "The map's centre is +z, +x is to the left, y is up (latitude and longitude, whatever the map's own \
                   layout; +y and −y are the whole upper and lower rim, −z the left and right rims). The lines are the \
                   room's edges projected from the eye: where they deviate from the photograph's corners, the room's \
                   size or the eye is wrong.";
    let alt = "The panorama with the six axes marked";
    Figure::from_annotated(&picture.data_uri(), alt, SHOWN_SIZE, &annotations, caption)
}

/// Returns the direction at (x right, y down), 0…1.
fn map_direction(at: DVec2) -> DVec3 {
    let (longitude, polar) = ((0.5 - at.x) * TAU, at.y * PI);
    let (x, z) = longitude.sin_cos();
    DVec3::new(x * polar.sin(), polar.cos(), z * polar.sin())
}

/// Returns the position of a unit direction; the inverse of [`map_direction`].
fn map_position(direction: DVec3) -> DVec2 {
    DVec2::new(
        0.5 - direction.x.atan2(direction.z) / TAU,
        direction.y.clamp(-1.0, 1.0).acos() / PI,
    )
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
