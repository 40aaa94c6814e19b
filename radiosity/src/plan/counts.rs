//! Counts of faces, texels, patches and links, from scene and settings alone.

use common::scene::Scene;
use common::settings::{Meshing, Visibility};
use common::texel::PatchGrid;

/// Counts of one solve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SceneCounts {
    /// Faces.
    pub faces: u64,
    /// Texels.
    pub texels: u64,
    /// Patches.
    pub patches: u64,
    /// Sample points per patch.
    pub samples: u64,
}

impl SceneCounts {
    /// Counts `scene` under `meshing`.
    pub fn new(scene: &Scene, meshing: &Meshing) -> Self {
        let resolution = [meshing.texels; 2];
        let patches = |shape| u64::from(PatchGrid::new(shape, resolution, meshing.patches).patch_count());
        let faces = scene.faces.len() as u64;
        Self {
            faces,
            texels: faces * u64::from(meshing.texels).pow(2),
            patches: scene.faces.iter().map(|face| patches(face.shape)).sum(),
            samples: u64::from(meshing.samples),
        }
    }

    /// Returns the number of links: pairs of a patch and a texel.
    pub fn link_count(&self) -> u64 {
        self.patches.saturating_mul(self.texels)
    }

    /// Returns an upper bound of the rays of `patches` patches: one per sample of a link, fewer where texels face away.
    /// 0 by item buffer.
    pub fn max_rays(&self, patches: u64, visibility: Visibility) -> u64 {
        match visibility {
            Visibility::Rays => patches.saturating_mul(self.texels).saturating_mul(self.samples),
            _ => 0,
        }
    }

    /// Returns the pixels of the item buffers of `patches` patches, one buffer per sample; 0 by rays.
    pub fn item_buffer_pixels(&self, patches: u64, visibility: Visibility) -> u64 {
        match visibility {
            Visibility::Rays => 0,
            Visibility::ItemBuffer(drawing) => patches * self.samples * drawing.pixel_count(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use common::mesh::Mesh;
    use common::scene::Face;
    use glam::{DVec3, Vec3};

    /// A quad and a triangle.
    fn scene() -> Scene {
        let c = [DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y];
        let [e, r] = [Vec3::ONE, Vec3::splat(0.5)];
        let triangle = [c[0], c[1], c[2]].map(|p| p + DVec3::Z);
        Scene {
            faces: vec![Face::quad("quad", c, e, r), Face::triangle("triangle", triangle, e, r)],
            ..Scene::default()
        }
    }

    #[test]
    fn the_counts_are_those_of_the_mesh() {
        for (texels, patches) in [(1, 1), (8, 4), (6, 4), (7, 3), (2, 8)] {
            let meshing = Meshing {
                texels,
                patches,
                ..Meshing::default()
            };
            let counts = SceneCounts::new(&scene(), &meshing);
            let mesh = Mesh::uniform(&scene(), texels, patches).unwrap();
            assert_eq!(counts.texels, mesh.texels.len() as u64);
            assert_eq!(counts.patches, mesh.patches.len() as u64, "{texels} {patches}");
        }
    }
}
