//! Device buffers of a solve: the scene, the texels' state and the links; allocated once. All stages of shots and
//! passes bind them.

use crate::adapter::Gpu;
use crate::bindings::{BindingTable, STORAGE};
use crate::dispatch_arguments::DISPATCH_BYTES;
use crate::records::{FaceRecord, LOG_COUNT_BYTES, LogRecord, PatchRecord, PointRecord, ROW_BYTES, TexelRecord};
use bytemuck::cast;
use common::bvh::Bvh;
use common::constants::RAY_STACK_LEVELS;
use common::escape::escape_directions;
use common::mesh::Mesh;
use common::settings::Transport;
use common::shooting::initial_field;
use common::{Error, Result};
use glam::Vec4;
use wgpu::BufferUsages as Usage;

/// Most shots of a submission: its log holds no more.
pub const MAX_BATCH_SHOTS: u32 = 1024;

/// Buffers of one solve.
pub struct SolverBuffers {
    /// The buffers by the shaders' names; `links` holds places × texels.
    pub table: BindingTable,
    /// Rows of links that are kept.
    pub places: u32,
    /// Most bytes of links, and of transfers between patches.
    pub budget: u64,
}

/// Bytes of the log of a full submission.
pub const LOG_BYTES: u64 = LOG_COUNT_BYTES + MAX_BATCH_SHOTS as u64 * size_of::<LogRecord>() as u64;

impl SolverBuffers {
    /// Allocates the buffers; links take no more than `budget` bytes.
    pub fn new(gpu: &Gpu, mesh: &Mesh, transport: &Transport, budget: u64) -> Result<Self> {
        check_limits(gpu, mesh, transport)?;
        let device = &gpu.device;
        let (texels, patches) = (mesh.texels.len() as u64, mesh.patches.len() as u64);
        let budget = budget.min(max_binding_bytes(gpu));
        let places = row_places(mesh, budget);
        let behind_end = gpu.elements_behind_end();
        let zeroed = [
            ("dispatches", DISPATCH_BYTES, STORAGE | Usage::INDIRECT),
            ("script", 4 * (u64::from(MAX_BATCH_SHOTS) + 1), STORAGE),
            ("log", LOG_BYTES, STORAGE),
            ("escape_counts", 4 * patches, STORAGE),
            ("sums", 16 * (patches + behind_end as u64), STORAGE),
            ("links", 4 * texels * u64::from(places), STORAGE),
            ("rows", ROW_BYTES * u64::from(places), STORAGE),
        ];
        let mut table = BindingTable::zeroed(device, zeroed);
        let mut patches: Vec<PatchRecord> = mesh.patches.iter().map(Into::into).collect();
        patches.append(&mut gpu.patches_behind_end(mesh.texels.len()));
        let texels: Vec<TexelRecord> = mesh.texels.iter().map(Into::into).collect();
        let points: Vec<PointRecord> = mesh.patch_points.iter().map(Into::into).collect();
        let directions: Vec<[f32; 4]> = escape_directions().iter().map(|d| d.extend(0.0).into()).collect();
        let state = initial_field(mesh, "");
        table.add_filled(device, "patches", &patches, STORAGE);
        table.add_filled(device, "texels", &texels, STORAGE);
        table.add_filled(device, "points", &points, STORAGE);
        table.add_filled(device, "directions", &directions, STORAGE);
        let fields = [
            ("radiosity", state.radiosity),
            ("residual", state.residual),
            ("irradiance", state.irradiance),
        ];
        for (name, mut values) in fields {
            values.resize(mesh.texels.len() + behind_end, Vec4::ZERO);
            table.add_filled(device, name, &values, STORAGE);
        }
        add_geometry(&mut table, gpu, mesh)?;
        Ok(Self { table, places, budget })
    }
}

/// Returns the number of rows of links that fit; at least one.
fn row_places(mesh: &Mesh, budget: u64) -> u32 {
    let row = 4 * mesh.texels.len().max(1) as u64;
    (budget / row).clamp(1, mesh.patches.len().max(1) as u64) as u32
}

/// Returns the most bytes that one binding holds.
pub fn max_binding_bytes(gpu: &Gpu) -> u64 {
    let limits = gpu.device.limits();
    limits.max_storage_buffer_binding_size.min(limits.max_buffer_size)
}

/// Adds the faces, the nodes of their BVH and the face of each primitive.
pub fn add_geometry(table: &mut BindingTable, gpu: &Gpu, mesh: &Mesh) -> Result<()> {
    let bvh = Bvh::new(mesh);
    if bvh.tree_depth() > RAY_STACK_LEVELS {
        return Err(Error::Device(format!(
            "{}: the tree over the faces is {} levels deep, a ray on the GPU traverses {RAY_STACK_LEVELS}: the CPU can solve it",
            gpu.line.name,
            bvh.tree_depth(),
        )));
    }
    let faces: Vec<FaceRecord> = mesh.faces.iter().map(Into::into).collect();
    let mut nodes: Vec<[u32; 20]> = bvh.tree.nodes.iter().map(|node| cast(*node)).collect();
    let mut primitives = bvh.faces;
    if nodes.is_empty() {
        nodes.push([0; 20]);
    }
    if primitives.is_empty() {
        primitives.push(0);
    }
    table.add_filled(&gpu.device, "faces", &faces, STORAGE);
    table.add_filled(&gpu.device, "nodes", &nodes, STORAGE);
    table.add_filled(&gpu.device, "primitives", &primitives, STORAGE);
    Ok(())
}

/// Creates a texture to draw into.
pub fn render_target(
    device: &wgpu::Device,
    label: &str,
    [width, height]: [u32; 2],
    format: wgpu::TextureFormat,
) -> wgpu::Texture {
    device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d {
            width,
            height,
            depth_or_array_layers: 1,
        },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT
            | wgpu::TextureUsages::TEXTURE_BINDING
            | wgpu::TextureUsages::COPY_SRC
            | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    })
}

/// Checks the adapter's limits before anything is allocated.
///
/// Errors: [`Error::Device`] names the limit that is too small.
fn check_limits(gpu: &Gpu, mesh: &Mesh, transport: &Transport) -> Result<()> {
    let limits = gpu.device.limits();
    let most = max_binding_bytes(gpu);
    let needs = [
        ("texels", size_of::<TexelRecord>() * mesh.texels.len()),
        ("patches", size_of::<PatchRecord>() * mesh.patches.len()),
        (
            "points of the patches",
            size_of::<PointRecord>() * mesh.patch_points.len(),
        ),
        ("faces", size_of::<FaceRecord>() * mesh.faces.len()),
    ];
    for (what, bytes) in needs {
        if bytes as u64 > most {
            return Err(Error::Device(format!(
                "{}: the {what} need {} MiB in one buffer, max_storage_buffer_binding_size is {} MiB: ask for fewer texels or patches a face, or let the CPU solve it",
                gpu.line.name,
                bytes >> 20,
                most >> 20,
            )));
        }
    }
    let size = transport.visibility.item_buffer().map_or(0, |drawing| drawing.size);
    if size > limits.max_texture_dimension_2d {
        return Err(Error::Device(format!(
            "{}: an item buffer of {size}² pixels is beyond max_texture_dimension_2d = {}",
            gpu.line.name, limits.max_texture_dimension_2d
        )));
    }
    Ok(())
}
