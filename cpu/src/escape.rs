//! The share of a shooter's cosine hemisphere that meets no front: open sky and black backs.
//! Twin of `gpu/src/shaders/escape.wgsl`.

use crate::intersect::intersect;
use crate::rays::Rays;
use common::constants::{CONTACT, MISS, OUTLINE};
use common::escape::DIRECTIONS;
use common::mesh::{Cell, Mesh};
use glam::Vec3;
use rayon::prelude::*;

/// The escaped share of `cell`; `directions` are [`common::escape::directions`]. The BVH only
/// leaves out faces that the shader's loop over all of them would not count either.
pub fn escape(mesh: &Mesh, rays: &Rays, cell: &Cell, directions: &[Vec3]) -> f32 {
    let face = &mesh.faces[cell.face as usize];
    let bitangent = face.normal.cross(face.tangent);
    let lost = directions
        .par_iter()
        .filter(|d| {
            let direction = face.tangent * d.x + bitangent * d.y + face.normal * d.z;
            !meets_front(rays, face.sheet, cell.shooter.centre, direction)
        })
        .count();
    lost as f32 / DIRECTIONS as f32
}

/// Whether the nearest face along the ray shows its front. A front that touches the shooter
/// counts (it takes the light away, but not into the open); the shooter's own sheet does not.
pub fn meets_front(rays: &Rays, sheet: u32, origin: Vec3, direction: Vec3) -> bool {
    let mut front = MISS;
    let mut back = MISS;
    rays.along(origin, direction, |face| {
        if face.sheet == sheet {
            return;
        }
        let hit = intersect(face, origin, direction);
        if hit.facing < 0.0 {
            if hit.t >= -CONTACT && hit.inside >= -OUTLINE {
                front = front.min(hit.t);
            }
        } else if hit.t > CONTACT && hit.inside >= OUTLINE {
            back = back.min(hit.t);
        }
    });
    // At a shared edge front and back are equally near: the front takes the light.
    front < MISS && front <= back + CONTACT
}
