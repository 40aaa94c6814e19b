//! Views of one solution: `preview.png` and the interactive page `view.html`.

use super::coarse_solution::{CoarseSolution, drawn_sizes};
use super::preview::Preview;
use super::view::camera::Camera;
use super::viewer::{SceneViewer, ViewerLayer};
use common::Result;
use common::mesh::Mesh;
use common::solution::Solution;
use maud::Markup;

/// Rendered views, ready to be written.
pub struct RenderedView {
    /// Picture with camera and exposure.
    pub preview: Preview,
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
        let own: (&Mesh, _, _) = (solution.mesh, &solution.run.field, errors);
        let sizes: Vec<[u32; 2]> = solution.mesh.faces.iter().map(|face| face.resolution).collect();
        let (sizes, merged) = drawn_sizes(&sizes);
        let coarse = (merged > 1)
            .then(|| CoarseSolution::new(scene, own, &sizes))
            .transpose()?;
        let (mesh, field, texel_errors) = match &coarse {
            Some(shown) => (&shown.mesh, &shown.field, shown.texel_errors.as_deref()),
            None => own,
        };
        let preview = Preview::new(scene, mesh, field, camera);
        let name = solution.solver;
        let viewer = SceneViewer {
            scene,
            layers: vec![ViewerLayer { name, mesh, field }],
            irradiance: true,
            reflected: false,
            texel_errors,
            camera: preview.camera,
            exposure: preview.exposure,
        };
        Ok(Self {
            element: viewer.render_element(),
            page: viewer.render_page(&describe_solution(solution, merged)),
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
