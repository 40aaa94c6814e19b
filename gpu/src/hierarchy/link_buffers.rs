//! Device buffers of the linker.

use crate::adapter::Gpu;
use crate::link_records::{
    BLOCK_SPOTS, BlockRecord, LaneRecord, LinkNode, PairRecord, RadiosityRecord, RequestRecord, SpotRecord,
};
use crate::records::{FaceRecord, SHOT_BYTES, ShaderParams, ShotRecord};
use crate::solver_buffers::{bvh_words, filled_buffer, max_binding_bytes, zeroed_buffer};
use bytemuck::Zeroable;
use common::mesh::Mesh;
use common::{Error, Result};
use wgpu::BufferUsages as Usage;

/// Most pairs of a level: their lanes take 24 MiB, and a dispatch of them with most rays takes some hundredths
/// of a second on hardware.
pub const MAX_LEVEL_PAIRS: u32 = 1 << 15;
/// Most links of a batch that keeps them.
pub const MAX_BATCH_LINKS: u32 = 1 << 15;
/// Most blocks of a batch.
pub const MAX_BATCH_BLOCKS: u32 = 1 << 11;
/// Bytes of the arguments of a level's two dispatches.
pub const DISPATCH_BYTES: u64 = 32;

pub struct LinkBuffers {
    pub faces: wgpu::Buffer,
    pub nodes: wgpu::Buffer,
    pub primitives: wgpu::Buffer,
    /// The tree's nodes.
    pub shots: wgpu::Buffer,
    pub radiosity: wgpu::Buffer,
    pub params: wgpu::Buffer,
    pub request: wgpu::Buffer,
    pub spots: wgpu::Buffer,
    pub blocks: wgpu::Buffer,
    pub lanes: wgpu::Buffer,
    pub offsets: wgpu::Buffer,
    pub totals: wgpu::Buffer,
    pub sums: wgpu::Buffer,
    pub ends: wgpu::Buffer,
    pub links: wgpu::Buffer,
    /// Pairs of even levels and of odd ones.
    pub pairs: [wgpu::Buffer; 2],
    pub counts: [wgpu::Buffer; 2],
    pub ranges: [wgpu::Buffer; 2],
    pub dispatches: [wgpu::Buffer; 2],
    /// Work lists that the four steps of refinement fill, and workgroups over their spots.
    pub work: [wgpu::Buffer; 4],
    pub work_dispatches: [wgpu::Buffer; 4],
}

impl LinkBuffers {
    pub fn new(gpu: &Gpu, mesh: &Mesh, tree_nodes: &[LinkNode]) -> Result<Self> {
        let most = max_binding_bytes(gpu);
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
        let of = |label, count: u64, size: usize| zeroed_buffer(device, label, count * size as u64, storage);
        let both = |label, count: u64, size: usize| [(); 2].map(|()| of(label, count, size));
        let arguments = || zeroed_buffer(device, "dispatches", DISPATCH_BYTES, storage | Usage::INDIRECT);
        let [pairs, links, blocks] = [MAX_LEVEL_PAIRS, MAX_BATCH_LINKS, MAX_BATCH_BLOCKS].map(u64::from);
        let spots = u64::from(BLOCK_SPOTS);
        let faces: Vec<FaceRecord> = mesh.faces.iter().map(Into::into).collect();
        let shots: Vec<ShotRecord> = tree_nodes.iter().map(|node| node.shot_record(mesh)).collect();
        let (nodes, primitives) = bvh_words(gpu, mesh)?;
        // A scene without captured light.
        let params = ShaderParams {
            faces: mesh.faces.len() as u32,
            room: mesh.room_faces,
            ..ShaderParams::zeroed()
        };
        Ok(Self {
            faces: filled_buffer(device, "faces", &faces, storage),
            nodes: filled_buffer(device, "nodes", &nodes, storage),
            primitives: filled_buffer(device, "primitives", &primitives, storage),
            shots: filled_buffer(device, "tree", &shots, storage),
            radiosity: of("radiosity", shots.len() as u64, size_of::<RadiosityRecord>()),
            params: filled_buffer(device, "params", &[params], uniform),
            request: zeroed_buffer(device, "request", size_of::<RequestRecord>() as u64, uniform),
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
