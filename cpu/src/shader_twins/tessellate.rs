//! Tessellation levels of faces whose vertices are projected to the hemisphere.
//!
//! A straight edge is a great circle on the hemisphere; a part of it that spans the angle β leaves
//! its chord on the disc by at most β²/8 of the radius in either projection, β²·N/16 pixels.
//! The parts are not equally long but nearly equally wide as seen from the shooter ([`subdivide_edge`](crate::shader_twins::edge_subdivision::subdivide_edge)):
//! √N parts keep the sagitta below a pixel however close the edge is.

use crate::shader_twins::image_bound::{is_hidden_face, unit_vector};
use crate::shader_twins::view::ShooterView;
use common::constants::{HIDDEN_LEVEL, TESSELLATION_LEVELS};
use common::mesh::MeshFace;
use common::settings::ItemBufferProjection;
use glam::Vec3;

/// Returns the level of `face`.
pub fn tessellation_level(view: &ShooterView, face: &MeshFace) -> u32 {
    if is_hidden_face(view, face) {
        return HIDDEN_LEVEL;
    }
    if view.projection == ItemBufferProjection::Paper {
        return 0;
    }
    let parts = widest_edge(face, view.frame.centre) * (view.size as f32 / 16.0).sqrt();
    let mut level = 0;
    while level + 1 < TESSELLATION_LEVELS && ((1u32 << level) as f32) < parts {
        level += 1;
    }
    level
}

/// The largest 4·tan(Ω/4) over the face's edges, Ω the angle that an edge spans: [`subdivide_edge`](crate::shader_twins::edge_subdivision::subdivide_edge) cuts
/// its halves evenly along their tangents.
pub fn widest_edge(face: &MeshFace, centre: Vec3) -> f32 {
    let mut largest = 0.0f32;
    for k in 0..4 {
        let a = unit_vector(face.corners[k] - centre);
        let b = unit_vector(face.corners[(k + 1) & 3] - centre);
        let d = b - a;
        let sine = (d.dot(d)).sqrt() * 0.5;
        let cosine = (1.0 - sine * sine).max(0.0).sqrt();
        largest = largest.max(4.0 * sine / (1.0 + cosine));
    }
    largest
}

/// Returns, for each level, the list of its faces in face order.
pub fn tessellate(view: &ShooterView, faces: &[MeshFace]) -> [Vec<u32>; TESSELLATION_LEVELS as usize] {
    let mut lists = [(); TESSELLATION_LEVELS as usize].map(|()| Vec::new());
    for (k, face) in (0..).zip(faces) {
        let level = tessellation_level(view, face);
        if level < HIDDEN_LEVEL {
            lists[level as usize].push(k);
        }
    }
    lists
}

/// Returns the sagitta in pixels at a level: the distance of a drawn edge from the true one.
pub fn edge_sagitta(view: &ShooterView, face: &MeshFace, level: u32) -> f32 {
    let angle = widest_edge(face, view.frame.centre) / (1u32 << level) as f32;
    angle * angle * view.size as f32 / 16.0
}
