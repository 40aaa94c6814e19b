//! Device buffers of the linker.

use crate::adapter::Gpu;
use crate::bindings::{BindingTable, STORAGE, UNIFORM};
use crate::link_records::{
    BLOCK_SPOTS, BlockRecord, LaneRecord, PairRecord, RadiosityRecord, RequestRecord, SpotRecord,
};
use crate::records::{SHOT_BYTES, ShaderParams, ShotRecord};
use crate::solver_buffers::{add_geometry, max_binding_bytes};
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
const DISPATCH_BYTES: u64 = 32;

/// Work list of each of the four steps of refinement, and the workgroups over its spots.
pub const WORK_LISTS: [[&str; 2]; 4] = [
    ["source_work", "source_dispatches"],
    ["start_work", "start_dispatches"],
    ["more_work", "more_dispatches"],
    ["visibility_work", "visibility_dispatches"],
];

/// Buffers by the shaders' names.
pub struct LinkBuffers {
    /// Those of all levels; `shots` are the tree's nodes.
    pub table: BindingTable,
    /// Those of even levels and of odd ones.
    pub levels: [BindingTable; 2],
}

impl LinkBuffers {
    pub fn new(gpu: &Gpu, mesh: &Mesh, tree_nodes: &[ShotRecord]) -> Result<Self> {
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
        let [pairs, links, blocks] = [MAX_LEVEL_PAIRS, MAX_BATCH_LINKS, MAX_BATCH_BLOCKS].map(u64::from);
        let spots = u64::from(BLOCK_SPOTS);
        let arguments = STORAGE | Usage::INDIRECT;
        let of = |count: u64, size: usize| count * size as u64;
        let level = || {
            let zeroed = [
                ("pairs", of(pairs, size_of::<PairRecord>()), STORAGE),
                ("counts", 16, STORAGE),
                ("ranges", 8 * blocks, STORAGE),
                ("dispatches", DISPATCH_BYTES, arguments),
            ];
            BindingTable::zeroed(device, zeroed)
        };
        let zeroed = [
            (
                "radiosity",
                of(tree_nodes.len() as u64, size_of::<RadiosityRecord>()),
                STORAGE,
            ),
            ("request", size_of::<RequestRecord>() as u64, UNIFORM),
            ("spots", of(blocks * spots, size_of::<SpotRecord>()), STORAGE),
            ("blocks", of(blocks, size_of::<BlockRecord>()), STORAGE),
            ("lanes", of(pairs * spots, size_of::<LaneRecord>()), STORAGE),
            ("offsets", 8 * (pairs + 1), STORAGE),
            ("totals", 16, STORAGE),
            ("sums", 16 * blocks * spots, STORAGE),
            ("ends", 8 * links, STORAGE),
            ("links", 16 * links * spots, STORAGE),
        ];
        let mut table = BindingTable::zeroed(device, zeroed);
        for [work, dispatches] in WORK_LISTS {
            let lists = [
                (work, 4 * (pairs + 2), STORAGE),
                (dispatches, DISPATCH_BYTES, arguments),
            ];
            table = table.joined_with(&BindingTable::zeroed(device, lists));
        }
        // A scene without captured light.
        let params = ShaderParams {
            faces: mesh.faces.len() as u32,
            room: mesh.room_faces,
            ..ShaderParams::zeroed()
        };
        table.add_filled(device, "shots", tree_nodes, STORAGE);
        table.add_filled(device, "params", &[params], UNIFORM);
        add_geometry(&mut table, gpu, mesh)?;
        Ok(Self {
            table,
            levels: [level(), level()],
        })
    }
}
