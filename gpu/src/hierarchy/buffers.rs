//! What lies on the device while links are found.

use crate::adapter::Gpu;
use crate::buffers::{empty, filled, most_bytes, tree};
use crate::linked::{
    AskedRecord, BlockRecord, GlowRecord, LaneRecord, Node, PairRecord, SPOTS, SpotRecord,
};
use crate::records::{FaceRecord, Params, SHOT_BYTES, ShotRecord};
use bytemuck::Zeroable;
use common::mesh::Mesh;
use common::{Error, Result};
use wgpu::BufferUsages as Usage;

/// Pairs of a level at most: their lanes take 24 MiB, and with the most rays a dispatch of them takes some
/// hundredths of a second on hardware.
pub const PAIRS: u32 = 1 << 15;
/// Links of a batch at most, where they are kept.
pub const LINKS: u32 = 1 << 15;
/// Blocks of a batch at most.
pub const BLOCKS: u32 = 1 << 11;
/// Bytes of the arguments of a level's two dispatches.
pub const DISPATCH_BYTES: u64 = 32;

pub struct Buffers {
    pub faces: wgpu::Buffer,
    pub nodes: wgpu::Buffer,
    pub primitives: wgpu::Buffer,
    /// The tree's nodes.
    pub shots: wgpu::Buffer,
    pub glows: wgpu::Buffer,
    pub params: wgpu::Buffer,
    pub asked: wgpu::Buffer,
    pub spots: wgpu::Buffer,
    pub blocks: wgpu::Buffer,
    pub lanes: wgpu::Buffer,
    pub offsets: wgpu::Buffer,
    pub totals: wgpu::Buffer,
    pub sums: wgpu::Buffer,
    pub ends: wgpu::Buffer,
    pub links: wgpu::Buffer,
    /// Those of even levels and of odd ones.
    pub pairs: [wgpu::Buffer; 2],
    pub counts: [wgpu::Buffer; 2],
    pub ranges: [wgpu::Buffer; 2],
    pub dispatches: [wgpu::Buffer; 2],
    /// Pairs whose spots are asked after each of the four choices, and workgroups over these.
    pub work: [wgpu::Buffer; 4],
    pub work_dispatches: [wgpu::Buffer; 4],
}

impl Buffers {
    pub fn new(gpu: &Gpu, mesh: &Mesh, tree_nodes: &[Node]) -> Result<Self> {
        let most = most_bytes(gpu);
        let bytes = SHOT_BYTES * tree_nodes.len() as u64;
        if bytes > most {
            return Err(Error::Device(format!(
                "{}: the nodes need {} MiB in one buffer, max_storage_buffer_binding_size is {} MiB: ask for a larger error or fewer texels, or let the CPU solve it",
                gpu.line.name,
                bytes >> 20,
                most >> 20,
            )));
        }
        let device = &gpu.device;
        let storage = Usage::STORAGE | Usage::COPY_SRC | Usage::COPY_DST;
        let uniform = Usage::UNIFORM | Usage::COPY_DST;
        let of =
            |label, count: u64, size: usize| empty(device, label, count * size as u64, storage);
        let both = |label, count: u64, size: usize| [(); 2].map(|()| of(label, count, size));
        let arguments = || {
            empty(
                device,
                "dispatches",
                DISPATCH_BYTES,
                storage | Usage::INDIRECT,
            )
        };
        let [pairs, links, blocks] = [PAIRS, LINKS, BLOCKS].map(u64::from);
        let spots = u64::from(SPOTS);
        let faces: Vec<FaceRecord> = mesh.faces.iter().map(Into::into).collect();
        let shots: Vec<ShotRecord> = tree_nodes.iter().map(|node| node.record(mesh)).collect();
        let (nodes, primitives) = tree(gpu, mesh)?;
        // A room of which nothing is captured.
        let params = Params {
            faces: mesh.faces.len() as u32,
            room: mesh.room,
            ..Params::zeroed()
        };
        Ok(Self {
            faces: filled(device, "faces", &faces, storage),
            nodes: filled(device, "nodes", &nodes, storage),
            primitives: filled(device, "primitives", &primitives, storage),
            shots: filled(device, "tree", &shots, storage),
            glows: of("glows", shots.len() as u64, size_of::<GlowRecord>()),
            params: filled(device, "params", &[params], uniform),
            asked: empty(device, "asked", size_of::<AskedRecord>() as u64, uniform),
            spots: of("spots", blocks * spots, size_of::<SpotRecord>()),
            blocks: of("blocks", blocks, size_of::<BlockRecord>()),
            lanes: of("lanes", pairs * spots, size_of::<LaneRecord>()),
            offsets: of("offsets", pairs + 1, 8),
            totals: of("totals", 4, 4),
            sums: of("sums", blocks * spots, 16),
            ends: of("ends", links, 8),
            links: of("links", links * spots, 16),
            pairs: both("pairs", pairs, size_of::<PairRecord>()),
            counts: both("counts", 4, 4),
            ranges: both("ranges", blocks, 8),
            dispatches: [(); 2].map(|()| arguments()),
            work: [(); 4].map(|()| of("work", pairs + 2, 4)),
            work_dispatches: [(); 4].map(|()| arguments()),
        })
    }
}
