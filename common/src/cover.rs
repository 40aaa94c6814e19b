//! Cover of sample points: a point is covered by a body if it sees neither a front nor open space. Solves mark the
//! points of their meshes by it: a patch shoots and receives at open points only.

use crate::constants::{CONTACT_DISTANCE, MISS_DISTANCE, OUTLINE_MARGIN};
use crate::escape::escape_directions;
use crate::intersect::intersect_face;
use crate::mesh::{Cover, Mesh, MeshFace};
use crate::rays::Rays;
use crate::scene::Scene;
use crate::settings::Meshing;
use crate::{Error, Result};
use glam::Vec3;
use rayon::prelude::*;

/// Stride over the escape directions: 34 of 1024 are tested, in every column of their grid. A point is
/// covered only if all of them meet backs.
const DIRECTION_STRIDE: usize = 31;

/// Points between two calls of the stop callback.
const POINTS_PER_TASK: usize = 64;

/// Returns the directions in which cover is tested, in a face's frame.
pub fn cover_directions() -> Vec<Vec3> {
    escape_directions().into_iter().step_by(DIRECTION_STRIDE).collect()
}

/// Callback that returns true to stop.
pub type StopCheck<'a> = &'a (dyn Fn() -> bool + Sync);

/// Makes a mesh with the same numbers of texels, patches and samples on each face, and tests the cover of
/// its sample points.
///
/// Errors: as of [`Mesh::new`].
pub fn sampled_mesh(scene: &Scene, meshing: &Meshing) -> Result<Mesh> {
    sampled_mesh_until(scene, meshing, &|| false)
}

/// [`sampled_mesh`] with a stop callback.
///
/// Errors: as of [`Mesh::new`]; [`Error::Interrupted`] if it was stopped.
pub fn sampled_mesh_until(scene: &Scene, meshing: &Meshing, stop: StopCheck) -> Result<Mesh> {
    let resolutions = vec![[meshing.texels; 2]; scene.faces.len()];
    let points = [meshing.patches, meshing.samples];
    furnished_mesh(scene, scene.faces.len(), &resolutions, points, stop)
}

/// Makes the mesh of a scene whose first `room` faces are a room and whose other faces are objects in it,
/// with `resolutions[k]` texels on face k, K×K patches per face and `samples` points per patch.
///
/// Errors: as of [`sampled_mesh_until`].
pub fn furnished_mesh(
    scene: &Scene,
    room: usize,
    resolutions: &[[u32; 2]],
    [patches, samples]: [u32; 2],
    stop: StopCheck,
) -> Result<Mesh> {
    let mut mesh = Mesh::new(scene, resolutions, patches)?;
    mesh.room_faces = room as u32;
    sample_covers_until(&mut mesh, samples, stop)?;
    Ok(mesh)
}

/// Places `samples` points on each patch of `mesh`, and tests which of them a body covers.
pub fn sample_covers(mesh: &mut Mesh, samples: u32) {
    // Never stopped.
    let _ = sample_covers_until(mesh, samples, &|| false);
}

fn sample_covers_until(mesh: &mut Mesh, samples: u32, stop: StopCheck) -> Result<()> {
    mesh.place_samples(samples);
    if samples <= 1 {
        return Ok(());
    }
    let rays = Rays::new(mesh);
    let directions = cover_directions();
    let (room, all) = (mesh.room_faces as usize, mesh.faces.len());
    let cover = |k: usize| {
        let patch = &mesh.patches[k / samples as usize];
        let (face, point) = (&mesh.faces[patch.face as usize], mesh.patch_points[k].position);
        let open = |faces| is_open(&rays, faces, face, point, &directions);
        if patch.shooter.area <= 0.0 || open(all) {
            Cover::Open
        } else if room < all && open(room) {
            Cover::Object
        } else {
            Cover::Room
        }
    };
    let mut covers = vec![Cover::Open; mesh.patch_points.len()];
    let tasks = covers.par_chunks_mut(POINTS_PER_TASK).enumerate();
    tasks.for_each(|(task, covers)| {
        if !stop() {
            for (k, own) in covers.iter_mut().enumerate() {
                *own = cover(task * POINTS_PER_TASK + k);
            }
        }
    });
    if stop() {
        return Err(Error::Interrupted);
    }
    mesh.set_covers(&covers);
    Ok(())
}

/// Returns whether a point of `face` is uncovered among the first `faces` faces: in one of `directions` (see
/// [`cover_directions`]) the ray meets a front before a back, or nothing. Where a front and a back coincide, as where a body
/// touches the ceiling, neither counts.
pub fn is_open(rays: &Rays, faces: usize, face: &MeshFace, point: Vec3, directions: &[Vec3]) -> bool {
    let mut meets_back = false;
    for d in directions {
        let direction = face.direction_in_frame(*d);
        let (mut front, mut back) = (MISS_DISTANCE, MISS_DISTANCE);
        // Distance along the ray within which a front coincides with the nearest back.
        let mut contact = 0.0;
        rays.visit_faces_along(point, direction, |k, other| {
            let hit = intersect_face(other, point, direction);
            // A face that touches the point may be the other side of a thin wall; a body has more faces behind it.
            let touches = (hit.t * hit.facing).abs() <= CONTACT_DISTANCE;
            let passed = k as usize >= faces || other.sheet == face.sheet || hit.t <= 0.0 || touches;
            if !passed && hit.facing < 0.0 && hit.inside >= -OUTLINE_MARGIN {
                front = front.min(hit.t);
            } else if !passed && hit.facing > 0.0 && hit.inside >= OUTLINE_MARGIN && !other.two_sided && hit.t < back {
                (back, contact) = (hit.t, CONTACT_DISTANCE / hit.facing);
            }
            front.min(back + contact)
        });
        if back == MISS_DISTANCE || front < back - contact {
            return true;
        }
        meets_back |= back < front - contact;
    }
    !meets_back
}
