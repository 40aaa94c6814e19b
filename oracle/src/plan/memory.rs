//! Memory from the sizes of the records.

use super::Counts;
use crate::show::preview::BYTES;
use common::mesh::{Cell, MeshFace, Point, Texel};
use common::settings::Settings;
use cpu::memory;
use gpu::Gpu;

/// What a face takes beside its record: its name, the file's text, four trees, and what may come
/// between it and others. Measured: 4.3 kB of 20 000 and of 100 000 triangles.
const FACE: u64 = 4400;
/// What a texel takes once the links are gone: the answer, the looks at its error and the files made of
/// it, each with its own copy. Measured: 302 bytes of 6 million texels.
const LOOK: u64 = 302;
/// The program itself.
const PROGRAM: u64 = 12 << 20;

/// Bytes of one solve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Memory {
    /// Faces, cells, texels and points, on the host for both solvers.
    pub mesh: u64,
    /// The texels' state and what else the engine keeps, the links apart.
    pub state: u64,
    /// Links, and what cells exchange.
    pub links: u64,
    /// The program and the scene.
    pub scene: u64,
    /// What it takes after shooting, instead of mesh, state and links.
    pub look: u64,
}

impl Memory {
    /// On the CPU.
    pub fn cpu(counts: &Counts, settings: &Settings) -> Self {
        Self {
            mesh: mesh(counts),
            state: memory::state(counts.texels),
            links: memory::links(counts.cells, counts.texels, settings.schedule.iteration),
            scene: scene(counts),
            look: look(counts),
        }
    }

    /// On a GPU; the mesh stays on the host.
    pub fn gpu(gpu: &Gpu, counts: &Counts, settings: &Settings) -> Self {
        Self {
            mesh: mesh(counts),
            state: gpu.state_bytes(
                [counts.faces, counts.cells, counts.texels],
                counts.samples,
                &settings.transport,
            ),
            links: gpu.link_bytes(counts.cells, counts.texels),
            scene: scene(counts),
            look: look(counts),
        }
    }

    /// All that there is at one time, at most.
    pub fn bytes(&self) -> u64 {
        let shooting = (self.mesh)
            .saturating_add(self.state)
            .saturating_add(self.links);
        self.scene.saturating_add(shooting.max(self.look))
    }
}

fn scene(counts: &Counts) -> u64 {
    counts.faces.saturating_mul(FACE).saturating_add(PROGRAM)
}

/// Three meshes are looked at, with cells of their own; and there is the preview.
fn look(counts: &Counts) -> u64 {
    let texels = counts.texels.saturating_mul(LOOK);
    let cells = 3 * (size_of::<Cell>() + size_of::<Point>() * counts.samples as usize) as u64;
    texels
        .saturating_add(counts.cells.saturating_mul(cells))
        .saturating_add(BYTES)
}

fn mesh(counts: &Counts) -> u64 {
    let of = |count: u64, bytes: usize| count.saturating_mul(bytes as u64);
    [
        of(counts.faces, size_of::<MeshFace>()),
        of(counts.cells, size_of::<Cell>()),
        of(counts.texels, size_of::<Texel>()),
        of(counts.cells * counts.samples, size_of::<Point>()),
    ]
    .into_iter()
    .fold(0, u64::saturating_add)
}
