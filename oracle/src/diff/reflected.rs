//! Extracts the reflected radiosity B − E of a result for a comparison. Diffs, charts, the failure atlas and the truth
//! of a comparison begin with it.

use common::mesh::Mesh;
use common::resample::{area_average, shared_pieces};
use common::scene::Scene;
use common::shooting::RadiosityField;
use common::solution::StoredSolution;
use common::texel::first_texels;
use glam::DVec3;

/// Reflected radiosity B − E per texel, W/m², face after face, row-major within a face.
#[derive(Clone, Debug)]
pub struct ReflectedField<'a> {
    /// Scene with the faces.
    pub scene: &'a Scene,
    /// Texels W×H of each face.
    pub resolutions: Vec<[u32; 2]>,
    /// B − E of each texel.
    pub values: Vec<DVec3>,
}

impl<'a> From<&'a StoredSolution> for ReflectedField<'a> {
    fn from(stored: &'a StoredSolution) -> Self {
        Self {
            scene: &stored.scene,
            resolutions: stored.resolutions.clone(),
            values: stored.reflected_radiosity(),
        }
    }
}

impl<'a> ReflectedField<'a> {
    /// Extracts B − E of a solve in memory; a texel that the field lacks is NaN.
    pub fn from_field(scene: &'a Scene, mesh: &Mesh, field: &RadiosityField) -> Self {
        let resolutions: Vec<[u32; 2]> = mesh.faces.iter().map(|f| f.resolution).collect();
        let first = first_texels(&resolutions);
        let mut values = vec![DVec3::NAN; first[resolutions.len()]];
        for (texel, radiosity) in mesh.texels.iter().zip(&field.radiosity) {
            values[first[texel.face as usize] + texel.index as usize] =
                radiosity.truncate().as_dvec3() - texel.emission.as_dvec3();
        }
        Self {
            scene,
            resolutions,
            values,
        }
    }

    /// Averages the values by area over other texels; a value is constant over its texel.
    pub fn average_onto(&self, resolutions: Vec<[u32; 2]>) -> Self {
        let first = first_texels(&self.resolutions);
        let faces = self.scene.faces.iter().enumerate();
        let values = faces.flat_map(|(k, face)| {
            let (own, from, to) = (
                &self.values[first[k]..first[k + 1]],
                self.resolutions[k],
                resolutions[k],
            );
            match from == to {
                true => own.to_vec(),
                false => area_average(own, &shared_pieces(face, from, to), to),
            }
        });
        Self {
            values: values.collect(),
            scene: self.scene,
            resolutions,
        }
    }
}
