//! The item buffer: the ID of the nearest face in every pixel of a shooter's hemisphere, by the
//! pixel's own ray. Twin of `gpu/src/shaders/item_buffer.wgsl`.
//!
//! A rectangle that holds the image of the face is drawn, and each pixel in it asks whether its
//! ray meets the face; depth is the distance along that ray. So the buffer holds what rays see, and
//! the only error left is the size of a pixel. The older way is `item_buffer_tessellated.rs`.

use crate::twin::bound::bound;
use crate::twin::hemicube::place;
use crate::twin::item_buffer_tessellated::draw_tessellated;
use crate::twin::projection::{covered, pixel_centre, pixels, unproject};
use crate::twin::view::{Target, View};
use common::constants::{DEPTH_MAX, DEPTH_SCALE, OUTLINE};
use common::intersect::intersect;
use common::mesh::{Mesh, MeshFace};
use common::settings::Raster;
use glam::Vec2;

/// Face IDs + 1, row-major; 0 where nothing was drawn.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ItemBuffer {
    /// Pixels per side.
    pub size: u32,
    /// One per pixel.
    pub ids: Vec<u32>,
}

impl ItemBuffer {
    /// Draws the first `faces` faces (Table 1, line 3); the first of equals stays.
    pub fn draw(mesh: &Mesh, view: &View, faces: u32) -> Self {
        let faces = &mesh.faces[..faces as usize];
        let mut target = Target::new(view.size);
        match view.projection.raster() {
            Raster::Pixel => draw_pixels(faces, view, &mut target),
            Raster::Tessellated => draw_tessellated(faces, view, &mut target),
        }
        Self {
            size: view.size,
            ids: target.ids,
        }
    }
}

fn draw_pixels(faces: &[MeshFace], view: &View, target: &mut Target) {
    for (id, face) in faces.iter().enumerate() {
        for side in 0..view.projection.sides() {
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
    if !covered(view.projection, p, view.size) {
        return None;
    }
    let direction = view.frame.to_world(unproject(view.projection, p));
    let hit = intersect(face, view.frame.centre, direction);
    if hit.t <= 0.0 || hit.inside < -OUTLINE {
        return None;
    }
    Some((hit.t * DEPTH_SCALE).min(DEPTH_MAX))
}
