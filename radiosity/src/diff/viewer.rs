//! Renders the interactive viewer of two results, A, B and their difference on common texels.

use crate::report::coarse_solution::CoarseSolution;
use crate::report::picture::Exposure;
use crate::report::view::camera::Camera;
use crate::report::viewer::{SceneViewer, ViewerLayer};
use common::Result;
use common::mesh::Mesh;
use common::resample::{area_average, shared_pieces};
use common::shooting::{RadiosityField, initial_field};
use common::solution::StoredSolution;
use common::texel::first_texels;
use glam::{DVec3, Vec3};
use maud::Markup;
use oracle::diff::Diff;

/// A solution averaged to the grid of texels common to both, with its own reflectance and emission.
struct CommonGridResult {
    mesh: Mesh,
    field: RadiosityField,
}

/// Renders the viewer element; `names` are those of A and of the reference B.
///
/// Errors: the scene has no extent.
pub fn render_diff_viewer(
    [a, b]: [&StoredSolution; 2],
    diff: &Diff,
    names: [&str; 2],
    (camera, exposure): (Camera, Exposure),
) -> Result<Markup> {
    let sides = [CommonGridResult::new(a, b, diff)?, CommonGridResult::new(b, b, diff)?];
    // A scene too large for a page is shown on fewer texels: both sides, since they have the same ones.
    let mut coarse = Vec::new();
    for side in &sides {
        coarse.extend(CoarseSolution::new(&b.scene, &side.mesh, &side.field, None)?);
    }
    let shown: Vec<(&Mesh, &RadiosityField)> = match coarse.is_empty() {
        true => sides.iter().map(|s| (&s.mesh, &s.field)).collect(),
        false => coarse.iter().map(|s| (&s.mesh, &s.field)).collect(),
    };
    let layers = names.into_iter().zip(shown);
    let viewer = SceneViewer {
        scene: &b.scene,
        layers: layers
            .map(|(name, (mesh, field))| ViewerLayer { name, mesh, field })
            .collect(),
        difference: [0, 1],
        irradiance: [a, b].iter().all(|s| s.others.contains_key("irradiance")),
        reflected: true,
        texel_errors: None,
        camera,
        exposure,
    };
    Ok(viewer.render_element())
}

impl CommonGridResult {
    /// Averages `stored` to the common texels; the geometry is `b`'s.
    fn new(stored: &StoredSolution, b: &StoredSolution, diff: &Diff) -> Result<Self> {
        let sizes = &diff.pair.resolutions;
        let mut mesh = Mesh::new(&b.scene, sizes, 1)?;
        let mut field = initial_field(&mesh, "");
        let average = |values: &Vec<Vec3>| average_onto(stored, sizes, values);
        let [radiosity, emission] = [&stored.radiosity, &stored.emission].map(average);
        let [irradiance, reflectance] = ["irradiance", "reflectance"].map(|name| stored.others.get(name).map(average));
        for (k, texel) in mesh.texels_in_face_order().into_iter().enumerate() {
            field.radiosity[texel] = radiosity[k].extend(0.0);
            field.irradiance[texel] = irradiance.as_ref().map_or(Vec3::ZERO, |h| h[k]).extend(0.0);
            let own = &mut mesh.texels[texel];
            own.emission = emission[k];
            let of_face = stored.scene.faces[own.face as usize].reflectance;
            own.reflectance = reflectance.as_ref().map_or(of_face, |r| r[k]);
        }
        Ok(Self { mesh, field })
    }
}

/// Averages `values` over the common texels, in face order.
fn average_onto(stored: &StoredSolution, sizes: &[[u32; 2]], values: &[Vec3]) -> Vec<Vec3> {
    let first = first_texels(&stored.resolutions);
    let faces = stored.scene.faces.iter().enumerate();
    let means = faces.flat_map(|(k, face)| {
        let own: Vec<DVec3> = values[first[k]..first[k + 1]].iter().map(|v| v.as_dvec3()).collect();
        area_average(&own, &shared_pieces(face, stored.resolutions[k], sizes[k]), sizes[k])
    });
    means.map(|mean| mean.as_vec3()).collect()
}
