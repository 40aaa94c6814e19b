//! Views of one solution: `preview.png` and the interactive page `view.html`.

use super::coarse_solution::CoarseSolution;
use super::preview::Preview;
use super::view::camera::Camera;
use super::viewer::{SceneViewer, ViewerLayer};
use common::Result;
use common::mesh::Mesh;
use common::scene::Scene;
use common::shooting::RadiosityField;
use maud::Markup;

/// Solution to be viewed.
pub struct SolutionView<'a> {
    /// Faces.
    pub scene: &'a Scene,
    /// Texels with ρ and E.
    pub mesh: &'a Mesh,
    /// Radiosity and irradiance.
    pub field: &'a RadiosityField,
    /// Error estimate per texel, W/m².
    pub texel_errors: Option<&'a [f32]>,
    /// Name of the solver.
    pub solver: &'a str,
    /// GPU adapter; none for the CPU.
    pub adapter: Option<&'a str>,
    /// Estimated relative error of the whole solution.
    pub error: Option<f64>,
    /// Camera; none for the automatic one.
    pub camera: Option<Camera>,
}

/// Rendered views, ready to be written.
pub struct RenderedView {
    /// Picture with camera and exposure.
    pub preview: Preview,
    /// Interactive viewer as an HTML element.
    pub element: Markup,
    /// Interactive viewer as a page of its own.
    pub page: String,
}

impl SolutionView<'_> {
    /// Renders the views; solutions of too many texels are averaged first.
    ///
    /// Errors: those of [`Mesh::new`].
    pub fn render_view(&self) -> Result<RenderedView> {
        let coarse = CoarseSolution::new(self.scene, self.mesh, self.field, self.texel_errors)?;
        let (mesh, field, off) = match &coarse {
            Some(shown) => (&shown.mesh, &shown.field, shown.texel_errors.as_deref()),
            None => (self.mesh, self.field, self.texel_errors),
        };
        let preview = Preview::new(self.scene, mesh, field, self.camera);
        let viewer = SceneViewer {
            scene: self.scene,
            layers: vec![ViewerLayer {
                name: self.solver,
                mesh,
                field,
            }],
            difference: [0, 0],
            irradiance: true,
            reflected: false,
            texel_errors: off,
            camera: preview.camera,
            exposure: preview.exposure,
        };
        let page = viewer.render_page(&self.describe_solution(coarse.as_ref().map_or(1, |shown| shown.merged_side)));
        Ok(RenderedView {
            element: viewer.render_element(),
            page,
            preview,
        })
    }

    /// Describes size, solver and error of the solution; `over` is the number of texels per side averaged into one.
    fn describe_solution(&self, over: u32) -> String {
        let off = self.error.map_or(String::new(), |error| {
            format!(", estimated error {:.1} %", 100.0 * error)
        });
        let means = match over {
            1 => String::new(),
            _ => format!("; texels averaged in groups of {over}×{over}"),
        };
        format!(
            "{} faces, {} texels, solved on {}{off}{means}",
            self.mesh.faces.len(),
            self.mesh.texels.len(),
            self.adapter.unwrap_or("the CPU"),
        )
    }
}
