//! Visibility by one ray from the shooter's centre to the texel's, through an obvhs BVH of faces.

use crate::intersect::intersect;
use common::constants::{CONTACT, END, MISS, OUTLINE};
use common::mesh::{Mesh, MeshFace};
use glam::{Vec3, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::cwbvh::{CwBvh, builder::build_cwbvh};
use obvhs::ray::Ray;
use std::time::Duration;

/// The BVH's nodes ignore t < 1e−4, whatever the ray's length: rays run to t = 2¹⁶ instead of 1
/// so that this is 1.5e−9 of their length and near contact stays opaque.
const REACH: f32 = 65536.0;

/// Faces that block.
pub struct Rays {
    bvh: CwBvh,
    faces: Vec<MeshFace>,
    /// The face of each primitive of the BVH.
    index: Vec<u32>,
}

impl Rays {
    /// Builds the BVH over the faces that have an area.
    pub fn new(mesh: &Mesh) -> Self {
        let index: Vec<u32> = (0..mesh.faces.len() as u32)
            .filter(|k| mesh.faces[*k as usize].normal != Vec3::ZERO)
            .collect();
        let boxes: Vec<Aabb> = index
            .iter()
            .map(|k| bounds(&mesh.faces[*k as usize]))
            .collect();
        let mut build_time = Duration::ZERO;
        let bvh = build_cwbvh(&boxes, BvhBuildParams::very_slow_build(), &mut build_time);
        Self {
            bvh,
            faces: mesh.faces.clone(),
            index,
        }
    }

    /// The sheets that a ray between two faces may touch: its ends.
    fn blocks(&self, primitive: usize, ends: [u32; 2], ray: &Ray) -> Option<(u32, f32)> {
        let k = self.index[self.bvh.primitive_indices[primitive] as usize];
        let face = &self.faces[k as usize];
        if face.sheet == ends[0] || face.sheet == ends[1] {
            return None;
        }
        let hit = intersect(face, ray.origin.into(), ray.direction.into());
        (hit.t > 0.0 && hit.t < END * REACH && hit.inside >= -OUTLINE).then_some((k, hit.t))
    }

    /// Whether nothing lies between `from` on face `ends[0]` and `to` on face `ends[1]`.
    pub fn visible(&self, from: Vec3, to: Vec3, ends: [u32; 2]) -> bool {
        let ends = ends.map(|k| self.faces[k as usize].sheet);
        self.bvh
            .ray_traverse_miss(segment(from, to), |ray, primitive| {
                self.blocks(primitive, ends, ray).map_or(MISS, |(_, t)| t)
            })
    }

    /// All faces that lie in between.
    pub fn blockers(&self, from: Vec3, to: Vec3, ends: [u32; 2]) -> Vec<u32> {
        let ends = ends.map(|k| self.faces[k as usize].sheet);
        let mut found = Vec::new();
        self.bvh
            .ray_traverse_anyhit(segment(from, to), |ray, primitive| {
                found.extend(self.blocks(primitive, ends, ray).map(|(k, _)| k));
            });
        found
    }

    /// Every face that the ray from `origin` along `direction`, or from just behind it, may meet.
    pub fn along(&self, origin: Vec3, direction: Vec3, mut visit: impl FnMut(&MeshFace)) {
        let behind = origin - direction * (4.0 * CONTACT);
        self.bvh
            .ray_traverse_anyhit(ray(behind, direction / REACH, f32::MAX), |_, primitive| {
                let k = self.index[self.bvh.primitive_indices[primitive] as usize];
                visit(&self.faces[k as usize]);
            });
    }

    /// The nearest front along a view ray, and its distance; backs are looked through.
    pub fn front(&self, origin: Vec3, direction: Vec3) -> Option<(u32, f32)> {
        let mut nearest: Option<(u32, f32)> = None;
        self.bvh
            .ray_traverse_anyhit(ray(origin, direction, f32::MAX), |ray, primitive| {
                let k = self.index[self.bvh.primitive_indices[primitive] as usize];
                let hit = intersect(
                    &self.faces[k as usize],
                    ray.origin.into(),
                    ray.direction.into(),
                );
                if hit.facing < 0.0
                    && hit.t > 0.0
                    && hit.inside >= -OUTLINE
                    && nearest.is_none_or(|(_, best)| hit.t < best)
                {
                    nearest = Some((k, hit.t));
                }
            });
        nearest
    }
}

fn bounds(face: &MeshFace) -> Aabb {
    let mut aabb = Aabb::empty();
    for corner in face.corners {
        aabb.extend(corner.into());
    }
    // The outline's margin, and room for the rounding of the nodes' quantised boxes.
    let margin = Vec3A::splat(4.0 * OUTLINE);
    aabb.min -= margin;
    aabb.max += margin;
    aabb
}

fn segment(from: Vec3, to: Vec3) -> Ray {
    ray(from, (to - from) / REACH, END * REACH)
}

/// `Ray::new` clamps the inverse of a small component; here every component is small.
fn ray(origin: Vec3, direction: Vec3, tmax: f32) -> Ray {
    let inverse = |x: f32| {
        if x.abs() < 1e-30 {
            1e30f32.copysign(x)
        } else {
            1.0 / x
        }
    };
    Ray {
        origin: origin.into(),
        direction: direction.into(),
        inv_direction: Vec3A::new(
            inverse(direction.x),
            inverse(direction.y),
            inverse(direction.z),
        ),
        tmin: 0.0,
        tmax,
    }
}
