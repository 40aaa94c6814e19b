//! Views of one solution: the tone-mapped picture `preview.png` and the interactive page `view.html`, which `solve`,
//! `shoot` and `relight` write. The pages of `stress` and `table4` show the picture alone.

use super::coarse_solution::{CoarseSolution, drawn_sizes};
use super::picture::{Exposure, RgbaPicture};
use super::view::camera::Camera;
use super::view::interpolation::{CarriedLight, InterpolationSurface};
use super::view::render::ViewHits;
use super::viewer::{SceneViewer, ViewerLayer, is_constant_per_face};
use common::Result;
use common::mesh::Mesh;
use common::rays::Rays;
use common::scene::Scene;
use common::shooting::RadiosityField;
use common::solution::Solution;
use maud::Markup;

/// Pixels per side of the preview.
const PREVIEW_SIDE: u32 = 512;
/// Memory of the preview's view hits.
pub const PREVIEW_BYTES: u64 = ViewHits::memory_bytes(PREVIEW_SIDE);

/// Picture of a scene with its camera and exposure.
pub struct RenderedPreview {
    /// Camera: the given one, or the one that sees most of the scene.
    pub camera: Camera,
    /// Exposure.
    pub exposure: Exposure,
    /// Rendered picture.
    pub picture: RgbaPicture,
}

impl RenderedPreview {
    /// Renders the solution `field` on the texels of `mesh` through `camera`, or through the automatic camera.
    pub fn new(scene: &Scene, mesh: &Mesh, field: &RadiosityField, camera: Option<Camera>) -> Self {
        Self::of_surface(
            &InterpolationSurface::new(scene, mesh),
            field,
            CarriedLight::Irradiance,
            camera,
        )
    }

    /// Renders [`Self::new`] over a `surface`, interpolating `carried`.
    fn of_surface(
        surface: &InterpolationSurface,
        field: &RadiosityField,
        carried: CarriedLight,
        camera: Option<Camera>,
    ) -> Self {
        let rays = Rays::new(surface.mesh);
        let camera = camera.unwrap_or_else(|| Camera::automatic_view(surface.mesh, &rays));
        let view = ViewHits::new(&camera, surface, &rays, PREVIEW_SIDE);
        let light = surface.interpolate_light(field, carried);
        let exposure = view.choose_exposure(&light).with_shoulder();
        Self {
            picture: view.expose_light(&light, exposure),
            camera,
            exposure,
        }
    }
}

/// Rendered views, ready to be written.
pub struct RenderedView {
    /// Picture with camera and exposure.
    pub preview: RenderedPreview,
    /// Interactive viewer as an HTML element.
    pub element: Markup,
    /// Interactive viewer as a page of its own.
    pub page: String,
}

impl RenderedView {
    /// Renders the views through `camera`, or through the automatic one; solutions of too many texels are averaged
    /// first.
    ///
    /// Errors: those of [`Mesh::new`].
    pub fn new(solution: &Solution, camera: Option<Camera>) -> Result<Self> {
        let (scene, errors) = (solution.scene, solution.texel_error.as_deref());
        let own: (&Mesh, _, _) = (solution.mesh, &solution.run.field, [errors, solution.open]);
        let sizes: Vec<[u32; 2]> = solution.mesh.faces.iter().map(|face| face.resolution).collect();
        let (sizes, merged) = drawn_sizes(&sizes);
        let coarse = (merged > 1)
            .then(|| CoarseSolution::new(scene, own, &sizes))
            .transpose()?;
        let (mesh, field, [texel_errors, open]) = match &coarse {
            Some(shown) => (
                &shown.mesh,
                &shown.field,
                [&shown.texel_errors, &shown.open].map(Option::as_deref),
            ),
            None => own,
        };
        let surface = InterpolationSurface::with_welding(scene, mesh, open, |_, _| true);
        // A captured room's ρ and E were recovered texel by texel.
        let carried = match scene.is_painted() || is_constant_per_face(mesh) {
            true => CarriedLight::Irradiance,
            false => CarriedLight::Radiosity,
        };
        let preview = RenderedPreview::of_surface(&surface, field, carried, camera);
        let name = solution.solver;
        let viewer = SceneViewer {
            scene,
            surface: &surface,
            layers: vec![ViewerLayer {
                name,
                mesh,
                field: Some(field),
            }],
            irradiance: true,
            carried,
            texel_errors,
            camera: preview.camera,
            exposure: preview.exposure,
        };
        let element = viewer.render_element();
        Ok(Self {
            page: viewer.render_page(element.clone(), &describe_solution(solution, merged)),
            element,
            preview,
        })
    }
}

/// Describes size, solver and error of the solution; `merged` is the number of texels per side averaged into one.
fn describe_solution(solution: &Solution, merged: u32) -> String {
    let error = solution.certificate.as_ref().and_then(|parts| parts["error"].as_f64());
    let error = error.map_or(String::new(), |error| {
        format!(", estimated error {:.1} %", 100.0 * error)
    });
    let means = match merged {
        1 => String::new(),
        _ => format!("; texels averaged in groups of {merged}×{merged}"),
    };
    format!(
        "{} faces, {} texels, solved on {}{error}{means}",
        solution.mesh.faces.len(),
        solution.mesh.texels.len(),
        solution.adapter.unwrap_or("the CPU"),
    )
}
