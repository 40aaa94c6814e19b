//! Intersection of a ray with a face: its plane, then its edges. Twin of `gpu/src/shaders/intersect.wgsl`.

use crate::constants::{CONTACT_DISTANCE, MISS_DISTANCE, OUTLINE_MARGIN, SEGMENT_END_FRACTION};
use crate::mesh::MeshFace;
use glam::{Vec3, Vec4};

/// Intersection of a ray with a face's plane.
#[derive(Clone, Copy, Debug)]
pub struct Crossing {
    /// Ray parameter; [`MISS_DISTANCE`] for a ray along the plane.
    pub t: f32,
    /// Distance to the nearest edge, mesh units; negative outside the outline, and for a ray along the plane.
    pub inside: f32,
    /// Normal · direction, which need not be a unit vector: negative when the ray meets the front.
    pub facing: f32,
}

impl Crossing {
    /// Returns whether the face stops a ray that ends at `end`, in units of t.
    #[inline(always)]
    pub fn stops_ray(&self, end: f32) -> bool {
        // No branches, for SIMD.
        (self.t > 0.0) & (self.t < SEGMENT_END_FRACTION * end) & (self.inside >= -OUTLINE_MARGIN)
    }
}

/// Intersects the ray `origin` + t `direction` with the plane of `face`.
#[inline]
pub fn intersect_face(face: &MeshFace, origin: Vec3, direction: Vec3) -> Crossing {
    intersect_planes(face.plane, face.edges, origin, direction)
}

/// Intersects a ray with a face that is given by its `plane` and `edges` planes.
#[inline(always)]
pub fn intersect_planes(plane: Vec4, edges: [Vec4; 4], origin: Vec3, direction: Vec3) -> Crossing {
    let normal = plane.truncate();
    let facing = normal.dot(direction);
    if facing == 0.0 {
        return Crossing {
            t: MISS_DISTANCE,
            inside: -MISS_DISTANCE,
            facing,
        };
    }
    let t = (plane.w - normal.dot(origin)) / facing;
    let p = origin + direction * t;
    let one = inside_distance(edges[0], p).min(inside_distance(edges[1], p));
    let other = inside_distance(edges[2], p).min(inside_distance(edges[3], p));
    let inside = one.min(other);
    Crossing { t, inside, facing }
}

/// Returns whether `point` lies on the plane of `face`: the face cannot occlude a ray that ends there.
#[inline]
pub fn touches_plane(face: &MeshFace, point: Vec3) -> bool {
    (face.plane.truncate().dot(point) - face.plane.w).abs() <= CONTACT_DISTANCE
}

/// Returns the distance of `p` inside an edge plane; [`MISS_DISTANCE`] for the zero normal of the edge that a triangle lacks.
#[inline(always)]
pub fn inside_distance(edge: Vec4, p: Vec3) -> f32 {
    if edge.truncate() == Vec3::ZERO {
        return MISS_DISTANCE;
    }
    edge.truncate().dot(p) - edge.w
}
