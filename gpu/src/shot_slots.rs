//! Buffers and textures for making links: of the one shot that the device selects, or of many side by side.

use crate::adapter::Gpu;
use crate::bindings::{BindingTable, STORAGE, UNIFORM};
use crate::records::{SHOT_BYTES, ShaderParams};
use crate::solver_buffers::{SolverBuffers, max_binding_bytes, render_target};
use common::mesh::Mesh;
use common::settings::{Transport, Visibility};
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
    /// The buffers and item buffers by the shaders' names: `sums` over samples of slots × texels, `transfers` to each
    /// patch of one shot or of every patch.
    pub table: BindingTable,
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
        let (slots, texels) = (u64::from(count), mesh.texels.len() as u64);
        let patches = mesh.patches.len() as u64;
        let behind_end = gpu.elements_behind_end() as u64;
        let drawing = transport.visibility.item_buffer();
        let size = drawing.map_or(0, |drawing| drawing.size);
        let links = texels * slots;
        let (step, tiles, pixels) = if drawing.is_some() {
            // Every sample draws its own item buffer; together they are a square, or a row less.
            let tiles = count.saturating_sub(1).isqrt() + 1;
            (1, tiles, [tiles, count.div_ceil(tiles)].map(|n| n * size))
        } else {
            // For checks more than one dispatch, of which the last may add fewer samples.
            let most = if gpu.is_for_checks() {
                mesh.samples.div_ceil(2)
            } else {
                mesh.samples
            };
            let step = (MAX_DISPATCH_RAYS / links.max(1)).clamp(1, most.into());
            // A texture has at least a pixel.
            (step as u32, 1, [1, 1])
        };
        let ids = |label| render_target(device, label, pixels, wgpu::TextureFormat::R32Uint);
        let item_buffer = ids("item buffer");
        let depth = render_target(device, "depth", pixels, wgpu::TextureFormat::Depth32Float);
        let relit = mesh.room_faces < mesh.faces.len() as u32;
        let room_buffer = relit.then(|| ids("room buffer").create_view(&Default::default()));
        let view = item_buffer.create_view(&Default::default());
        let zeroed = [
            ("params", size_of::<ShaderParams>() as u64, UNIFORM),
            ("shots", SHOT_BYTES * slots, STORAGE),
            ("sums", 16 * links, STORAGE),
            ("transfers", 4 * (patches * u64::from(rows) + behind_end), STORAGE),
            ("rectangles", 16, STORAGE | Usage::INDIRECT),
        ];
        let mut table = BindingTable::zeroed(device, zeroed);
        table.add_texture("with_objects", view.clone());
        // Without objects both bindings are the same texture.
        table.add_texture("without_objects", room_buffer.clone().unwrap_or_else(|| view.clone()));
        Self {
            table,
            view,
            room_buffer,
            depth: depth.create_view(&Default::default()),
            item_buffer,
            count,
            tiles,
            size,
            sides: drawing.map_or(0, |drawing| drawing.projection.plane_count()),
            step,
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
    let side = u64::from(drawing.size.max(1));
    let across = u64::from(gpu.device.limits().max_texture_dimension_2d) / side;
    most.min(bytes / (PIXEL_BYTES * side * side))
        .min(across * across)
        .max(1) as u32
}
