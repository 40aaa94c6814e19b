//! One picture of a solved scene, for who wants to see first.

use super::picture::{Exposure, Picture};
use super::tone::Curve;
use super::view::camera::Camera;
use super::view::render::View;
use super::view::surface::{Interpolant, Surface};
use common::mesh::Mesh;
use common::rays::Rays;
use common::scene::Scene;
use common::shooting::Field;
use glam::Vec3;

/// Pixels a side.
const SIZE: u32 = 512;
/// What its view rays hit, in memory.
pub const BYTES: u64 = View::bytes(SIZE);
/// Every how manieth sample decides the exposure.
const STRIDE: usize = 5;

/// A picture, and how it was taken.
pub struct Preview {
    /// From where most of the scene is seen.
    pub camera: Camera,
    /// What is white.
    pub exposure: Exposure,
    /// The picture.
    pub picture: Picture,
}

impl Preview {
    /// Of `scene` as `field` has solved it on the texels of `mesh`, through `camera` or one of its own.
    pub fn new(scene: &Scene, mesh: &Mesh, field: &Field, camera: Option<Camera>) -> Self {
        let rays = Rays::new(mesh);
        let camera = camera.unwrap_or_else(|| Camera::automatic(mesh, &rays));
        let surface = Surface::new(scene, mesh);
        let view = View::new(&camera, &surface, &rays, SIZE);
        let light = surface.interpolate(&field.irradiance);
        let exposure = exposure(&view, &light).opened(0.0, Curve::Filmic);
        Self {
            picture: view.shade(|hit| exposure.display(light.radiosity(&hit.stencil))),
            camera,
            exposure,
        }
    }
}

/// From the reflected radiosity that is seen.
pub fn exposure(view: &View, light: &Interpolant) -> Exposure {
    Exposure::of(view.hits().step_by(STRIDE).filter_map(|hit| {
        let texel = light.surface.mesh.texels.get(hit.stencil.texel as usize)?;
        let reflected = light.radiosity(&hit.stencil) - texel.emission;
        (texel.emission == Vec3::ZERO).then_some((reflected.max_element(), 1.0))
    }))
}
