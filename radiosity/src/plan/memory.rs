//! Memory of a solve by shooting, from the sizes of its records.

use super::SceneCounts;
use crate::report::preview::PREVIEW_BYTES;
use common::mesh::{MeshFace, Patch, PatchPoint, Texel};
use common::settings::Settings;
use cpu::memory;
use gpu::Gpu;

/// Bytes of a face beside its record: name, text of the file, four trees, and its possible occluders.
/// Measured: 4.3 kB with 20 000 and with 100 000 triangles.
const BYTES_PER_FACE: u64 = 4400;
/// Bytes of a texel after the links are freed: result, error estimate and output files, each with its own copy.
/// Measured: 302 bytes with 6 million texels.
const ESTIMATE_BYTES_PER_TEXEL: u64 = 302;
/// Bytes of the program itself.
const PROGRAM_BYTES: u64 = 12 << 20;

/// Bytes of one solve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SolveMemory {
    /// Faces, patches, texels and points, on the host for both solvers.
    pub mesh: u64,
    /// State of the texels and of the engine, without its links.
    pub state: u64,
    /// Links, and the power exchanged between patches.
    pub links: u64,
    /// The program and the scene.
    pub scene: u64,
    /// Error estimate and output after shooting, when mesh, state and links are freed.
    pub estimate: u64,
}

impl SolveMemory {
    /// Returns the memory of a solve on the CPU.
    pub fn on_cpu(counts: &SceneCounts, settings: &Settings) -> Self {
        Self {
            mesh: mesh_bytes(counts),
            state: memory::state_bytes(counts.texels),
            links: memory::link_bytes(counts.patches, counts.texels, settings.schedule.iteration),
            scene: scene_bytes(counts),
            estimate: estimate_bytes(counts),
        }
    }

    /// Returns the memory of a solve on a GPU; the mesh stays on the host.
    pub fn on_gpu(gpu: &Gpu, counts: &SceneCounts, settings: &Settings) -> Self {
        Self {
            mesh: mesh_bytes(counts),
            state: gpu.state_bytes(
                [counts.faces, counts.patches, counts.texels],
                counts.samples,
                &settings.transport,
            ),
            links: gpu.link_bytes(counts.patches, counts.texels),
            scene: scene_bytes(counts),
            estimate: estimate_bytes(counts),
        }
    }

    /// Returns the largest number of bytes in use at one time.
    pub fn peak_bytes(&self) -> u64 {
        let shooting = (self.mesh).saturating_add(self.state).saturating_add(self.links);
        self.scene.saturating_add(shooting.max(self.estimate))
    }
}

fn scene_bytes(counts: &SceneCounts) -> u64 {
    counts
        .faces
        .saturating_mul(BYTES_PER_FACE)
        .saturating_add(PROGRAM_BYTES)
}

/// Bytes of the error estimate, which makes three more meshes, and of the preview.
fn estimate_bytes(counts: &SceneCounts) -> u64 {
    let texels = counts.texels.saturating_mul(ESTIMATE_BYTES_PER_TEXEL);
    let patches = 3 * (size_of::<Patch>() + size_of::<PatchPoint>() * counts.samples as usize) as u64;
    texels
        .saturating_add(counts.patches.saturating_mul(patches))
        .saturating_add(PREVIEW_BYTES)
}

fn mesh_bytes(counts: &SceneCounts) -> u64 {
    let of = |count: u64, bytes: usize| count.saturating_mul(bytes as u64);
    [
        of(counts.faces, size_of::<MeshFace>()),
        of(counts.patches, size_of::<Patch>()),
        of(counts.texels, size_of::<Texel>()),
        of(counts.patches * counts.samples, size_of::<PatchPoint>()),
    ]
    .into_iter()
    .fold(0, u64::saturating_add)
}
