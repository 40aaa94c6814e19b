//! The reflected part of a result, ready to be compared: faces, resolutions, B − E of all texels.

use common::mesh::Mesh;
use common::scene::Scene;
use common::shooting::Field;
use common::solution::Stored;
use common::texel::count;
use glam::DVec3;

/// B − E per texel, W/m²; texels count face after face, within a face row-major.
#[derive(Clone, Debug)]
pub struct Reflected<'a> {
    /// The faces.
    pub scene: &'a Scene,
    /// Texels W×H of each face.
    pub resolutions: Vec<[u32; 2]>,
    /// B − E.
    pub values: Vec<DVec3>,
}

impl<'a> From<&'a Stored> for Reflected<'a> {
    fn from(stored: &'a Stored) -> Self {
        Self {
            scene: &stored.scene,
            resolutions: stored.resolutions.clone(),
            values: stored.reflected(),
        }
    }
}

impl<'a> Reflected<'a> {
    /// Of a solve in memory; a texel that the field lacks is NaN.
    pub fn of(scene: &'a Scene, mesh: &Mesh, field: &Field) -> Self {
        let resolutions: Vec<[u32; 2]> = mesh.faces.iter().map(|f| f.resolution).collect();
        let first = offsets(&resolutions);
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
}

/// The first texel of each face, and the number of all.
pub fn offsets(resolutions: &[[u32; 2]]) -> Vec<usize> {
    let mut first = vec![0];
    for (k, resolution) in resolutions.iter().enumerate() {
        first.push(first[k] + count(*resolution) as usize);
    }
    first
}
