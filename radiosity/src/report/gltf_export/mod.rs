//! Exports a solved scene as binary glTF: the scene file as it is, with a lightmap, which is also written as OpenEXR.

mod chart_packing;
pub mod face_document;
mod lightmap_image;
mod lit_document;
mod plane_charts;
pub mod uv_charts;

use super::picture::{Exposure, RgbaPicture, encode_srgb, weighted_percentile};
use super::view::interpolation::InterpolationSurface;
use chart_packing::{PackedCharts, pack_scene};
use common::Result;
use common::import::SceneFile;
use common::mesh::Mesh;
use common::scene::Scene;
use common::shooting::RadiosityField;
use common::solution::write::encode_exr;
use glam::Vec3;
use lightmap_image::{LightmapImage, render_charts, render_own_charts, texel_density};
use lit_document::{LightmapTexture, attach_lightmap};
use uv_charts::UvCharts;

/// Share of the lightmap that its 8-bit picture shows unclipped.
const UNCLIPPED_SHARE: f64 = 0.999;

/// Radiosity that the picture shows unclipped, relative to that which a display shows as white.
const UNCLIPPED_WHITES: f32 = 2.0;

/// Encoded export files.
pub struct GltfExport {
    /// Binary glTF.
    pub glb: Vec<u8>,
    /// OpenEXR of the same charts: radiosity R, G, B and `irradiance.*`, W/m².
    pub exr: Vec<u8>,
    /// Notes on charts that are too close, on fewer pixels than were asked for, and on images that could not be read.
    pub notes: Vec<String>,
}

/// Charts of an export.
pub enum ExportCharts<'a> {
    /// The scene file's own.
    Own(&'a UvCharts),
    /// Packed newly, with this number of pixels per unit of length; none: finer than the texels.
    Packed(Option<f64>),
}

/// Renders the solution `field` on `mesh` to a lightmap and attaches it to the scene's `file`.
///
/// Errors: packed charts do not fit in one lightmap; the file is damaged, or too large.
pub fn export_lightmap(
    (scene, file): (&Scene, SceneFile),
    charts: ExportCharts,
    (mesh, field): (&Mesh, &RadiosityField),
    exposure: Exposure,
) -> Result<GltfExport> {
    let surface = InterpolationSurface::new(scene, mesh);
    let light = surface.interpolate_irradiance(&field.irradiance);
    let mut notes = Vec::new();
    let packed;
    let (charts, image, keeps_coordinates) = match charts {
        ExportCharts::Own(charts) => {
            let (image, note) = render_own_charts(charts, &light);
            notes.extend(note);
            (charts, image, true)
        }
        ExportCharts::Packed(asked) => {
            packed = pack_scene(scene, asked, texel_density(scene, &light))?;
            notes.extend(asked.and_then(|asked| coarser_note(&packed, asked)));
            (
                &packed.charts,
                render_charts(&packed.charts, packed.side, &light),
                false,
            )
        }
    };
    let white = brightest_irradiance(&image, exposure.white);
    let scale = Exposure::with_white(white);
    let picture = RgbaPicture::from_pixels(image.side, image.side, |x, y| {
        let [_, irradiance] = image.light[(y * image.side + x) as usize];
        Some(encode_srgb(scale.display_light(irradiance)))
    });
    let texture = LightmapTexture {
        png: picture.encode_png(),
        intensity: white,
        display_white: exposure.white,
        keeps_coordinates,
    };
    let glb = attach_lightmap(file, (scene, charts), &texture, &mut notes)?;
    let planes = [("", 0), ("irradiance.", 1)].into_iter().flat_map(|(prefix, which)| {
        let plane = |c: usize| image.light.iter().map(|light| light[which][c]).collect();
        [0, 1, 2].map(|c| (format!("{prefix}{}", ["R", "G", "B"][c]), plane(c)))
    });
    Ok(GltfExport {
        glb,
        exr: encode_exr([image.side; 2], planes.collect())?,
        notes,
    })
}

fn coarser_note(packed: &PackedCharts, asked: f64) -> Option<String> {
    let (side, density) = (packed.side, packed.density);
    (density < asked * 0.999).then(|| {
        format!("the lightmap has {density:.3} pixels per unit of length and not {asked}: it would be larger than {side}×{side}")
    })
}

/// Returns the irradiance that white stands for in the picture: the largest, but for surfaces that are brighter than
/// [`UNCLIPPED_WHITES`] times the `white` of a display.
fn brightest_irradiance(image: &LightmapImage, white: f32) -> f32 {
    let covered = image.light.iter().zip(&image.covered).filter(|(_, covered)| **covered);
    let shown = |radiosity: Vec3| (UNCLIPPED_WHITES * white / radiosity.max_element()).min(1.0);
    let values = covered.map(|([radiosity, irradiance], _)| irradiance.max_element() * shown(*radiosity));
    let values = values.map(|value| (f64::from(value), 1.0));
    let mut values: Vec<(f64, f64)> = values.filter(|(value, _)| *value > 0.0).collect();
    let brightest = weighted_percentile(&mut values, UNCLIPPED_SHARE).unwrap_or(1.0);
    brightest.clamp(f64::from(f32::MIN_POSITIVE), f64::from(f32::MAX)) as f32
}
