//! What one sees of a result before any number: `preview.png`, and `view.html` to look around in.

use super::preview::Preview;
use super::shown::Shown;
use super::view::camera::Camera;
use super::viewer::{Layer, Viewer};
use common::Result;
use common::mesh::Mesh;
use common::scene::Scene;
use common::shooting::Field;
use maud::Markup;

/// A result.
pub struct Around<'a> {
    /// Its faces.
    pub scene: &'a Scene,
    /// Its texels, each with its own ρ and E.
    pub mesh: &'a Mesh,
    /// Its light.
    pub field: &'a Field,
    /// How far each texel may be off, W/m².
    pub off: Option<&'a [f32]>,
    /// Who solved it.
    pub solver: &'a str,
    /// On what; none: on the CPU.
    pub adapter: Option<&'a str>,
    /// How far it is off as a whole.
    pub error: Option<f64>,
    /// Where one stands; none: from where most is seen.
    pub camera: Option<Camera>,
}

/// What is to be written.
pub struct Seen {
    /// The picture, and how it was taken.
    pub preview: Preview,
    /// The scene to look around in, an element.
    pub element: Markup,
    /// The same as a file.
    pub page: String,
}

impl Around<'_> {
    /// Draws it; of more texels than one can see, means.
    ///
    /// Errors: those of a mesh.
    pub fn seen(&self) -> Result<Seen> {
        let fewer = Shown::new(self.scene, self.mesh, self.field, self.off)?;
        let (mesh, field, off) = match &fewer {
            Some(shown) => (&shown.mesh, &shown.field, shown.off.as_deref()),
            None => (self.mesh, self.field, self.off),
        };
        let preview = Preview::new(self.scene, mesh, field, self.camera);
        let viewer = Viewer {
            scene: self.scene,
            layers: vec![Layer {
                name: self.solver,
                mesh,
                field,
            }],
            difference: [0, 0],
            irradiance: true,
            reflected: false,
            off,
            camera: preview.camera,
            exposure: preview.exposure,
        };
        let page = viewer.page(&self.told(fewer.as_ref().map_or(1, |shown| shown.over)));
        Ok(Seen {
            element: viewer.element(),
            page,
            preview,
        })
    }

    /// What was solved, by whom, and how well; `over` so many texels a side what is shown is a mean.
    fn told(&self, over: u32) -> String {
        let off = self.error.map_or(String::new(), |error| {
            format!(", about {:.1} % off", 100.0 * error)
        });
        let means = match over {
            1 => String::new(),
            _ => format!("; shown are means over {over}×{over} texels"),
        };
        format!(
            "{} faces, {} texels, solved on {}{off}{means}",
            self.mesh.faces.len(),
            self.mesh.texels.len(),
            self.adapter.unwrap_or("the CPU"),
        )
    }
}
