//! Device buffers of a solve: the scene, the texels' state and the links; allocated once.

use crate::adapter::Gpu;
use crate::dispatch_arguments::DISPATCH_BYTES;
use crate::records::{FaceRecord, LOG_COUNT_BYTES, LogRecord, PatchRecord, PointRecord, ROW_BYTES, TexelRecord};
use crate::tessellation_grids::{grid_indices, level_bytes};
use bytemuck::{Pod, cast, cast_slice};
use common::bvh::Bvh;
use common::constants::{RAY_STACK_LEVELS, TESSELLATION_LEVELS};
use common::escape::escape_directions;
use common::mesh::Mesh;
use common::settings::Transport;
use common::shooting::initial_field;
use common::{Error, Result};
use wgpu::BufferUsages as Usage;
use wgpu::util::{BufferInitDescriptor, DeviceExt};

/// Most shots of a submission: its log holds no more.
pub const MAX_BATCH_SHOTS: u32 = 1024;

/// Buffers of one solve.
pub struct SolverBuffers {
    pub faces: wgpu::Buffer,
    pub patches: wgpu::Buffer,
    pub texels: wgpu::Buffer,
    pub directions: wgpu::Buffer,
    pub indices: wgpu::Buffer,
    pub dispatches: wgpu::Buffer,
    pub script: wgpu::Buffer,
    pub log: wgpu::Buffer,
    pub lost: wgpu::Buffer,
    pub sums: wgpu::Buffer,
    /// Places × texels.
    pub links: wgpu::Buffer,
    pub rows: wgpu::Buffer,
    pub points: wgpu::Buffer,
    pub nodes: wgpu::Buffer,
    pub primitives: wgpu::Buffer,
    pub radiosity: wgpu::Buffer,
    pub residual: wgpu::Buffer,
    pub irradiance: wgpu::Buffer,
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
        let storage = Usage::STORAGE | Usage::COPY_SRC | Usage::COPY_DST;
        let empty = |label, size: u64, usage| zeroed_buffer(device, label, size, usage);
        let state = initial_field(mesh, "");
        let faces: Vec<FaceRecord> = mesh.faces.iter().map(Into::into).collect();
        let patches: Vec<PatchRecord> = mesh.patches.iter().map(Into::into).collect();
        let texels: Vec<TexelRecord> = mesh.texels.iter().map(Into::into).collect();
        let points: Vec<PointRecord> = mesh.patch_points.iter().map(Into::into).collect();
        let directions: Vec<[f32; 4]> = escape_directions().iter().map(|d| d.extend(0.0).into()).collect();
        let texel_count = mesh.texels.len() as u64;
        let budget = budget.min(max_binding_bytes(gpu));
        let places = row_places(mesh, budget);
        let (nodes, primitives) = bvh_words(gpu, mesh)?;
        Ok(Self {
            faces: filled_buffer(device, "faces", &faces, storage),
            patches: filled_buffer(device, "patches", &patches, storage),
            texels: filled_buffer(device, "texels", &texels, storage),
            directions: filled_buffer(device, "directions", &directions, storage),
            indices: filled_buffer(device, "indices", &grid_indices(), Usage::INDEX),
            dispatches: empty("dispatches", DISPATCH_BYTES, storage | Usage::INDIRECT),
            script: empty("script", 4 * (u64::from(MAX_BATCH_SHOTS) + 1), storage),
            log: empty("log", LOG_BYTES, storage),
            lost: empty("lost", 4 * mesh.patches.len() as u64, storage),
            sums: empty("sums", 16 * mesh.patches.len() as u64, storage),
            links: empty("links", 4 * texel_count * u64::from(places), storage),
            rows: empty("rows", ROW_BYTES * u64::from(places), storage),
            points: filled_buffer(device, "points", &points, storage),
            nodes: filled_buffer(device, "nodes", &nodes, storage),
            primitives: filled_buffer(device, "primitives", &primitives, storage),
            places,
            budget,
            radiosity: filled_buffer(device, "radiosity", &state.radiosity, storage),
            residual: filled_buffer(device, "residual", &state.residual, storage),
            irradiance: filled_buffer(device, "irradiance", &state.irradiance, storage),
        })
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

/// Returns the nodes of the BVH, 20 words each, and the face of each primitive.
pub fn bvh_words(gpu: &Gpu, mesh: &Mesh) -> Result<(Vec<[u32; 20]>, Vec<u32>)> {
    let bvh = Bvh::new(mesh);
    if bvh.tree_depth() > RAY_STACK_LEVELS {
        return Err(Error::Device(format!(
            "{}: the tree over the faces is {} levels deep, a ray on the GPU traverses {RAY_STACK_LEVELS}: the CPU can solve it",
            gpu.line.name,
            bvh.tree_depth(),
        )));
    }
    let mut nodes: Vec<[u32; 20]> = bvh.tree.nodes.iter().map(|node| cast(*node)).collect();
    let mut primitives = bvh.faces;
    if nodes.is_empty() {
        nodes.push([0; 20]);
    }
    if primitives.is_empty() {
        primitives.push(0);
    }
    Ok((nodes, primitives))
}

/// Creates a buffer of zeros.
pub fn zeroed_buffer(device: &wgpu::Device, label: &str, size: u64, usage: Usage) -> wgpu::Buffer {
    device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size,
        usage,
        mapped_at_creation: false,
    })
}

/// Creates a buffer of `data`.
pub fn filled_buffer<T: Pod>(device: &wgpu::Device, label: &str, data: &[T], usage: Usage) -> wgpu::Buffer {
    device.create_buffer_init(&BufferInitDescriptor {
        label: Some(label),
        contents: cast_slice(data),
        usage,
    })
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
            | wgpu::TextureUsages::COPY_SRC,
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
        (
            "tessellation lists",
            TESSELLATION_LEVELS as usize * level_bytes(mesh) as usize,
        ),
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
