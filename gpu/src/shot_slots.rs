//! Buffers and textures for making links: of the one shot that the device selects, or of many side by side.

use crate::adapter::Gpu;
use crate::records::{SHOT_BYTES, ShaderParams};
use crate::solver_buffers::{SolverBuffers, filled_buffer, max_binding_bytes, render_target, zeroed_buffer};
use crate::tessellation_grids::{draw_arguments, level_bytes};
use common::constants::TESSELLATION_LEVELS;
use common::mesh::Mesh;
use common::settings::{ItemBufferSettings, Raster, Transport, Visibility};
use wgpu::BufferUsages as Usage;

/// Most rays of a dispatch: some ten milliseconds on hardware, far below the time limit of drivers.
const MAX_DISPATCH_RAYS: u64 = 1 << 24;
/// Most shots side by side: more gain nothing.
const MAX_SLOTS: u64 = 256;
/// Most bytes of the item buffers, and of the sums over samples, of all slots together.
const SLOT_BYTES: u64 = 1 << 27;
/// The same on a software adapter: the processor's caches are small, and clearing a buffer takes time.
const SOFTWARE_SLOT_BYTES: u64 = 1 << 25;
/// Bytes of a pixel: ID with objects, ID without, depth.
const PIXEL_BYTES: u64 = 12;

/// Buffers and textures of `count` shots.
pub struct ShotSlots {
    pub params: wgpu::Buffer,
    pub shots: wgpu::Buffer,
    /// Slots × texels.
    pub samples: wgpu::Buffer,
    /// Transfers to each patch: of one shot, or of every patch.
    pub transfers: wgpu::Buffer,
    pub rectangles: wgpu::Buffer,
    pub instances: wgpu::Buffer,
    pub draws: wgpu::Buffer,
    pub item_buffer: wgpu::Texture,
    pub view: wgpu::TextureView,
    /// Item buffer of the room without objects; none where there are no objects.
    pub room_buffer: Option<wgpu::TextureView>,
    pub depth: wgpu::TextureView,
    pub count: u32,
    /// Item buffers side by side.
    pub tiles: u32,
    /// Pixels per side of one, and the planes of its image; 0 with visibility by rays.
    pub size: u32,
    pub sides: u32,
    /// Samples that one dispatch adds.
    pub step: u32,
}

impl ShotSlots {
    /// Creates `count` slots, and room for the transfers of `rows` patches.
    pub fn new(gpu: &Gpu, mesh: &Mesh, transport: &Transport, count: u32, rows: u32) -> Self {
        let device = &gpu.device;
        let storage = Usage::STORAGE | Usage::COPY_SRC | Usage::COPY_DST;
        let empty = |label, size: u64, usage| zeroed_buffer(device, label, size, usage);
        let (slots, texels) = (u64::from(count), mesh.texels.len() as u64);
        let patches = mesh.patches.len() as u64;
        let image = match transport.visibility {
            Visibility::Rays => SlotImages::no_images(mesh, count),
            Visibility::ItemBuffer(drawing) => SlotImages::drawn_images(&drawing, count),
        };
        let SlotImages {
            step,
            tiles,
            pixels,
            size,
            sides,
        } = image;
        let ids = |label| render_target(device, label, pixels, wgpu::TextureFormat::R32Uint);
        let item_buffer = ids("item buffer");
        let depth = render_target(device, "depth", pixels, wgpu::TextureFormat::Depth32Float);
        let relit = mesh.room_faces < mesh.faces.len() as u32;
        let uniform = Usage::UNIFORM | Usage::COPY_DST;
        let lists = u64::from(TESSELLATION_LEVELS) * level_bytes(mesh);
        Self {
            params: empty("params", size_of::<ShaderParams>() as u64, uniform),
            shots: empty("shots", SHOT_BYTES * slots, storage),
            samples: empty("samples", 16 * texels * slots, storage),
            transfers: empty("transfers", 4 * patches * u64::from(rows), storage),
            rectangles: empty("rectangles", 16, storage | Usage::INDIRECT),
            instances: empty("instances", lists, storage | Usage::VERTEX),
            draws: filled_buffer(device, "draws", &draw_arguments(), storage | Usage::INDIRECT),
            view: item_buffer.create_view(&Default::default()),
            room_buffer: relit.then(|| ids("room buffer").create_view(&Default::default())),
            depth: depth.create_view(&Default::default()),
            item_buffer,
            count,
            tiles,
            size,
            sides,
            step,
        }
    }
}

/// Sizes of the item buffers of some slots.
struct SlotImages {
    step: u32,
    tiles: u32,
    pixels: [u32; 2],
    size: u32,
    sides: u32,
}

impl SlotImages {
    fn drawn_images(drawing: &ItemBufferSettings, count: u32) -> Self {
        // A square, or a row less.
        let tiles = count.saturating_sub(1).isqrt() + 1;
        Self {
            // Every sample draws its own item buffer.
            step: 1,
            tiles,
            pixels: [tiles, count.div_ceil(tiles)].map(|n| n * drawing.size),
            size: drawing.size,
            sides: drawing.projection.plane_count(),
        }
    }

    /// Returns the sizes with visibility by rays: a texture has at least a pixel.
    fn no_images(mesh: &Mesh, count: u32) -> Self {
        let links = mesh.texels.len() as u64 * u64::from(count);
        Self {
            step: (MAX_DISPATCH_RAYS / links.max(1)).clamp(1, u64::from(mesh.samples)) as u32,
            tiles: 1,
            pixels: [1, 1],
            size: 0,
            sides: 0,
        }
    }
}

/// Returns the number of shots side by side that the adapter has room for; at least one.
pub fn max_slots(gpu: &Gpu, mesh: &Mesh, transport: &Transport, b: &SolverBuffers) -> u32 {
    let texels = mesh.texels.len().max(1) as u64;
    let bytes = if gpu.line.software {
        SOFTWARE_SLOT_BYTES
    } else {
        SLOT_BYTES
    };
    let most = (bytes.min(max_binding_bytes(gpu)) / (16 * texels))
        .min(MAX_DISPATCH_RAYS / texels)
        .min(u64::from(b.places))
        .min(MAX_SLOTS);
    let Visibility::ItemBuffer(drawing) = transport.visibility else {
        return most.max(1) as u32;
    };
    if drawing.projection.raster_method() == Raster::Tessellated {
        // The lists of instances are those of one shot.
        return 1;
    }
    let side = u64::from(drawing.size.max(1));
    let across = u64::from(gpu.device.limits().max_texture_dimension_2d) / side;
    most.min(bytes / (PIXEL_BYTES * side * side))
        .min(across * across)
        .max(1) as u32
}
