//! The panorama as the eye sees it, with the axes and the room's edges drawn on it: whether the
//! map lies the right way round, and whether the room's size fits, shows at a glance.
//!
//! Whatever the map's own layout, the thumbnail is in latitude and longitude: its centre looks
//! towards +z, +x is to the left, y up.

use super::{Backdrop, Relit};
use crate::show::picture::{Exposure, Picture, encode};
use glam::{DVec2, DVec3, Vec3};
use maud::{Markup, html};
use std::f64::consts::{PI, TAU};
use std::fmt::Write;

/// Points along a drawn edge.
const STEPS: u32 = 48;
/// Rooms of more faces than this are not outlined.
const OUTLINED: usize = 64;

/// Radiances of all directions, W/m²/sr: width, height, pixels row by row from the upper left.
pub type Thumbnail = (u32, u32, Vec<Vec3>);

/// Looks once around.
pub fn thumbnail(backdrop: Backdrop, width: u32) -> Thumbnail {
    let (w, h) = (width, width / 2);
    let at = |x: u32, n: u32| (f64::from(x) + 0.5) / f64::from(n);
    let pixels = (0..h).flat_map(|y| (0..w).map(move |x| (x, y)));
    let colours = pixels.map(|(x, y)| backdrop(direction(DVec2::new(at(x, w), at(y, h)))));
    (w, h, colours.collect())
}

/// The direction at (x right, y down), 0…1.
pub fn direction(at: DVec2) -> DVec3 {
    let (longitude, polar) = ((0.5 - at.x) * TAU, at.y * PI);
    let (x, z) = longitude.sin_cos();
    DVec3::new(x * polar.sin(), polar.cos(), z * polar.sin())
}

/// Where a unit direction lies; the inverse of [`direction`].
pub fn place(direction: DVec3) -> DVec2 {
    DVec2::new(
        0.5 - direction.x.atan2(direction.z) / TAU,
        direction.y.clamp(-1.0, 1.0).acos() / PI,
    )
}

/// The marked picture as an SVG element.
pub fn marked(relit: &Relit, (w, h, pixels): &Thumbnail, exposure: Exposure) -> Markup {
    let colour = |x: u32, y: u32| {
        let pixel = pixels.get((y * w + x) as usize)?;
        Some(encode(exposure.display(*pixel)))
    };
    let source = Picture::from_pixels(*w, *h, colour).data_uri();
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
            path d=(edges(relit)) {}
            @for (axis, name) in axes {
                // A pole is a whole row, and −z both rims: marked where the label fits.
                @let at = place(axis) * DVec2::new(1000.0, 500.0);
                @let (x, y) = (at.x.clamp(24.0, 976.0), at.y.clamp(20.0, 480.0));
                circle cx=(format!("{x:.1}")) cy=(format!("{y:.1}")) r="17" {}
                text x=(format!("{x:.1}")) y=(format!("{:.1}", y + 6.0)) { (name) }
            }
        }
    }
}

/// The outlines of the room's faces as the eye sees them, as SVG path data.
fn edges(relit: &Relit) -> String {
    let mut path = String::new();
    let Some(eye) = relit.eye.filter(|_| relit.room <= OUTLINED) else {
        return path;
    };
    for face in relit.scene.faces.iter().take(relit.room) {
        let outline = face.outline();
        for (k, from) in outline.iter().enumerate() {
            let to = outline[(k + 1) % outline.len()];
            let mut last: Option<DVec2> = None;
            for step in 0..=STEPS {
                let point = from.lerp(to, f64::from(step) / f64::from(STEPS));
                let at = place((point - eye).normalize_or(DVec3::Z));
                // Over the rim the line begins anew on the other side.
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
    fn the_axes_lie_where_they_are_documented() {
        let near = |direction: DVec3, x: f64, y: f64| {
            assert!((place(direction) - DVec2::new(x, y)).length() < 1e-12);
        };
        near(DVec3::Z, 0.5, 0.5);
        near(DVec3::X, 0.25, 0.5);
        near(DVec3::NEG_X, 0.75, 0.5);
        assert_eq!([place(DVec3::Y).y, place(DVec3::NEG_Y).y], [0.0, 1.0]);
        assert!((place(DVec3::NEG_Z).x - 0.5).abs() == 0.5);
        for at in [[0.1, 0.2], [0.4, 0.9], [0.77, 0.5]].map(DVec2::from) {
            assert!((place(direction(at)) - at).length() < 1e-12);
        }
    }
}
