//! Chooses the camera of a relit room's pictures.

use super::RelitScene;
use crate::report::view::camera::Camera;
use common::mesh::Mesh;
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
/// View rays per side that score a viewpoint.
const TRIAL_RAYS_PER_SIDE: u32 = 64;
/// Minimum share of a square picture for objects to count as visible: a tenth of its height squared.
const MIN_VISIBLE_SHARE: f32 = 0.01;
/// The same at the panorama's eye, where the photograph is sharpest: a twentieth squared.
const MIN_VISIBLE_SHARE_FROM_EYE: f32 = 0.0025;

/// Converts a camera from scene to mesh coordinates.
pub fn camera_at(mesh: &Mesh, eye: DVec3, target: DVec3, fov_degrees: f64) -> Camera {
    let [eye, target] = [eye, target].map(|p| mesh.local_point(p).as_vec3());
    Camera::new(eye, target, fov_degrees as f32)
}

/// Chooses a camera. With a panorama: at its eye, where the photograph is sharpest, or towards the farthest corner
/// if the eye is too close to the objects. Otherwise: the whole scene from outside if that shows the objects, or a
/// corner view.
pub fn automatic_camera(relit: &RelitScene) -> Camera {
    let all = Rays::new(relit.mesh);
    let Some((centre, radius)) = bounding_ball(relit) else {
        return match relit.eye {
            Some(eye) => camera_at(relit.mesh, eye, eye + DVec3::Z, 75.0),
            None => Camera::automatic_view(relit.mesh, &all),
        };
    };
    let (first, least) = match relit.eye.map(|eye| relit.mesh.local_point(eye).as_vec3()) {
        Some(eye) if eye.distance(centre) < MIN_DISTANCE_RADII * radius => {
            return view_from_corner(relit, &all, centre, radius);
        }
        Some(eye) => (look_at_ball(eye, centre, radius), MIN_VISIBLE_SHARE_FROM_EYE),
        None => (Camera::automatic_view(relit.mesh, &all), MIN_VISIBLE_SHARE),
    };
    let share = visible_object_share(relit, &all, &first);
    if share >= least {
        return first;
    }
    let corner = view_from_corner(relit, &all, centre, radius);
    // The objects may be hidden from all viewpoints.
    if visible_object_share(relit, &all, &corner) > share {
        corner
    } else {
        first
    }
}

/// Returns centre and radius of the objects' bounding ball; none without objects.
fn bounding_ball(relit: &RelitScene) -> Option<(Vec3, f32)> {
    let corners = || {
        let objects = relit.mesh.faces.iter().skip(relit.room);
        objects.flat_map(|face| face.corners)
    };
    let (low, high) = (corners().reduce(Vec3::min)?, corners().reduce(Vec3::max)?);
    let centre = (low + high) / 2.0;
    let radius = corners().map(|c| c.distance(centre)).fold(1e-6, f32::max);
    Some((centre, radius))
}

/// Returns a camera at `eye` looking at the ball, with a field of view that gives it its share of the height.
fn look_at_ball(eye: Vec3, centre: Vec3, radius: f32) -> Camera {
    let distance = eye.distance(centre).max(1e-6);
    let sine = (radius / distance).min(0.99);
    let half = (sine / (1.0 - sine * sine).sqrt() / BALL_HEIGHT_SHARE).atan();
    let fov = (2.0 * half.to_degrees()).clamp(FOV_RANGE_DEGREES[0], FOV_RANGE_DEGREES[1]);
    Camera::new(eye, centre, fov)
}

/// Returns a camera near the farthest corner of the room that sees at least half of the best corner's share of
/// objects.
fn view_from_corner(relit: &RelitScene, all: &Rays, centre: Vec3, radius: f32) -> Camera {
    let corners = || {
        let room = relit.mesh.faces.iter().take(relit.room);
        room.flat_map(|face| face.corners)
    };
    let bounds = [
        corners().reduce(Vec3::min).unwrap_or(Vec3::NEG_ONE),
        corners().reduce(Vec3::max).unwrap_or(Vec3::ONE),
    ];
    // Upper front corners first: the first of equally distant ones is taken.
    let corner = |k: usize| {
        let [x, y, z] = [k & 1, 1 - (k >> 2 & 1), k >> 1 & 1];
        Vec3::new(bounds[x].x, bounds[y].y, bounds[z].z)
    };
    let mut cameras: Vec<(f32, f32, Camera)> = (0..8)
        .map(|k| {
            let way = corner(k) - centre;
            let distance = way.length();
            let eye = centre + way * MAX_CORNER_SHARE.min(CORNER_DISTANCE_RADII * radius / distance.max(1e-6));
            let camera = look_at_ball(eye, centre, radius);
            (distance, visible_object_share(relit, all, &camera), camera)
        })
        .collect();
    cameras.sort_by(|a, b| b.0.total_cmp(&a.0));
    let best = cameras.iter().map(|c| c.1).fold(0.0, f32::max);
    let first = cameras.iter().find(|c| c.1 >= 0.5 * best);
    first.map_or(Camera::new(Vec3::ZERO, centre, FOV_RANGE_DEGREES[1]), |c| c.2)
}

/// Returns the share of a square picture that shows objects.
fn visible_object_share(relit: &RelitScene, all: &Rays, camera: &Camera) -> f32 {
    let at = |k: u32| (k as f32 + 0.5) / TRIAL_RAYS_PER_SIDE as f32 * 2.0 - 1.0;
    let hits = (0..TRIAL_RAYS_PER_SIDE * TRIAL_RAYS_PER_SIDE).filter(|k| {
        let direction = camera.ray_direction(at(k % TRIAL_RAYS_PER_SIDE), at(k / TRIAL_RAYS_PER_SIDE));
        let hit = all.nearest_front(camera.eye, direction);
        hit.is_some_and(|(face, _)| relit.is_object(face))
    });
    hits.count() as f32 / (TRIAL_RAYS_PER_SIDE * TRIAL_RAYS_PER_SIDE) as f32
}
