//! Exports a solved scene as binary glTF with a lightmap texture, and the lightmap as OpenEXR.

mod file_charts;
mod glb;
mod packed_charts;
pub mod uv_charts;

use super::picture::{Exposure, RgbaPicture, encode_srgb};
use super::view::interpolation::InterpolationSurface;
use common::mesh::Mesh;
use common::scene::Scene;
use common::shooting::RadiosityField;
use common::solution::write::encode_exr;
use common::{Error, Result};
use glam::Vec3;
use uv_charts::UvCharts;

/// Lightmap picture.
struct LightmapImage {
    /// Width and height in pixels.
    size: [u32; 2],
    /// Radiosity B and irradiance H per pixel, row-major from the upper left, W/m².
    light: Vec<[Vec3; 2]>,
}

/// Encoded export files.
pub struct GltfExport {
    /// Binary glTF; the material's `extras` hold the radiosity of white.
    pub glb: Vec<u8>,
    /// OpenEXR of the same charts: radiosity R, G, B and `irradiance.*`, W/m².
    pub exr: Vec<u8>,
    /// Note on charts that are too close.
    pub note: Option<String>,
}

/// Renders the solution `field` on `mesh` to a lightmap, on the file's own `charts` if given.
///
/// Errors: packed charts do not fit in one picture; [`Error::Fault`] of an encoder.
pub fn export_lightmap(
    scene: &Scene,
    charts: Option<&UvCharts>,
    (mesh, field): (&Mesh, &RadiosityField),
    exposure: Exposure,
) -> Result<GltfExport> {
    let surface = InterpolationSurface::new(scene, mesh);
    let light = surface.interpolate(&field.irradiance);
    let (image, parts, note) = match charts {
        Some(charts) => file_charts::render_on_file_charts(scene, charts, &light),
        None => {
            let (image, parts) = packed_charts::render_packed_charts(scene, &light)?;
            (image, parts, None)
        }
    };
    let white = Exposure::with_white(exposure.white);
    let picture = RgbaPicture::from_pixels(image.size[0], image.size[1], |x, y| {
        let [radiosity, _] = image.light[(y * image.size[0] + x) as usize];
        Some(encode_srgb(white.display_light(radiosity)))
    });
    let glb = glb::encode_glb(scene, &parts, &picture.encode_png(), white.white);
    let planes = [("", 0), ("irradiance.", 1)].into_iter().flat_map(|(prefix, which)| {
        let plane = |c: usize| image.light.iter().map(|light| light[which][c]).collect();
        [0, 1, 2].map(|c| (format!("{prefix}{}", ["R", "G", "B"][c]), plane(c)))
    });
    Ok(GltfExport {
        glb: glb.map_err(|error| Error::Fault(error.to_string()))?,
        exr: encode_exr(image.size, planes.collect())?,
        note,
    })
}
