//! Everything a solve keeps on the device; allocated once.

use crate::adapter::Gpu;
use crate::batch::DISPATCH_BYTES;
use crate::records::{
    CellRecord, FaceRecord, LOG_HEAD_BYTES, LogRecord, Params, PointRecord, ROW_BYTES, SHOT_BYTES,
    TexelRecord,
};
use bytemuck::{Pod, cast, cast_slice};
use common::bvh::Bvh;
use common::constants::{LEVELS, LINK_BYTES, RAY_STACK};
use common::escape::directions;
use common::mesh::Mesh;
use common::settings::{Settings, Visibility};
use common::shooting::initial;
use common::{Error, Result};
use wgpu::BufferUsages as Usage;
use wgpu::util::{BufferInitDescriptor, DeviceExt};

/// Shots that one submission can log.
pub const BATCH: u32 = 1024;

/// Rays of one dispatch: some ten milliseconds on hardware, far from what drivers kill.
const RAYS: u64 = 1 << 24;

/// Buffers and textures of one solve.
pub struct Buffers {
    pub params: wgpu::Buffer,
    pub faces: wgpu::Buffer,
    pub cells: wgpu::Buffer,
    pub texels: wgpu::Buffer,
    pub directions: wgpu::Buffer,
    pub instances: wgpu::Buffer,
    pub indices: wgpu::Buffer,
    pub draws: wgpu::Buffer,
    pub dispatches: wgpu::Buffer,
    pub rectangles: wgpu::Buffer,
    pub shot: wgpu::Buffer,
    pub script: wgpu::Buffer,
    pub log: wgpu::Buffer,
    pub lost: wgpu::Buffer,
    pub sums: wgpu::Buffer,
    /// Places × texels.
    pub links: wgpu::Buffer,
    pub rows: wgpu::Buffer,
    pub taken: wgpu::Buffer,
    pub samples: wgpu::Buffer,
    pub points: wgpu::Buffer,
    pub nodes: wgpu::Buffer,
    pub primitives: wgpu::Buffer,
    pub radiosity: wgpu::Buffer,
    pub residual: wgpu::Buffer,
    pub irradiance: wgpu::Buffer,
    pub item_buffer: wgpu::Texture,
    /// What the item buffer shows without the objects; none where there are none.
    pub room_buffer: Option<wgpu::TextureView>,
    pub depth: wgpu::Texture,
    /// Rows of links that are kept.
    pub places: u32,
    /// Samples that one dispatch adds.
    pub step: u32,
}

/// Bytes of the log of a full batch.
pub const LOG_BYTES: u64 = LOG_HEAD_BYTES + BATCH as u64 * size_of::<LogRecord>() as u64;

/// Bytes of one level's list of instances: (face, parts) each.
pub fn level_bytes(mesh: &Mesh) -> u64 {
    8 * mesh.faces.len() as u64
}

