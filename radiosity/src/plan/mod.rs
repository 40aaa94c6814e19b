//! The cost of a solve before it starts: counts of texels, patches and links, [`coarser_defaults`] for scenes of many
//! faces, the [`memory`] it needs, and a [`forecast`] of its time.

pub mod coarser_defaults;
pub mod forecast;
#[allow(clippy::disallowed_methods, reason = "reads the system's own /proc/meminfo")]
pub mod memory;

use common::scene::Scene;
use common::settings::Meshing;
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
}
