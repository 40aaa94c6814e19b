//! What a solve keeps on the device: the scene, the texels' state and the links; allocated once.

use crate::adapter::Gpu;
use crate::dispatches::DISPATCH_BYTES;
use crate::grids::{grids, level_bytes};
use crate::records::{
    CellRecord, FaceRecord, LOG_COUNT_BYTES, LogRecord, PointRecord, ROW_BYTES, TexelRecord,
};
use bytemuck::{Pod, cast, cast_slice};
use common::bvh::Bvh;
use common::constants::{LEVELS, RAY_STACK};
use common::escape::directions;
use common::mesh::Mesh;
use common::settings::Transport;
use common::shooting::initial;
use common::{Error, Result};
use wgpu::BufferUsages as Usage;
use wgpu::util::{BufferInitDescriptor, DeviceExt};

/// Shots that one submission can log.
pub const BATCH: u32 = 1024;

/// Buffers of one solve.
pub struct Buffers {
    pub faces: wgpu::Buffer,
    pub cells: wgpu::Buffer,
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
    /// Bytes that links, and what cells exchange, may take.
    pub budget: u64,
}

/// Bytes of the log of a full batch.
pub const LOG_BYTES: u64 = LOG_COUNT_BYTES + BATCH as u64 * size_of::<LogRecord>() as u64;

impl Buffers {
    /// Buffers of which the links take no more than `budget`.
    pub fn new(gpu: &Gpu, mesh: &Mesh, transport: &Transport, budget: u64) -> Result<Self> {
        check_limits(gpu, mesh, transport)?;
        let device = &gpu.device;
        let storage = Usage::STORAGE | Usage::COPY_SRC | Usage::COPY_DST;
        let empty = |label, size: u64, usage| empty(device, label, size, usage);
        let state = initial(mesh, "");
        let faces: Vec<FaceRecord> = mesh.faces.iter().map(Into::into).collect();
        let cells: Vec<CellRecord> = mesh.cells.iter().map(Into::into).collect();
        let texels: Vec<TexelRecord> = mesh.texels.iter().map(Into::into).collect();
        let points: Vec<PointRecord> = mesh.points.iter().map(Into::into).collect();
        let directions: Vec<[f32; 4]> = directions().iter().map(|d| d.extend(0.0).into()).collect();
        let texel_count = mesh.texels.len() as u64;
        let budget = budget.min(most_bytes(gpu));
        let places = places(mesh, budget);
        let (nodes, primitives) = tree(gpu, mesh)?;
        Ok(Self {
            faces: filled(device, "faces", &faces, storage),
            cells: filled(device, "cells", &cells, storage),
            texels: filled(device, "texels", &texels, storage),
            directions: filled(device, "directions", &directions, storage),
            indices: filled(device, "indices", &grids(), Usage::INDEX),
            dispatches: empty("dispatches", DISPATCH_BYTES, storage | Usage::INDIRECT),
            script: empty("script", 4 * (u64::from(BATCH) + 1), storage),
            log: empty("log", LOG_BYTES, storage),
            lost: empty("lost", 4 * mesh.cells.len() as u64, storage),
            sums: empty("sums", 16 * mesh.cells.len() as u64, storage),
            links: empty("links", 4 * texel_count * u64::from(places), storage),
            rows: empty("rows", ROW_BYTES * u64::from(places), storage),
            points: filled(device, "points", &points, storage),
            nodes: filled(device, "nodes", &nodes, storage),
            primitives: filled(device, "primitives", &primitives, storage),
            places,
            budget,
            radiosity: filled(device, "radiosity", &state.radiosity, storage),
            residual: filled(device, "residual", &state.residual, storage),
            irradiance: filled(device, "irradiance", &state.irradiance, storage),
        })
    }
}

/// How many rows of links fit; at least one.
fn places(mesh: &Mesh, budget: u64) -> u32 {
    let row = 4 * mesh.texels.len().max(1) as u64;
    (budget / row).clamp(1, mesh.cells.len().max(1) as u64) as u32
}

/// The most that one binding holds.
pub fn most_bytes(gpu: &Gpu) -> u64 {
    let limits = gpu.device.limits();
    limits
        .max_storage_buffer_binding_size
        .min(limits.max_buffer_size)
}

/// The nodes of the BVH, 20 words each, and the face of each primitive.
pub fn tree(gpu: &Gpu, mesh: &Mesh) -> Result<(Vec<[u32; 20]>, Vec<u32>)> {
    let bvh = Bvh::new(mesh);
    if bvh.depth() > RAY_STACK {
        return Err(Error::Device(format!(
            "{}: the tree over the faces is {} levels deep, a ray holds {RAY_STACK}: the CPU can solve it",
            gpu.line.name,
            bvh.depth(),
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

/// A buffer of zeros.
pub fn empty(device: &wgpu::Device, label: &str, size: u64, usage: Usage) -> wgpu::Buffer {
    device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size,
        usage,
        mapped_at_creation: false,
    })
}

/// A buffer of `data`.
pub fn filled<T: Pod>(
    device: &wgpu::Device,
    label: &str,
    data: &[T],
    usage: Usage,
) -> wgpu::Buffer {
    device.create_buffer_init(&BufferInitDescriptor {
        label: Some(label),
        contents: cast_slice(data),
        usage,
    })
}

/// A texture to draw into.
pub fn target(
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

/// Says which limit is too small before anything is allocated.
fn check_limits(gpu: &Gpu, mesh: &Mesh, transport: &Transport) -> Result<()> {
    let limits = gpu.device.limits();
    let most = most_bytes(gpu);
    let needs = [
        ("texels", size_of::<TexelRecord>() * mesh.texels.len()),
        ("cells", size_of::<CellRecord>() * mesh.cells.len()),
        (
            "points of the cells",
            size_of::<PointRecord>() * mesh.points.len(),
        ),
        ("faces", size_of::<FaceRecord>() * mesh.faces.len()),
        (
            "tessellation lists",
            LEVELS as usize * level_bytes(mesh) as usize,
        ),
    ];
    for (what, bytes) in needs {
        if bytes as u64 > most {
            return Err(Error::Device(format!(
                "{}: the {what} need {} MiB in one buffer, max_storage_buffer_binding_size is {} MiB: ask for fewer texels or cells a face, or let the CPU solve it",
                gpu.line.name,
                bytes >> 20,
                most >> 20,
            )));
        }
    }
    let size = transport
        .visibility
        .drawing()
        .map_or(0, |drawing| drawing.size);
    if size > limits.max_texture_dimension_2d {
        return Err(Error::Device(format!(
            "{}: an item buffer of {size}² pixels is beyond max_texture_dimension_2d = {}",
            gpu.line.name, limits.max_texture_dimension_2d
        )));
    }
    Ok(())
}
