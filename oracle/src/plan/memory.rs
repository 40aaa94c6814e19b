//! Memory from the sizes of the records.

use super::Counts;
use common::mesh::{Cell, MeshFace, Point, Texel};
use common::settings::Settings;
use cpu::memory;
use gpu::Gpu;

/// Bytes of one solve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Memory {
    /// Faces, cells, texels and points, on the host for both solvers.
    pub mesh: u64,
    /// The texels' state and what else the engine keeps, the links apart.
    pub state: u64,
    /// Links, and what cells exchange.
    pub links: u64,
}

impl Memory {
    /// On the CPU.
    pub fn cpu(counts: &Counts, settings: &Settings) -> Self {
        Self {
            mesh: mesh(counts),
            state: memory::state(counts.texels),
            links: memory::links(counts.cells, counts.texels, settings),
        }
    }

    /// On a GPU; the mesh stays on the host.
    pub fn gpu(gpu: &Gpu, counts: &Counts, settings: &Settings) -> Self {
        Self {
            mesh: mesh(counts),
            state: gpu.state_bytes(counts.faces, counts.cells, counts.texels, settings),
            links: gpu.link_bytes(counts.cells, counts.texels),
        }
    }

    /// All of it.
    pub fn bytes(&self) -> u64 {
        self.mesh
            .saturating_add(self.state)
            .saturating_add(self.links)
    }
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
