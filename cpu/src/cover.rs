//! Where a body stands on a face: such a point sees neither a front nor the open.

use crate::intersect::intersect;
use crate::rays::Rays;
use common::Result;
use common::constants::{CONTACT, MISS, OUTLINE};
use common::escape::directions;
use common::mesh::{Mesh, MeshFace};
use common::scene::Scene;
use common::settings::Settings;
use glam::Vec3;

/// One in so many of the escape directions is asked, 34 of 1024, in every column of their grid: a
/// point is taken for covered only if all of them meet backs.
const STEP: usize = 31;

/// The mesh of a solve at these settings.
pub fn sampled(scene: &Scene, settings: &Settings) -> Result<Mesh> {
    let mut mesh = Mesh::uniform(scene, settings.texels, settings.cells)?;
    sample(&mut mesh, settings.samples);
    Ok(mesh)
}

/// Looks at each cell of `mesh` in `samples` points, and marks those on which a body stands.
pub fn sample(mesh: &mut Mesh, samples: u32) {
    if samples <= 1 {
        return;
    }
    let rays = Rays::new(mesh);
    let directions: Vec<Vec3> = directions().into_iter().step_by(STEP).collect();
    mesh.sample(samples, |face, point| open(&rays, face, point, &directions));
}

fn open(rays: &Rays, face: &MeshFace, point: Vec3, directions: &[Vec3]) -> bool {
    let bitangent = face.normal.cross(face.tangent);
    directions.iter().any(|d| {
        let direction = face.tangent * d.x + bitangent * d.y + face.normal * d.z;
        leaves(rays, face.sheet, point, direction)
    })
}

/// Whether the ray meets a front before a back, or nothing. A face that touches the point is passed
/// over: it may be the other side of a thin wall; a body has more faces behind it.
fn leaves(rays: &Rays, sheet: u32, origin: Vec3, direction: Vec3) -> bool {
    let mut front = MISS;
    let mut back = MISS;
    rays.along(origin, direction, |face| {
        let hit = intersect(face, origin, direction);
        if face.sheet == sheet || hit.t <= 0.0 || (hit.t * hit.facing).abs() <= CONTACT {
            return;
        }
        if hit.facing < 0.0 && hit.inside >= -OUTLINE {
            front = front.min(hit.t);
        } else if hit.facing > 0.0 && hit.inside >= OUTLINE {
            back = back.min(hit.t);
        }
    });
    back == MISS || front <= back
}
