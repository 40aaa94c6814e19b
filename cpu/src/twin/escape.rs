//! The share of a shooter's cosine hemisphere that meets no front: open sky and black backs.
//! Twin of `gpu/src/shaders/escape.wgsl`.

use common::constants::{CONTACT, MISS, OUTLINE};
use common::escape::DIRECTIONS;
use common::intersect::intersect;
use common::mesh::{Cover, Mesh, MeshFace, Point};
use common::rays::Rays;
use glam::Vec3;
use rayon::prelude::*;

/// Where a ray meets the nearest front, and the nearest back.
#[derive(Clone, Copy)]
struct Nearest {
    front: f32,
    back: f32,
}

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
    let mut nearest = Nearest {
        front: MISS,
        back: MISS,
    };
    rays.along(origin, direction, |_, face| {
        nearest = nearer(nearest, sheet, face, origin, direction);
    });
    // At a shared edge front and back are equally near: the front takes the light.
    nearest.front < MISS && nearest.front <= nearest.back + CONTACT
}

/// The nearest of the faces so far and of `face`.
fn nearer(nearest: Nearest, sheet: u32, face: &MeshFace, origin: Vec3, direction: Vec3) -> Nearest {
    let mut next = nearest;
    if face.sheet == sheet {
        return next;
    }
    let hit = intersect(face, origin, direction);
    if hit.facing < 0.0 {
        if hit.t >= -CONTACT && hit.inside >= -OUTLINE {
            next.front = next.front.min(hit.t);
        }
    } else if hit.t > CONTACT && hit.inside >= OUTLINE {
        next.back = next.back.min(hit.t);
    }
    next
}
