//! Preview: one tone-mapped picture of a solved scene, `preview.png`.

use super::picture::{Exposure, RgbaPicture};
use super::tone_mapping::ToneCurve;
use super::view::camera::Camera;
use super::view::interpolation::{InterpolatedField, InterpolationSurface};
use super::view::render::ViewHits;
use common::mesh::Mesh;
use common::rays::Rays;
use common::scene::Scene;
use common::shooting::RadiosityField;
use glam::Vec3;

/// Pixels per side of the preview.
const PREVIEW_SIDE: u32 = 512;
/// Memory of the preview's view hits.
pub const PREVIEW_BYTES: u64 = ViewHits::memory_bytes(PREVIEW_SIDE);
/// Every `STRIDE`th view sample enters the choice of exposure.
const EXPOSURE_SAMPLE_STRIDE: usize = 5;

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
        let exposure = choose_exposure(&view, &light).opened_by(0.0, ToneCurve::Filmic);
        Self {
            picture: view.shade_hits(|hit| exposure.display_light(light.radiosity_at(&hit.stencil))),
            camera,
            exposure,
        }
    }
}

/// Chooses the exposure from the reflected radiosity of the visible texels that emit nothing.
pub fn choose_exposure(view: &ViewHits, light: &InterpolatedField) -> Exposure {
    Exposure::from_percentile(view.iter_hits().step_by(EXPOSURE_SAMPLE_STRIDE).filter_map(|hit| {
        let texel = light.surface.mesh.texels.get(hit.stencil.texel as usize)?;
        let reflected = light.radiosity_at(&hit.stencil) - texel.emission;
        (texel.emission == Vec3::ZERO).then_some((reflected.max_element(), 1.0))
    }))
}
