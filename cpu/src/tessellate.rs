//! How finely a face is cut before its vertices go to the hemisphere. Twin of
//! `gpu/src/shaders/tessellate.wgsl`.
//!
//! A straight edge of length L at distance d from the shooter, cut into k parts, leaves its true
//! curve by at most (L/kd)²/8 of the disc's radius: the second derivative of the projected edge
//! is at most (L/d)² in either projection. In pixels the sagitta is (L/kd)²·N/16.

use crate::projection::Frame;
use common::constants::{CONTACT, HIDDEN, LEVELS};
use common::mesh::MeshFace;
use common::settings::Visibility;
use glam::Vec3;

/// The level of `face` seen from a shooter on `sheet`.
pub fn level(visibility: Visibility, face: &MeshFace, sheet: u32, frame: &Frame, size: u32) -> u32 {
    let a = face.corners[0] - frame.centre;
    let away = face.two_sided && face.normal.dot(a) >= 0.0;
    if face.sheet == sheet || face.normal == Vec3::ZERO || away {
        return HIDDEN;
    }
    let mut highest = -1.0f32;
    for corner in face.corners {
        highest = highest.max(frame.local(corner).z);
    }
    if highest <= CONTACT {
        return HIDDEN;
    }
    if visibility == Visibility::Paper {
        return 0;
    }
    let parts = ratio(face, frame.centre) * (size as f32 / 16.0).sqrt();
    let mut level = 0;
    while level + 1 < LEVELS && ((1u32 << level) as f32) < parts {
        level += 1;
    }
    level
}

/// The largest L/d over the face's edges.
pub fn ratio(face: &MeshFace, centre: Vec3) -> f32 {
    let mut largest = 0.0f32;
    for k in 0..4 {
        let a = face.corners[k] - centre;
        let along = face.corners[(k + 1) & 3] - face.corners[k];
        let length2 = along.dot(along);
        if length2 > 0.0 {
            let t = (-a.dot(along) / length2).clamp(0.0, 1.0);
            let nearest = a + along * t;
            let distance2 = nearest.dot(nearest).max(1e-12);
            largest = largest.max((length2 / distance2).sqrt());
        }
    }
    largest
}

/// The sagitta in pixels at the level in force: how far a drawn edge may lie from the true one.
pub fn sagitta(face: &MeshFace, frame: &Frame, size: u32, level: u32) -> f32 {
    let angle = ratio(face, frame.centre) / (1u32 << level) as f32;
    angle * angle * size as f32 / 16.0
}
