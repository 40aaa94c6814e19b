//! Two results in one viewer: A, B and their difference on common texels.

use super::Diff;
use super::reflected::offsets;
use crate::judge::resample::{average, pieces};
use crate::show::picture::Exposure;
use crate::show::shown::Shown;
use crate::show::view::camera::Camera;
use crate::show::viewer::{Layer, Viewer};
use common::Result;
use common::mesh::Mesh;
use common::shooting::{Field, initial};
use common::solution::Stored;
use glam::{DVec3, Vec3};
use maud::Markup;

/// One of them on the common texels, with its own ρ and E.
struct Side {
    mesh: Mesh,
    field: Field,
}

/// The element; `names` are those of A and of B, which is taken as the truth.
///
/// Errors: the faces have no extent.
pub fn around(
    [a, b]: [&Stored; 2],
    diff: &Diff,
    names: [&str; 2],
    (camera, exposure): (Camera, Exposure),
) -> Result<Markup> {
    let sides = [Side::new(a, b, diff)?, Side::new(b, b, diff)?];
    let mut fewer = Vec::new();
    for side in &sides {
        fewer.extend(Shown::new(&b.scene, &side.mesh, &side.field, None)?);
    }
    let shown: Vec<(&Mesh, &Field)> = match fewer.is_empty() {
        true => sides.iter().map(|s| (&s.mesh, &s.field)).collect(),
        false => fewer.iter().map(|s| (&s.mesh, &s.field)).collect(),
    };
    let layers = names.into_iter().zip(shown);
    let viewer = Viewer {
        scene: &b.scene,
        layers: layers
            .map(|(name, (mesh, field))| Layer { name, mesh, field })
            .collect(),
        difference: [0, 1],
        irradiance: [a, b].iter().all(|s| s.others.contains_key("irradiance")),
        reflected: true,
        off: None,
        camera,
        exposure,
    };
    Ok(viewer.element())
}

impl Side {
    /// The geometry is `b`'s.
    fn new(stored: &Stored, b: &Stored, diff: &Diff) -> Result<Self> {
        let sizes = &diff.pair.resolutions;
        let mut mesh = Mesh::new(&b.scene, sizes, 1)?;
        let mut field = initial(&mesh, "");
        let on_common = |values: &[Vec3]| averages(stored, sizes, values);
        let radiosity = on_common(&stored.radiosity);
        let emission = on_common(&stored.emission);
        let irradiance = stored.others.get("irradiance").map(|h| on_common(h));
        let reflectance = stored.others.get("reflectance").map(|r| on_common(r));
        let order = mesh.in_face_order();
        for (k, texel) in order.into_iter().enumerate() {
            field.radiosity[texel] = radiosity[k].extend(0.0);
            let h = irradiance.as_ref().map_or(Vec3::ZERO, |h| h[k]);
            field.irradiance[texel] = h.extend(0.0);
            let own = &mut mesh.texels[texel];
            own.emission = emission[k];
            let of_face = stored.scene.faces[own.face as usize].reflectance;
            own.reflectance = reflectance.as_ref().map_or(of_face, |r| r[k]);
        }
        Ok(Self { mesh, field })
    }
}

/// Means of `values` over the common texels, face after face.
fn averages(stored: &Stored, sizes: &[[u32; 2]], values: &[Vec3]) -> Vec<Vec3> {
    let first = offsets(&stored.resolutions);
    let mut all = Vec::new();
    for (k, face) in stored.scene.faces.iter().enumerate() {
        let own: Vec<DVec3> = values[first[k]..first[k + 1]]
            .iter()
            .map(|v| v.as_dvec3())
            .collect();
        let pieces = pieces(face, stored.resolutions[k], sizes[k]);
        let means = average(&own, &pieces, sizes[k]);
        all.extend(means.into_iter().map(|mean| mean.as_vec3()));
    }
    all
}
