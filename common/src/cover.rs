//! Where a body stands on a face: such a point sees neither a front nor the open.

use crate::constants::{CONTACT, MISS, OUTLINE};
use crate::escape::directions;
use crate::intersect::intersect;
use crate::mesh::{Cover, Mesh, MeshFace};
use crate::rays::Rays;
use crate::scene::Scene;
use crate::settings::Meshing;
use crate::{Error, Result};
use glam::Vec3;
use rayon::prelude::*;
use std::hint::black_box;
use std::time::Instant;

/// One in so many of the escape directions is asked, 34 of 1024, in every column of their grid: a
/// point is taken for covered only if all of them meet backs.
const STEP: usize = 31;

/// Points by which the time is told.
const TRIED: usize = 1024;
/// Points between two looks at whether to go on.
const TASK: usize = 64;

/// The directions that are asked.
pub fn asked() -> Vec<Vec3> {
    directions().into_iter().step_by(STEP).collect()
}

/// Asked now and then whether to stop.
pub type Stop<'a> = &'a (dyn Fn() -> bool + Sync);

/// The mesh of a scene with the same texels and cells on each of its faces.
pub fn sampled(scene: &Scene, meshing: &Meshing) -> Result<Mesh> {
    sampled_until(scene, meshing, &|| false)
}

/// The same, unless it is stopped: then the error is [`Error::Interrupted`].
pub fn sampled_until(scene: &Scene, meshing: &Meshing, stop: Stop) -> Result<Mesh> {
    let mut mesh = Mesh::uniform(scene, meshing.texels, meshing.cells)?;
    sample_until(&mut mesh, meshing.samples, stop)?;
    Ok(mesh)
}

/// The mesh of a scene whose first `room` faces are a room and the others objects in it, with N×N
/// texels on each of its faces as `resolutions` says, K×K cells and `samples` points on each.
pub fn furnished(
    scene: &Scene,
    room: usize,
    resolutions: &[[u32; 2]],
    [cells, samples]: [u32; 2],
) -> Result<Mesh> {
    furnished_until(scene, room, resolutions, [cells, samples], &|| false)
}

/// The same, unless it is stopped.
pub fn furnished_until(
    scene: &Scene,
    room: usize,
    resolutions: &[[u32; 2]],
    [cells, samples]: [u32; 2],
    stop: Stop,
) -> Result<Mesh> {
    let mut mesh = Mesh::new(scene, resolutions, cells)?;
    mesh.room = room as u32;
    sample_until(&mut mesh, samples, stop)?;
    Ok(mesh)
}

/// Looks at each cell of `mesh` in `samples` points, and marks those on which a body stands.
pub fn sample(mesh: &mut Mesh, samples: u32) {
    // Never stopped.
    let _ = sample_until(mesh, samples, &|| false);
}

/// Seconds that it will take to see what stands on the points of `mesh`, from a few of them.
pub fn seconds(mesh: &Mesh) -> f64 {
    if mesh.samples <= 1 {
        return 0.0;
    }
    let rays = Rays::new(mesh);
    let directions = asked();
    let step = mesh.points.len().div_ceil(TRIED);
    let start = Instant::now();
    let tried: Vec<usize> = (0..mesh.points.len()).step_by(step).collect();
    let open = tried.par_iter().filter(|k| {
        let cell = &mesh.cells[**k / mesh.samples as usize];
        let (face, point) = (&mesh.faces[cell.face as usize], mesh.points[**k].position);
        open(&rays, mesh.faces.len(), face, point, &directions)
    });
    black_box(open.count());
    start.elapsed().as_secs_f64() * step as f64
}

fn sample_until(mesh: &mut Mesh, samples: u32, stop: Stop) -> Result<()> {
    mesh.sample(samples);
    if samples <= 1 {
        return Ok(());
    }
    let rays = Rays::new(mesh);
    let directions = asked();
    let (room, all) = (mesh.room as usize, mesh.faces.len());
    let cover = |k: usize| {
        let cell = &mesh.cells[k / samples as usize];
        let (face, point) = (&mesh.faces[cell.face as usize], mesh.points[k].position);
        let open = |faces| open(&rays, faces, face, point, &directions);
        if cell.shooter.area <= 0.0 || open(all) {
            Cover::Open
        } else if room < all && open(room) {
            Cover::Object
        } else {
            Cover::Room
        }
    };
    let mut covers = vec![Cover::Open; mesh.points.len()];
    let tasks = covers.par_chunks_mut(TASK).enumerate();
    tasks.for_each(|(task, covers)| {
        if !stop() {
            for (k, own) in covers.iter_mut().enumerate() {
                *own = cover(task * TASK + k);
            }
        }
    });
    if stop() {
        return Err(Error::Interrupted);
    }
    mesh.cover(&covers);
    Ok(())
}

/// Whether a point of `face` sees anything else than backs, of the first `faces` faces, in some of the
/// [directions that are asked](asked).
pub fn open(rays: &Rays, faces: usize, face: &MeshFace, point: Vec3, directions: &[Vec3]) -> bool {
    let bitangent = face.normal.cross(face.tangent);
    directions.iter().any(|d| {
        let direction = face.tangent * d.x + bitangent * d.y + face.normal * d.z;
        leaves(rays, faces, face.sheet, point, direction)
    })
}

/// Whether the ray meets a front before a back, or nothing. A face that touches the point is passed
/// over: it may be the other side of a thin wall; a body has more faces behind it.
fn leaves(rays: &Rays, faces: usize, sheet: u32, origin: Vec3, direction: Vec3) -> bool {
    let mut front = MISS;
    let mut back = MISS;
    rays.along(origin, direction, |k, face| {
        let hit = intersect(face, origin, direction);
        let touches = (hit.t * hit.facing).abs() <= CONTACT;
        if k as usize >= faces || face.sheet == sheet || hit.t <= 0.0 || touches {
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
