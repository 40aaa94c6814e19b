//! Preview: one tone-mapped picture of a solved scene, `preview.png`.

use super::picture::{Exposure, RgbaPicture};
use super::view::camera::Camera;
use super::view::interpolation::InterpolationSurface;
use super::view::render::ViewHits;
use common::mesh::Mesh;
use common::rays::Rays;
use common::scene::Scene;
use common::shooting::RadiosityField;

/// Pixels per side of the preview.
const PREVIEW_SIDE: u32 = 512;
/// Memory of the preview's view hits.
pub const PREVIEW_BYTES: u64 = ViewHits::memory_bytes(PREVIEW_SIDE);

/// Picture of a scene with its camera and exposure.
pub struct Preview {
    /// Camera: the given one, or the one that sees most of the scene.
    pub camera: Camera,
    /// Exposure.
    pub exposure: Exposure,
    /// Rendered picture.
    pub picture: RgbaPicture,
}

impl Preview {
    /// Renders the solution `field` on the texels of `mesh` through `camera`, or through the automatic camera.
    pub fn new(scene: &Scene, mesh: &Mesh, field: &RadiosityField, camera: Option<Camera>) -> Self {
        let rays = Rays::new(mesh);
        let camera = camera.unwrap_or_else(|| Camera::automatic_view(mesh, &rays));
        let surface = InterpolationSurface::new(scene, mesh);
        let view = ViewHits::new(&camera, &surface, &rays, PREVIEW_SIDE);
        let light = surface.interpolate(&field.irradiance);
        let exposure = view.choose_exposure(&light).with_shoulder();
        Self {
            picture: view.expose_light(&light, exposure),
            camera,
            exposure,
        }
    }
}
