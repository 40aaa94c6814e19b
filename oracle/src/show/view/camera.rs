//! The camera: given, or one from which most of the scene's fronts are seen.
//!
//! Backs are looked through, so a closed room is seen from outside like a doll's house.

use common::mesh::Mesh;
use common::rays::Rays;
use glam::{Mat3, Vec2, Vec3};

/// View rays per side by which a viewpoint is judged.
const TRIAL: u32 = 64;
/// The scene takes this share of the picture's half width.
const FILL: f32 = 0.96;
/// Vertical field of view of the automatic camera, degrees.
const FOV_DEGREES: f32 = 40.0;
/// A later viewpoint must show this much more of the area (the first ones look straight in).
const PREFERENCE: f32 = 0.02;

/// A pinhole camera in the mesh's coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Where it stands.
    pub eye: Vec3,
    /// What it looks at.
    pub target: Vec3,
    /// What is up in the picture.
    pub up: Vec3,
    /// Vertical field of view, degrees.
    pub fov_degrees: f32,
}

impl Camera {
    /// A camera with y up.
    pub fn new(eye: Vec3, target: Vec3, fov_degrees: f32) -> Self {
        Self {
            eye,
            target,
            up: Vec3::Y,
            fov_degrees,
        }
    }

    /// Right, up and forward; some frame even where the parameters do not define one.
    pub fn frame(&self) -> Mat3 {
        let forward = (self.target - self.eye).normalize_or(Vec3::NEG_Z);
        let right = forward
            .cross(self.up)
            .try_normalize()
            .unwrap_or_else(|| forward.any_orthonormal_vector());
        Mat3::from_cols(right, right.cross(forward), forward)
    }

    /// Half the picture's height at distance 1.
    pub fn extent(&self) -> f32 {
        (self.fov_degrees.clamp(0.01, 179.0).to_radians() / 2.0).tan()
    }

    /// Where a point lies in the picture, x right and y up as in [`Camera::direction`]; none
    /// behind the camera.
    pub fn project(&self, point: Vec3) -> Option<Vec2> {
        let p = self.frame().transpose() * (point - self.eye);
        (p.z > 0.0).then(|| p.truncate() / (p.z * self.extent()))
    }

    /// The unit direction through a point of the picture, x right and y up: y runs over −1…1, and
    /// so does x in a square picture; in one of w×h pixels x runs over −w/h…w/h.
    pub fn direction(&self, x: f32, y: f32) -> Vec3 {
        self.lens()(x, y)
    }

    /// [`Camera::direction`], prepared for many rays.
    pub fn lens(&self) -> impl Fn(f32, f32) -> Vec3 + use<> {
        let (frame, extent) = (self.frame(), self.extent());
        move |x, y| (frame * Vec3::new(x * extent, y * extent, 1.0)).normalize()
    }

    /// From a fixed set of viewpoints, the one that sees the largest share of the scene's
    /// fronts; the first of about equal ones.
    pub fn automatic(mesh: &Mesh, rays: &Rays) -> Self {
        Self::best(mesh, rays, None, viewpoints())
    }

    /// The same from a little above and to one side, so that depth shows; `face` counts for as much
    /// as all together.
    pub fn aslant(mesh: &Mesh, rays: &Rays, face: u32) -> Self {
        let sides = [(-0.4, -1.0), (-0.4, 1.0), (-1.0, 0.4), (1.0, 0.4)];
        let above = sides.map(|(x, z)| elevated(x, z, 16.0));
        let below = sides.map(|(x, z)| elevated(x, z, -24.0));
        Self::best(mesh, rays, Some(face), above.into_iter().chain(below))
    }

    fn best(
        mesh: &Mesh,
        rays: &Rays,
        face: Option<u32>,
        viewpoints: impl IntoIterator<Item = Vec3>,
    ) -> Self {
        let mut best: Option<(f32, Self)> = None;
        for towards_eye in viewpoints {
            let camera = Self::outside(mesh, towards_eye);
            let score = camera.visible_share(mesh, rays, face);
            if best.is_none_or(|(most, _)| score > most + PREFERENCE) {
                best = Some((score, camera));
            }
        }
        best.map_or(
            Self::new(Vec3::NEG_Z * 4.0, Vec3::ZERO, FOV_DEGREES),
            |(_, camera)| camera,
        )
    }

    /// The camera in direction `towards_eye` that has the whole scene in its picture.
    fn outside(mesh: &Mesh, towards_eye: Vec3) -> Self {
        let corners = || mesh.faces.iter().flat_map(|face| face.corners);
        let low = corners().reduce(Vec3::min).unwrap_or(Vec3::NEG_ONE);
        let high = corners().reduce(Vec3::max).unwrap_or(Vec3::ONE);
        let target = (low + high) / 2.0;
        let camera = Self::new(target + towards_eye, target, FOV_DEGREES);
        let (frame, extent) = (camera.frame(), camera.extent() * FILL);
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

    /// The share of the fronts' area that is seen; no face counts for more than it has, and
    /// `chosen` once more by itself.
    fn visible_share(&self, mesh: &Mesh, rays: &Rays, chosen: Option<u32>) -> f32 {
        let mut seen = vec![0.0; mesh.faces.len()];
        let step = 2.0 / TRIAL as f32;
        let pixel = (step * self.extent()).powi(2);
        let forward = self.frame().z_axis;
        for k in 0..TRIAL * TRIAL {
            let at = |k: u32| (k as f32 + 0.5) * step - 1.0;
            let direction = self.direction(at(k % TRIAL), at(k / TRIAL));
            if let Some((face, t)) = rays.front(self.eye, direction) {
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

/// Unit directions towards the eye: straight on, then three-quarter views from above and below.
fn viewpoints() -> Vec<Vec3> {
    let straight = [(0.0, -1.0), (0.0, 1.0), (-1.0, 0.0), (1.0, 0.0)];
    let aslant = [(-0.6, -1.0), (0.6, -1.0), (-0.6, 1.0), (0.6, 1.0)];
    straight
        .map(|(x, z)| elevated(x, z, 0.0))
        .into_iter()
        .chain(aslant.map(|(x, z)| elevated(x, z, 24.0)))
        .chain(aslant.map(|(x, z)| elevated(x, z, -24.0)))
        .collect()
}

/// The unit direction over (x, z), so many degrees above the horizon.
fn elevated(x: f32, z: f32, degrees: f32) -> Vec3 {
    let (s, c) = degrees.to_radians().sin_cos();
    (Vec3::new(x, 0.0, z).normalize() * c).with_y(s)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_is_seen_where_it_is_projected() {
        let camera = Camera::new(Vec3::new(1.0, 2.0, -5.0), Vec3::new(0.3, 0.0, 1.0), 50.0);
        for at in [[0.0, 0.0], [0.7, -0.4], [-1.0, 1.0]].map(Vec2::from) {
            let point = camera.eye + camera.direction(at.x, at.y) * 3.0;
            let seen = camera.project(point);
            assert!(seen.is_some_and(|seen| seen.distance(at) < 1e-5));
        }
        assert_eq!(camera.project(Vec3::new(1.0, 2.0, -9.0)), None);
    }
}
