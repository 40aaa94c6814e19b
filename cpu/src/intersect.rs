//! A ray and a face: plane first, then its edges. Twin of `gpu/src/shaders/intersect.wgsl`.

use common::constants::MISS;
use common::mesh::MeshFace;
use glam::Vec3;

/// Where a ray meets a face's plane, and how far inside the outline (negative: outside).
#[derive(Clone, Copy, Debug)]
pub struct Crossing {
    /// Ray parameter; [`MISS`] for a ray along the plane.
    pub t: f32,
    /// Distance to the nearest edge, mesh units.
    pub inside: f32,
    /// Normal · direction: negative when the ray meets the front.
    pub facing: f32,
}

/// The crossing of the ray `origin` + t `direction` with the plane of `face`.
pub fn intersect(face: &MeshFace, origin: Vec3, direction: Vec3) -> Crossing {
    let normal = face.plane.truncate();
    let facing = normal.dot(direction);
    if facing == 0.0 {
        return Crossing {
            t: MISS,
            inside: -MISS,
            facing,
        };
    }
    let t = (face.plane.w - normal.dot(origin)) / facing;
    let p = origin + direction * t;
    let mut inside = MISS;
    for edge in face.edges {
        // The edge that a triangle lacks is (0, 0): it must not limit.
        let distance = edge.truncate().dot(p) - edge.w;
        inside = inside.min(if edge.truncate() == Vec3::ZERO {
            MISS
        } else {
            distance
        });
    }
    Crossing { t, inside, facing }
}