impl Buffers {
    pub fn new(gpu: &Gpu, mesh: &Mesh, settings: &Settings) -> Result<Self> {
        check_limits(gpu, mesh, settings)?;
        let device = &gpu.device;
        let storage = Usage::STORAGE | Usage::COPY_SRC | Usage::COPY_DST;
        let empty = |label, size: u64, usage| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size,
                usage,
                mapped_at_creation: false,
            })
        };
        let state = initial(mesh, "");
        let faces: Vec<FaceRecord> = mesh.faces.iter().map(Into::into).collect();
        let cells: Vec<CellRecord> = mesh.cells.iter().map(Into::into).collect();
        let texels: Vec<TexelRecord> = mesh.texels.iter().map(Into::into).collect();
        let points: Vec<PointRecord> = mesh.points.iter().map(Into::into).collect();
        let directions: Vec<[f32; 4]> = directions().iter().map(|d| d.extend(0.0).into()).collect();
        let (indices, draws) = grids();
        let texel_count = mesh.texels.len() as u64;
        let places = places(gpu, mesh);
        let rays = settings.visibility == Visibility::Rays;
        let (nodes, primitives) = tree(gpu, mesh, rays)?;
        let step = if rays {
            (RAYS / texel_count.max(1)).clamp(1, u64::from(mesh.samples)) as u32
        } else {
            1
        };
        let pixels = if rays { 1 } else { settings.item_buffer };
        Ok(Self {
            params: empty(
                "params",
                size_of::<Params>() as u64,
                Usage::UNIFORM | Usage::COPY_DST,
            ),
            faces: filled(device, "faces", &faces, storage),
            cells: filled(device, "cells", &cells, storage),
            texels: filled(device, "texels", &texels, storage),
            directions: filled(device, "directions", &directions, storage),
            instances: empty(
                "instances",
                u64::from(LEVELS) * level_bytes(mesh),
                storage | Usage::VERTEX,
            ),
            indices: filled(device, "indices", &indices, Usage::INDEX),
            draws: filled(device, "draws", &draws, storage | Usage::INDIRECT),
            dispatches: empty("dispatches", DISPATCH_BYTES, storage | Usage::INDIRECT),
            rectangles: empty("rectangles", 16, storage | Usage::INDIRECT),
            shot: empty("shot", SHOT_BYTES, storage),
            script: empty("script", 4 * (u64::from(BATCH) + 1), storage),
            log: empty("log", LOG_BYTES, storage),
            lost: empty("lost", 4 * mesh.cells.len() as u64, storage),
            sums: empty("sums", 16 * mesh.cells.len() as u64, storage),
            links: empty("links", 4 * texel_count * u64::from(places), storage),
            rows: empty("rows", ROW_BYTES * u64::from(places), storage),
            taken: empty("taken", 4 * mesh.cells.len() as u64, storage),
            samples: empty("samples", 16 * texel_count, storage),
            points: filled(device, "points", &points, storage),
            nodes: filled(device, "nodes", &nodes, storage),
            primitives: filled(device, "primitives", &primitives, storage),
            places,
            step,
            radiosity: filled(device, "radiosity", &state.radiosity, storage),
            residual: filled(device, "residual", &state.residual, storage),
            irradiance: filled(device, "irradiance", &state.irradiance, storage),
            item_buffer: target(device, "item buffer", pixels, wgpu::TextureFormat::R32Uint),
            room_buffer: (mesh.room < mesh.faces.len() as u32).then(|| {
                target(device, "room buffer", pixels, wgpu::TextureFormat::R32Uint)
                    .create_view(&wgpu::TextureViewDescriptor::default())
            }),
            depth: target(device, "depth", pixels, wgpu::TextureFormat::Depth32Float),
        })
    }
}

/// How many rows of links fit the budget and the adapter; at least one.
fn places(gpu: &Gpu, mesh: &Mesh) -> u32 {
    let budget = LINK_BYTES.min(most_bytes(gpu));
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

/// The nodes of the BVH, 20 words each, and the face of each primitive; one empty node where
/// nobody traverses it.
fn tree(gpu: &Gpu, mesh: &Mesh, rays: bool) -> Result<(Vec<[u32; 20]>, Vec<u32>)> {
    if !rays {
        return Ok((vec![[0; 20]], vec![0]));
    }
    let bvh = Bvh::new(mesh);
    if bvh.depth() > RAY_STACK {
        return Err(Error::Device(format!(
            "{}: the tree over the faces is {} levels deep, a ray holds {RAY_STACK}: use --solver cpu",
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

fn filled<T: Pod>(device: &wgpu::Device, label: &str, data: &[T], usage: Usage) -> wgpu::Buffer {
    device.create_buffer_init(&BufferInitDescriptor {
        label: Some(label),
        contents: cast_slice(data),
        usage,
    })
}

fn target(
    device: &wgpu::Device,
    label: &str,
    size: u32,
    format: wgpu::TextureFormat,
) -> wgpu::Texture {
    device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d {
            width: size,
            height: size,
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

/// A face cut into 2^l × 2^l quads of two triangles for every level l, and the arguments of its
/// draw: index count, instances (set on the device), first index, base vertex, first instance.
fn grids() -> (Vec<u32>, Vec<u32>) {
    let mut indices = Vec::new();
    let mut draws = Vec::new();
    for level in 0..LEVELS {
        let parts = 1u32 << level;
        let first = indices.len() as u32;
        for j in 0..parts {
            for i in 0..parts {
                let a = j * (parts + 1) + i;
                let (b, c, d) = (a + 1, a + parts + 2, a + parts + 1);
                indices.extend([a, b, c, a, c, d]);
            }
        }
        draws.extend([6 * parts * parts, 0, first, 0, 0]);
    }
    (indices, draws)
}

/// Says which limit is too small before anything is allocated.
fn check_limits(gpu: &Gpu, mesh: &Mesh, settings: &Settings) -> Result<()> {
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
                "{}: the {what} need {} MiB in one buffer, max_storage_buffer_binding_size is {} MiB: lower --texels or --cells, or use --solver cpu",
                gpu.line.name,
                bytes >> 20,
                most >> 20,
            )));
        }
    }
    if settings.item_buffer > limits.max_texture_dimension_2d {
        return Err(Error::Device(format!(
            "{}: --item-buffer {} is beyond max_texture_dimension_2d = {}",
            gpu.line.name, settings.item_buffer, limits.max_texture_dimension_2d
        )));
    }
    Ok(())
}
