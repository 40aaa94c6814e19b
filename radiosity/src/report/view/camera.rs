//! Pinhole camera of the pages' pictures and viewers, given or chosen to see most of the scene's front faces.
//!
//! Back faces are transparent, so a closed room is visible from outside.

use crate::report::format::format_number;
use common::mesh::Mesh;
use common::rays::Rays;
use glam::{Mat3, Vec3};
use rayon::prelude::*;

/// View rays per side that score a viewpoint.
const TRIAL_RAYS_PER_SIDE: u32 = 64;
/// View rays that score a viewpoint.
pub const TRIAL_RAY_COUNT: u32 = TRIAL_RAYS_PER_SIDE * TRIAL_RAYS_PER_SIDE;
/// Share of the picture's half height that the scene takes at most, to the sides as well as up and down.
const FRAME_FILL_SHARE: f32 = 0.96;
/// Vertical field of view of the automatic camera, degrees.
const FOV_DEGREES: f32 = 40.0;
/// Visible share by which a later viewpoint must exceed all earlier ones: views along an axis come first and win ties.
const MIN_SCORE_GAIN: f32 = 0.02;

/// Pinhole camera in mesh coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Eye position.
    pub eye: Vec3,
    /// Point at the picture's centre.
    pub target: Vec3,
    /// Up direction.
    pub up: Vec3,
    /// Vertical field of view, degrees.
    pub fov_degrees: f32,
}

impl Camera {
    /// Creates a camera with y up.
    pub fn new(eye: Vec3, target: Vec3, fov_degrees: f32) -> Self {
        Self {
            eye,
            target,
            up: Vec3::Y,
            fov_degrees,
        }
    }

    /// Returns the right, up and forward vectors; an arbitrary frame for degenerate parameters.
    pub fn camera_basis(&self) -> Mat3 {
        let forward = (self.target - self.eye).normalize_or(Vec3::NEG_Z);
        let right = forward
            .cross(self.up)
            .try_normalize()
            .unwrap_or_else(|| forward.any_orthonormal_vector());
        Mat3::from_cols(right, right.cross(forward), forward)
    }

    /// Returns half the picture's height at distance 1.
    pub fn half_height(&self) -> f32 {
        (self.fov_degrees.clamp(0.01, 179.0).to_radians() / 2.0).tan()
    }

    /// Iterates over the directions of the [`TRIAL_RAY_COUNT`] view rays that score a viewpoint.
    pub fn trial_directions(&self) -> impl Iterator<Item = Vec3> {
        let at = |k: u32| (k as f32 + 0.5) / TRIAL_RAYS_PER_SIDE as f32 * 2.0 - 1.0;
        let ray = self.ray_generator();
        (0..TRIAL_RAY_COUNT).map(move |k| ray(at(k % TRIAL_RAYS_PER_SIDE), at(k / TRIAL_RAYS_PER_SIDE)))
    }

    /// Returns the function from a point of the picture, x right and y up, to the unit direction through it: y is in
    /// −1…1, and x in −w/h…w/h for w×h pixels.
    pub fn ray_generator(&self) -> impl Fn(f32, f32) -> Vec3 + use<> {
        let (frame, extent) = (self.camera_basis(), self.half_height());
        move |x, y| (frame * Vec3::new(x * extent, y * extent, 1.0)).normalize()
    }

    /// Returns the remark below pictures of two solutions from this camera. The exposure is that of `whose` solution, such
    /// as "the CPU's", and shows radiosity `white` (W/m²) as white.
    pub fn describe_views(&self, whose: &str, white: f32) -> String {
        let eye = self.eye.to_array().map(|x| format_number(f64::from(x)));
        format!(
            "All from one automatic camera (at {} in the mesh's unit; back faces are transparent). The views share one \
             exposure: the 90th percentile of {whose} reflected radiosity is at 80 % of white, which is {} W/m². Magenta \
             stands for “not a number”. Light is interpolated between texels.",
            eye.join(", "),
            format_number(f64::from(white))
        )
    }

    /// Chooses the viewpoint of a fixed set that sees the largest share of the front faces' area; the first of
    /// about equal ones.
    pub fn automatic_view(mesh: &Mesh, rays: &Rays) -> Self {
        Self::best_view(mesh, rays, None, candidate_directions())
    }

    /// Chooses an oblique viewpoint, slightly above or below; `face` has as much weight as all faces together.
    pub fn oblique_view(mesh: &Mesh, rays: &Rays, face: u32) -> Self {
        let sides = [(-0.4, -1.0), (-0.4, 1.0), (-1.0, 0.4), (1.0, 0.4)];
        let above = sides.map(|(x, z)| elevated_direction(x, z, 16.0));
        let below = sides.map(|(x, z)| elevated_direction(x, z, -24.0));
        Self::best_view(mesh, rays, Some(face), above.into_iter().chain(below))
    }

