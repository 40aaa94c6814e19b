//! The camera through which a relit room is seen.

use super::Relit;
use crate::show::view::camera::Camera;
use common::mesh::Mesh;
use common::rays::Rays;
use glam::{DVec3, Vec3};

/// The share of the picture's height that a ball around the objects takes: they take a bit less.
const FILL: f32 = 0.5;
/// Vertical field of view, degrees: neither a telescope nor a fisheye.
const FOV: [f32; 2] = [35.0, 90.0];
/// Nearer to the objects' centre than so many of their radii, the eye steps back.
const NEAR: f32 = 1.6;
/// How far a camera steps back: so many radii of the objects, but no more than this share of the
/// way to the corner of the room.
const RADII: f32 = 6.0;
const BACK: f32 = 0.85;
/// View rays per side by which a viewpoint is judged.
const TRIAL: u32 = 64;
/// Below this share of a square picture objects count as out of view: a tenth of its height; at
/// the panorama's eye a twentieth, for nowhere else is the photograph as sharp.
const SEEN: f32 = 0.01;
const SEEN_FROM_EYE: f32 = 0.0025;

/// A camera given in scene coordinates, in those of the mesh.
pub fn camera_at(mesh: &Mesh, eye: DVec3, target: DVec3, fov_degrees: f64) -> Camera {
    let [eye, target] = [eye, target].map(|p| mesh.local(p).as_vec3());
    Camera::new(eye, target, fov_degrees as f32)
}

/// The camera if none is given. With a panorama: at its eye, where the photograph is as sharp as
/// it was taken, or a step towards the farthest corner if the eye is in or at the objects. Else
/// the whole scene from outside, if that shows the objects, or from a corner that does.
pub fn camera_for(relit: &Relit) -> Camera {
    let all = Rays::new(relit.mesh);
    let Some((centre, radius)) = ball(relit) else {
        return match relit.eye {
            Some(eye) => camera_at(relit.mesh, eye, eye + DVec3::Z, 75.0),
            None => Camera::automatic(relit.mesh, &all),
        };
    };
    let (first, least) = match relit.eye.map(|eye| relit.mesh.local(eye).as_vec3()) {
        Some(eye) if eye.distance(centre) < NEAR * radius => {
            return from_a_corner(relit, &all, centre, radius);
        }
        Some(eye) => (looking(eye, centre, radius), SEEN_FROM_EYE),
        None => (Camera::automatic(relit.mesh, &all), SEEN),
    };
    let share = seen(relit, &all, &first);
    if share >= least {
        return first;
    }
    let corner = from_a_corner(relit, &all, centre, radius);
    // The objects may be hidden from everywhere.
    if seen(relit, &all, &corner) > share {
        corner
    } else {
        first
    }
}

/// Centre and radius of a ball around the objects.
fn ball(relit: &Relit) -> Option<(Vec3, f32)> {
    let corners = || {
        let objects = relit.mesh.faces.iter().skip(relit.room);
        objects.flat_map(|face| face.corners)
    };
    let (low, high) = (corners().reduce(Vec3::min)?, corners().reduce(Vec3::max)?);
    let centre = (low + high) / 2.0;
    let radius = corners().map(|c| c.distance(centre)).fold(1e-6, f32::max);
    Some((centre, radius))
}

/// From `eye` at the ball, so wide that it fills its share of the height.
fn looking(eye: Vec3, centre: Vec3, radius: f32) -> Camera {
    let distance = eye.distance(centre).max(1e-6);
    let sine = (radius / distance).min(0.99);
    let half = (sine / (1.0 - sine * sine).sqrt() / FILL).atan();
    let fov = (2.0 * half.to_degrees()).clamp(FOV[0], FOV[1]);
    Camera::new(eye, centre, fov)
}

/// From near the farthest corner of the room that sees the objects about as well as any.
fn from_a_corner(relit: &Relit, all: &Rays, centre: Vec3, radius: f32) -> Camera {
    let corners = || {
        let room = relit.mesh.faces.iter().take(relit.room);
        room.flat_map(|face| face.corners)
    };
    let bounds = [
        corners().reduce(Vec3::min).unwrap_or(Vec3::NEG_ONE),
        corners().reduce(Vec3::max).unwrap_or(Vec3::ONE),
    ];
    // From above and in front first: the first of equally far ones is taken.
    let corner = |k: usize| {
        let [x, y, z] = [k & 1, 1 - (k >> 2 & 1), k >> 1 & 1];
        Vec3::new(bounds[x].x, bounds[y].y, bounds[z].z)
    };
    let mut cameras: Vec<(f32, f32, Camera)> = (0..8)
        .map(|k| {
            let way = corner(k) - centre;
            let distance = way.length();
            let eye = centre + way * BACK.min(RADII * radius / distance.max(1e-6));
            let camera = looking(eye, centre, radius);
            (distance, seen(relit, all, &camera), camera)
        })
        .collect();
    cameras.sort_by(|a, b| b.0.total_cmp(&a.0));
    let best = cameras.iter().map(|c| c.1).fold(0.0, f32::max);
    let first = cameras.iter().find(|c| c.1 >= 0.5 * best);
    first.map_or(Camera::new(Vec3::ZERO, centre, FOV[1]), |c| c.2)
}

/// The share of a square picture that shows objects.
fn seen(relit: &Relit, all: &Rays, camera: &Camera) -> f32 {
    let at = |k: u32| (k as f32 + 0.5) / TRIAL as f32 * 2.0 - 1.0;
    let hits = (0..TRIAL * TRIAL).filter(|k| {
        let direction = camera.direction(at(k % TRIAL), at(k / TRIAL));
        let hit = all.front(camera.eye, direction);
        hit.is_some_and(|(face, _)| relit.is_object(face))
    });
    hits.count() as f32 / (TRIAL * TRIAL) as f32
}
