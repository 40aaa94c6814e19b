//! A ray and a face: plane first, then its edges. Twin of `gpu/src/shaders/intersect.wgsl`.

use crate::constants::{CONTACT, END, MISS, OUTLINE};
use crate::mesh::MeshFace;
use glam::{Vec3, Vec4};

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

impl Crossing {
    /// Whether the face stops a ray that runs to `end`, in units of t.
    #[inline(always)]
    pub fn between(&self, end: f32) -> bool {
        // No branches: lanes ask together.
        (self.t > 0.0) & (self.t < END * end) & (self.inside >= -OUTLINE)
    }
}

/// The crossing of the ray `origin` + t `direction` with the plane of `face`.
#[inline]
pub fn intersect(face: &MeshFace, origin: Vec3, direction: Vec3) -> Crossing {
    meet(face.plane, face.edges, origin, direction)
}

/// The same of a face's planes.
#[inline(always)]
pub fn meet(plane: Vec4, edges: [Vec4; 4], origin: Vec3, direction: Vec3) -> Crossing {
    let normal = plane.truncate();
    let facing = normal.dot(direction);
    if facing == 0.0 {
        return Crossing {
            t: MISS,
            inside: -MISS,
            facing,
        };
    }
    let t = (plane.w - normal.dot(origin)) / facing;
    let p = origin + direction * t;
    let one = within(edges[0], p).min(within(edges[1], p));
    let other = within(edges[2], p).min(within(edges[3], p));
    let inside = one.min(other);
    Crossing { t, inside, facing }
}

/// Whether `point` lies on the plane of `face`: a ray that ends there cannot be cut by it.
#[inline]
pub fn touches(face: &MeshFace, point: Vec3) -> bool {
    (face.plane.truncate().dot(point) - face.plane.w).abs() <= CONTACT
}

/// The edge that a triangle lacks is (0, 0): it must not limit.
#[inline(always)]
fn within(edge: Vec4, p: Vec3) -> f32 {
    if edge.truncate() == Vec3::ZERO {
        return MISS;
    }
    edge.truncate().dot(p) - edge.w
}