    fn best_view(mesh: &Mesh, rays: &Rays, face: Option<u32>, viewpoints: impl IntoIterator<Item = Vec3>) -> Self {
        let viewpoints: Vec<Vec3> = viewpoints.into_iter().collect();
        let scored = viewpoints.into_par_iter().map(|towards_eye| {
            let camera = Self::view_from_outside(mesh, towards_eye);
            (camera.visible_share(mesh, rays, face), camera)
        });
        let mut best: Option<(f32, Self)> = None;
        for (score, camera) in scored.collect::<Vec<_>>() {
            if best.is_none_or(|(most, _)| score > most + MIN_SCORE_GAIN) {
                best = Some((score, camera));
            }
        }
        best.map_or(Self::new(Vec3::NEG_Z * 4.0, Vec3::ZERO, FOV_DEGREES), |(_, camera)| {
            camera
        })
    }

    /// Returns the camera in direction `towards_eye` whose picture contains the whole scene.
    fn view_from_outside(mesh: &Mesh, towards_eye: Vec3) -> Self {
        let corners = || mesh.faces.iter().flat_map(|face| face.corners);
        let low = corners().reduce(Vec3::min).unwrap_or(Vec3::NEG_ONE);
        let high = corners().reduce(Vec3::max).unwrap_or(Vec3::ONE);
        let target = (low + high) / 2.0;
        let camera = Self::new(target + towards_eye, target, FOV_DEGREES);
        let (frame, extent) = (camera.camera_basis(), camera.half_height() * FRAME_FILL_SHARE);
        let distance = corners()
            .map(|corner| {
                let p = frame.transpose() * (corner - target);
                p.x.abs().max(p.y.abs()) / extent - p.z
            })
            .fold(0.1, f32::max);
        Self {
            eye: target + towards_eye * distance,
            ..camera
        }
    }

    /// Returns the visible share of the front faces' area, each face at most once, plus the visible share of
    /// `chosen`.
    fn visible_share(&self, mesh: &Mesh, rays: &Rays, chosen: Option<u32>) -> f32 {
        let mut seen = vec![0.0; mesh.faces.len()];
        let pixel = (2.0 / TRIAL_RAYS_PER_SIDE as f32 * self.half_height()).powi(2);
        let forward = self.camera_basis().z_axis;
        for direction in self.trial_directions() {
            if let Some((face, t)) = rays.nearest_front(self.eye, direction) {
                let cosine = -mesh.faces[face as usize].normal.dot(direction);
                seen[face as usize] += t * t * pixel * forward.dot(direction).powi(3) / cosine;
            }
        }
        let area = |face: usize| {
            let [a, b, c, d] = mesh.faces[face].corners;
            (c - a).cross(d - b).length() / 2.0
        };
        let share = |faces: std::ops::Range<usize>| {
            let total: f32 = faces.clone().map(area).sum();
            let visible: f32 = faces.map(|face| area(face).min(seen[face])).sum();
            if total > 0.0 { visible / total } else { 0.0 }
        };
        let chosen = chosen.map(|face| face as usize).filter(|k| *k < seen.len());
        share(0..seen.len()) + chosen.map_or(0.0, |k| share(k..k + 1))
    }
}

/// Returns unit directions towards the eye: along the axes, then three-quarter views from above and below.
fn candidate_directions() -> Vec<Vec3> {
    let straight = [(0.0, -1.0), (0.0, 1.0), (-1.0, 0.0), (1.0, 0.0)];
    let aslant = [(-0.6, -1.0), (0.6, -1.0), (-0.6, 1.0), (0.6, 1.0)];
    straight
        .map(|(x, z)| elevated_direction(x, z, 0.0))
        .into_iter()
        .chain(aslant.map(|(x, z)| elevated_direction(x, z, 24.0)))
        .chain(aslant.map(|(x, z)| elevated_direction(x, z, -24.0)))
        .collect()
}

/// Returns the unit direction over (x, z) at `degrees` above the horizon.
fn elevated_direction(x: f32, z: f32, degrees: f32) -> Vec3 {
    let (s, c) = degrees.to_radians().sin_cos();
    (Vec3::new(x, 0.0, z).normalize() * c).with_y(s)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec2;

    #[test]
    fn ray_directions_project_to_their_picture_points() {
        let camera = Camera::new(Vec3::new(1.0, 2.0, -5.0), Vec3::new(0.3, 0.0, 1.0), 50.0);
        for at in [[0.0, 0.0], [0.7, -0.4], [-1.0, 1.0]].map(Vec2::from) {
            let p = camera.camera_basis().transpose() * camera.ray_generator()(at.x, at.y);
            assert!(p.z > 0.0, "{at}");
            assert!(
                (p.truncate() / p.z).distance(at * 25_f32.to_radians().tan()) < 1e-5,
                "{at}"
            );
        }
    }
}
