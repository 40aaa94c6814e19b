//! Chooses the camera of a relit room's pictures where `--camera` does not give one.

use super::RelitScene;
use crate::report::view::camera::{Camera, TRIAL_RAY_COUNT};
use common::mesh::{Mesh, MeshFace};
use common::rays::Rays;
use glam::{DVec3, Vec3};

/// Share of the picture's height that the objects' bounding ball takes.
const BALL_HEIGHT_SHARE: f32 = 0.5;
/// Minimum and maximum vertical field of view, degrees.
const FOV_RANGE_DEGREES: [f32; 2] = [35.0, 90.0];
/// Minimum distance of the eye from the objects' centre, in radii of their ball.
const MIN_DISTANCE_RADII: f32 = 1.6;
/// Distance of a corner view from the objects' centre, in radii of their ball.
const CORNER_DISTANCE_RADII: f32 = 6.0;
/// Maximum share of the way to the room's corner.
const MAX_CORNER_SHARE: f32 = 0.85;
/// Minimum share of a square picture for objects to count as visible: a tenth of its height squared.
const MIN_VISIBLE_SHARE: f32 = 0.01;
/// The same at the panorama's eye, where the photograph is sharpest: a twentieth squared.
const MIN_VISIBLE_SHARE_FROM_EYE: f32 = 0.0025;

/// Converts a camera from scene to mesh coordinates.
pub fn camera_at(mesh: &Mesh, eye: DVec3, target: DVec3, fov_degrees: f64) -> Camera {
    let [eye, target] = [eye, target].map(|p| mesh.local_point(p).as_vec3());
    Camera::new(eye, target, fov_degrees as f32)
}

/// Chooses a camera: with a panorama at its eye, where the photograph is sharpest, else the whole scene from outside.
/// If the eye is too close to the objects, or they are hidden from there: of the eight views from near the room's
/// corners, and this one, the one that shows most of the objects.
pub fn automatic_camera(relit: &RelitScene) -> Camera {
    let all = Rays::new(relit.mesh);
    let (room, objects) = relit.mesh.faces.split_at(relit.room.min(relit.mesh.faces.len()));
    let Some([low, high]) = face_extent(objects) else {
        return match relit.eye {
            Some(eye) => camera_at(relit.mesh, eye, eye + DVec3::Z, 75.0),
            None => Camera::automatic_view(relit.mesh, &all),
        };
    };
    let centre = (low + high) / 2.0;
    let corners = objects.iter().flat_map(|face| face.corners);
    let radius = corners.map(|c| c.distance(centre)).fold(1e-6, f32::max);
    let eye = relit.eye.map(|eye| relit.mesh.local_point(eye).as_vec3());
    let (first, least) = match eye {
        Some(eye) => (look_at_ball(eye, centre, radius), MIN_VISIBLE_SHARE_FROM_EYE),
        None => (Camera::automatic_view(relit.mesh, &all), MIN_VISIBLE_SHARE),
    };
    let close = eye.is_some_and(|eye| eye.distance(centre) < MIN_DISTANCE_RADII * radius);
    let share = |camera: &Camera| visible_object_share(relit, &all, camera);
    if !close && share(&first) >= least {
        return first;
    }
    let bounds = face_extent(room).unwrap_or([Vec3::NEG_ONE, Vec3::ONE]);
    let corner_view = |k: usize| {
        let corner = Vec3::new(bounds[k & 1].x, bounds[k >> 1 & 1].y, bounds[k >> 2].z);
        let reach = CORNER_DISTANCE_RADII * radius / corner.distance(centre).max(1e-6);
        look_at_ball(centre.lerp(corner, MAX_CORNER_SHARE.min(reach)), centre, radius)
    };
    let views = (0..8).map(corner_view).chain((!close).then_some(first));
    let best = views.max_by(|a, b| share(a).total_cmp(&share(b)));
    best.unwrap_or(first)
}

/// Returns the lowest and the highest coordinates of faces; none without faces.
fn face_extent(faces: &[MeshFace]) -> Option<[Vec3; 2]> {
    let corners = || faces.iter().flat_map(|face| face.corners);
    Some([corners().reduce(Vec3::min)?, corners().reduce(Vec3::max)?])
}

/// Returns a camera at `eye` looking at the ball, with a field of view that gives it its share of the height.
fn look_at_ball(eye: Vec3, centre: Vec3, radius: f32) -> Camera {
    let distance = eye.distance(centre).max(1e-6);
    let sine = (radius / distance).min(0.99);
    let half = (sine / (1.0 - sine * sine).sqrt() / BALL_HEIGHT_SHARE).atan();
    let fov = (2.0 * half.to_degrees()).clamp(FOV_RANGE_DEGREES[0], FOV_RANGE_DEGREES[1]);
    Camera::new(eye, centre, fov)
}

/// Returns the share of a square picture that shows objects.
fn visible_object_share(relit: &RelitScene, all: &Rays, camera: &Camera) -> f32 {
    let hits = camera.trial_directions().filter(|direction| {
        let hit = all.nearest_front(camera.eye, *direction);
        hit.is_some_and(|(face, _)| relit.is_object(face))
    });
    hits.count() as f32 / TRIAL_RAY_COUNT as f32
}
