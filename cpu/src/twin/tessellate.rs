//! How finely a face is cut before its vertices go to the hemisphere. Twin of
//! `gpu/src/shaders/tessellate.wgsl`.
//!
//! A straight edge is a great circle on the hemisphere; a part of it that spans the angle β leaves
//! its chord on the disc by at most β²/8 of the radius in either projection, β²·N/16 pixels.
//! The parts are not equally long but nearly equally wide as seen from the shooter ([`spread`]):
//! √N parts keep the sagitta below a pixel however close the edge is.

use crate::twin::bound::{hidden, unit};
use crate::twin::view::View;
use common::constants::{HIDDEN, LEVELS};
use common::mesh::MeshFace;
use common::settings::Projection;
use glam::Vec3;

/// The level of `face`.
pub fn level(view: &View, face: &MeshFace) -> u32 {
    if hidden(view, face) {
        return HIDDEN;
    }
    if view.projection == Projection::Paper {
        return 0;
    }
    let parts = widest(face, view.frame.centre) * (view.size as f32 / 16.0).sqrt();
    let mut level = 0;
    while level + 1 < LEVELS && ((1u32 << level) as f32) < parts {
        level += 1;
    }
    level
}

/// The largest 4·tan(Ω/4) over the face's edges, Ω the angle that an edge spans: [`spread`] cuts
/// its halves evenly along their tangents.
pub fn widest(face: &MeshFace, centre: Vec3) -> f32 {
    let mut largest = 0.0f32;
    for k in 0..4 {
        let a = unit(face.corners[k] - centre);
        let b = unit(face.corners[(k + 1) & 3] - centre);
        let d = b - a;
        let sine = (d.dot(d)).sqrt() * 0.5;
        let cosine = (1.0 - sine * sine).max(0.0).sqrt();
        largest = largest.max(4.0 * sine / (1.0 + cosine));
    }
    largest
}

/// Where on the edge from `a` to `b` (seen from the origin) the share `u` of its parts ends: the
/// two halves of its angle, each cut evenly along the tangent at its middle.
pub fn spread(a: Vec3, b: Vec3, u: f32) -> f32 {
    let length_a = a.dot(a).max(1e-24).sqrt();
    let length_b = b.dot(b).max(1e-24).sqrt();
    // The bisector of the angle divides the edge in the ratio of the two sides.
    let middle = length_a / (length_a + length_b);
    let m = a * (1.0 - middle) + b * middle;
    let length_m = m.dot(m).max(1e-24).sqrt();
    if u < 0.5 {
        let w = 2.0 * u;
        return middle * (w * length_a / ((1.0 - w) * length_m + w * length_a));
    }
    let w = 2.0 * u - 1.0;
    middle + (1.0 - middle) * (w * length_m / ((1.0 - w) * length_b + w * length_m))
}

/// The sagitta in pixels at the level in force: how far a drawn edge may lie from the true one.
pub fn sagitta(view: &View, face: &MeshFace, level: u32) -> f32 {
    let angle = widest(face, view.frame.centre) / (1u32 << level) as f32;
    angle * angle * view.size as f32 / 16.0
}
