//! The share of a shooter's cosine hemisphere that meets no front: open sky and black backs.
//! Twin of `gpu/src/shaders/escape.wgsl`.

use common::constants::{CONTACT, MISS, OUTLINE};
use common::escape::DIRECTIONS;
use common::intersect::intersect;
use common::mesh::{Cover, Mesh, Point};
use common::rays::Rays;
use glam::Vec3;
use rayon::prelude::*;

/// The escaped share of `cell`; `directions` are [`common::escape::directions`]. The BVH only
/// leaves out faces that the shader's loop over all of them would not count either.
pub fn escape(mesh: &Mesh, rays: &Rays, cell: u32, directions: &[Vec3]) -> f32 {
    let face = &mesh.faces[mesh.cells[cell as usize].face as usize];
    let first = (cell * mesh.samples) as usize;
    let points = &mesh.points[first..first + mesh.samples as usize];
    let bitangent = face.normal.cross(face.tangent);
    let lost = directions
        .par_iter()
        .enumerate()
        .filter(|(k, d)| {
            let direction = face.tangent * d.x + bitangent * d.y + face.normal * d.z;
            !meets_front(rays, face.sheet, start(points, *k), direction)
        })
        .count();
    lost as f32 / DIRECTIONS as f32
}

/// Where direction `k` starts: the points take turns, but light leaves from open ones only.
fn start(points: &[Point], k: usize) -> Vec3 {
    let n = points.len();
    let mut at = k % n;
    for _ in 0..n {
        if points[at].cover == Cover::Open {
            break;
        }
        at = (at + 1) % n;
    }
    points[at].position
}

/// Whether the nearest face along the ray shows its front. A front that touches the shooter
/// counts (it takes the light away, but not into the open); the shooter's own sheet does not.
pub fn meets_front(rays: &Rays, sheet: u32, origin: Vec3, direction: Vec3) -> bool {
    let mut front = MISS;
    let mut back = MISS;
    rays.along(origin, direction, |_, face| {
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
