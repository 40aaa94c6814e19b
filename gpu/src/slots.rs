//! What making links needs beside the scene: for the one shot that is chosen on the device, or for
//! many shots side by side.

use crate::adapter::Gpu;
use crate::buffers::{Buffers, empty, filled, most_bytes, target};
use crate::grids::{draws, level_bytes};
use crate::records::{Params, SHOT_BYTES};
use common::constants::LEVELS;
use common::mesh::Mesh;
use common::settings::{Drawing, Raster, Transport, Visibility};
use wgpu::BufferUsages as Usage;

/// Rays of one dispatch: some ten milliseconds on hardware, far from what drivers kill.
const RAYS: u64 = 1 << 24;
/// More shots side by side than this gain nothing.
const MOST: u64 = 256;
/// Bytes of item buffers, and of sums over samples, of all slots together.
const SLOT_BYTES: u64 = 1 << 27;
/// The same where the processor draws: its caches are small, and clearing a buffer takes its time.
const SOFTWARE_BYTES: u64 = 1 << 25;
/// Bytes of a pixel: IDs of all, of the room, depth.
const PIXEL_BYTES: u64 = 12;

/// Buffers and textures of as many shots as there are slots.
pub struct Slots {
    pub params: wgpu::Buffer,
    pub shots: wgpu::Buffer,
    /// Slots × texels.
    pub samples: wgpu::Buffer,
    /// What each cell takes: of one shot, or of every cell.
    pub taken: wgpu::Buffer,
    pub rectangles: wgpu::Buffer,
    pub instances: wgpu::Buffer,
    pub draws: wgpu::Buffer,
    pub item_buffer: wgpu::Texture,
    pub view: wgpu::TextureView,
    /// What the item buffer shows without the objects; none where there are none.
    pub room_buffer: Option<wgpu::TextureView>,
    pub depth: wgpu::TextureView,
    pub count: u32,
    /// Item buffers side by side.
    pub tiles: u32,
    /// Pixels of one, and the planes of its image; 0 where rays are asked.
    pub size: u32,
    pub sides: u32,
    /// Samples that one dispatch adds.
    pub step: u32,
}

impl Slots {
    /// `count` slots, and room for what cells take of `rows` of them.
    pub fn new(gpu: &Gpu, mesh: &Mesh, transport: &Transport, count: u32, rows: u32) -> Self {
        let device = &gpu.device;
        let storage = Usage::STORAGE | Usage::COPY_SRC | Usage::COPY_DST;
        let empty = |label, size: u64, usage| empty(device, label, size, usage);
        let (slots, texels) = (u64::from(count), mesh.texels.len() as u64);
        let cells = mesh.cells.len() as u64;
        let image = match transport.visibility {
            Visibility::Rays => Image::none(mesh, count),
            Visibility::Drawn(drawing) => Image::of(&drawing, count),
        };
        let Image {
            step,
            tiles,
            pixels,
            size,
            sides,
        } = image;
        let ids = |label| target(device, label, pixels, wgpu::TextureFormat::R32Uint);
        let item_buffer = ids("item buffer");
        let depth = target(device, "depth", pixels, wgpu::TextureFormat::Depth32Float);
        let relit = mesh.room < mesh.faces.len() as u32;
        let uniform = Usage::UNIFORM | Usage::COPY_DST;
        let lists = u64::from(LEVELS) * level_bytes(mesh);
        Self {
            params: empty("params", size_of::<Params>() as u64, uniform),
            shots: empty("shots", SHOT_BYTES * slots, storage),
            samples: empty("samples", 16 * texels * slots, storage),
            taken: empty("taken", 4 * cells * u64::from(rows), storage),
            rectangles: empty("rectangles", 16, storage | Usage::INDIRECT),
            instances: empty("instances", lists, storage | Usage::VERTEX),
            draws: filled(device, "draws", &draws(), storage | Usage::INDIRECT),
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

/// What the item buffers of some slots are like.
struct Image {
    step: u32,
    tiles: u32,
    pixels: [u32; 2],
    size: u32,
    sides: u32,
}

impl Image {
    fn of(drawing: &Drawing, count: u32) -> Self {
        // A square, or a row less.
        let tiles = count.saturating_sub(1).isqrt() + 1;
        Self {
            // A sample is a picture.
            step: 1,
            tiles,
            pixels: [tiles, count.div_ceil(tiles)].map(|n| n * drawing.size),
            size: drawing.size,
            sides: drawing.projection.sides(),
        }
    }

    /// Where rays are asked: a texture has at least a pixel.
    fn none(mesh: &Mesh, count: u32) -> Self {
        let links = mesh.texels.len() as u64 * u64::from(count);
        Self {
            step: (RAYS / links.max(1)).clamp(1, u64::from(mesh.samples)) as u32,
            tiles: 1,
            pixels: [1, 1],
            size: 0,
            sides: 0,
        }
    }
}

/// How many shots side by side the adapter has room for; at least one.
pub fn most_slots(gpu: &Gpu, mesh: &Mesh, transport: &Transport, b: &Buffers) -> u32 {
    let texels = mesh.texels.len().max(1) as u64;
    let bytes = if gpu.line.software {
        SOFTWARE_BYTES
    } else {
        SLOT_BYTES
    };
    let most = (bytes.min(most_bytes(gpu)) / (16 * texels))
        .min(RAYS / texels)
        .min(u64::from(b.places))
        .min(MOST);
    let Visibility::Drawn(drawing) = transport.visibility else {
        return most.max(1) as u32;
    };
    if drawing.projection.raster() == Raster::Tessellated {
        // The lists of instances are those of one shot.
        return 1;
    }
    let side = u64::from(drawing.size.max(1));
    let across = u64::from(gpu.device.limits().max_texture_dimension_2d) / side;
    most.min(bytes / (PIXEL_BYTES * side * side))
        .min(across * across)
        .max(1) as u32
}
