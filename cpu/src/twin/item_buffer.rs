//! The item buffer: the ID of the nearest face in every pixel of a shooter's hemisphere, by the
//! pixel's own ray. Twin of `gpu/src/shaders/item_buffer.wgsl`.
//!
//! A rectangle that holds the image of the face is drawn, and each pixel in it asks whether its
//! ray meets the face; depth is the distance along that ray. So the buffer holds what rays see, and
//! the only error left is the size of a pixel. The older way is `item_buffer_tessellated.rs`.

use crate::twin::bound::bound;
use crate::twin::hemicube::place;
use crate::twin::item_buffer_tessellated::draw_tessellated;
use crate::twin::projection::{Frame, covered, pixel_centre, pixels, unproject};
use common::constants::{DEPTH_MAX, DEPTH_SCALE, OUTLINE};
use common::intersect::intersect;
use common::mesh::{Mesh, MeshFace};
use common::settings::{Raster, Settings, Visibility};
use glam::Vec2;

/// Face IDs + 1, row-major; 0 where nothing was drawn.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ItemBuffer {
    /// Pixels per side.
    pub size: u32,
    /// One per pixel.
    pub ids: Vec<u32>,
}

/// What a raster pass needs beside the faces.
#[derive(Clone, Copy, Debug)]
pub struct View {
    /// The projection.
    pub visibility: Visibility,
    /// How faces are drawn.
    pub raster: Raster,
    /// The shooter's frame.
    pub frame: Frame,
    /// The shooter's sheet: not drawn.
    pub sheet: u32,
    /// Pixels per side.
    pub size: u32,
    /// Scene units per mesh unit (Table 3's planes are in scene units).
    pub unit: f32,
}

impl View {
    /// The view from point `s` of a cell.
    pub fn new(mesh: &Mesh, cell: u32, s: u32, settings: &Settings) -> Self {
        let face = &mesh.faces[mesh.cells[cell as usize].face as usize];
        let point = mesh.points[(cell * mesh.samples + s) as usize];
        Self {
            visibility: settings.visibility,
            raster: settings.raster(),
            frame: Frame::new(face, point.position),
            sheet: face.sheet,
            size: settings.item_buffer,
            unit: mesh.unit as f32,
        }
    }
}

impl ItemBuffer {
    /// Draws the first `faces` faces (Table 1, line 3); the first of equals stays.
    pub fn draw(mesh: &Mesh, view: &View, faces: u32) -> Self {
        let faces = &mesh.faces[..faces as usize];
        let count = (view.size * view.size) as usize;
        let mut target = Target {
            size: view.size,
            ids: vec![0; count],
            depth: vec![1.0; count],
        };
        match view.raster {
            Raster::Pixel => draw_pixels(faces, view, &mut target),
            Raster::Tessellated => draw_tessellated(faces, view, &mut target),
        }
        Self {
            size: view.size,
            ids: target.ids,
        }
    }
}

/// IDs and depths under way.
pub struct Target {
    size: u32,
    ids: Vec<u32>,
    depth: Vec<f32>,
}

impl Target {
    /// Face `id` in pixel (x, y), if it is the nearest there so far.
    pub fn write(&mut self, id: u32, x: u32, y: u32, depth: f32) {
        let pixel = (y * self.size + x) as usize;
        if depth < self.depth[pixel] {
            self.depth[pixel] = depth;
            self.ids[pixel] = id + 1;
        }
    }
}

fn draw_pixels(faces: &[MeshFace], view: &View, target: &mut Target) {
    for (id, face) in faces.iter().enumerate() {
        for side in 0..view.visibility.sides() {
            let limits = bound(view, face, side);
            if limits.x >= limits.z || limits.y >= limits.w {
                continue;
            }
            let p = pixels(place(side, Vec2::new(limits.x, limits.y)), view.size);
            let q = pixels(place(side, Vec2::new(limits.z, limits.w)), view.size);
            for y in centres(p.y, q.y, view.size) {
                for x in centres(p.x, q.x, view.size) {
                    if let Some(depth) = fragment(view, face, x, y) {
                        target.write(id as u32, x, y, depth);
                    }
                }
            }
        }
    }
}

/// The pixels whose centres lie between `a` and `b`.
fn centres(a: f32, b: f32, size: u32) -> std::ops::Range<u32> {
    let first = (a.min(b) - 0.5).ceil().max(0.0) as u32;
    let end = (a.max(b) - 0.5).floor() + 1.0;
    first..(end as u32).min(size)
}

/// The depth of `face` in a pixel; none where the pixel's ray misses it.
pub fn fragment(view: &View, face: &MeshFace, x: u32, y: u32) -> Option<f32> {
    let p = pixel_centre(x, y, view.size);
    if !covered(view.visibility, p, view.size) {
        return None;
    }
    let direction = view.frame.world(unproject(view.visibility, p));
    let hit = intersect(face, view.frame.centre, direction);
    if hit.t <= 0.0 || hit.inside < -OUTLINE {
        return None;
    }
    Some((hit.t * DEPTH_SCALE).min(DEPTH_MAX))
}
