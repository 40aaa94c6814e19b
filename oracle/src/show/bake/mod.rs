//! A solved scene as glTF: its faces with their light on them, and that light as numbers.

pub mod charts;
mod glb;
mod image;
mod kept;
mod lattice;
mod nodes;
mod packed;

use super::picture::{Exposure, Picture, encode};
use super::view::surface::Surface;
use charts::Charts;
use common::mesh::Mesh;
use common::scene::Scene;
use common::shooting::Field;
use common::{Error, Result};

/// Both files, not written yet.
pub struct Baked {
    /// The scene with its light as a texture: what is white stands in the material's `extras`.
    pub glb: Vec<u8>,
    /// The same charts as OpenEXR: R, G, B are radiosity, and `irradiance.*`; W/m².
    pub exr: Vec<u8>,
    /// What is to be said of the charts.
    pub note: Option<String>,
}

/// Bakes `scene` as `field` has solved it on the texels of `mesh`, onto the file's own `charts` if there are any.
///
/// Errors: charts that are too many for one picture; [`Error::Fault`] of an encoder.
pub fn bake(
    scene: &Scene,
    charts: Option<&Charts>,
    (mesh, field): (&Mesh, &Field),
    exposure: Exposure,
) -> Result<Baked> {
    let surface = Surface::new(scene, mesh);
    let light = surface.interpolate(&field.irradiance);
    let (image, parts, note) = match charts {
        Some(charts) => kept::lay(scene, charts, &light),
        None => {
            let (image, parts) = packed::lay(scene, &light)?;
            (image, parts, None)
        }
    };
    let white = Exposure::linear(exposure.white);
    let picture = Picture::from_pixels(image.size[0], image.size[1], |x, y| {
        let radiosity = image.radiosity[(y * image.size[0] + x) as usize];
        Some(encode(white.display(radiosity)))
    });
    let glb = glb::glb(scene, &parts, &picture.png(), white.white);
    Ok(Baked {
        glb: glb.map_err(|error| Error::Fault(error.to_string()))?,
        exr: image.exr()?,
        note,
    })
}
