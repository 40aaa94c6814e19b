//! The item buffer: the ID of the nearest face in every pixel of a shooter's hemisphere, by the
//! pixel's own ray.
//!
//! A rectangle that holds the image of the face is drawn, and each of its pixels intersects its own ray with
//! the face; depth is the distance along that ray. The only error is the size of a pixel.
//! `item_buffer_paper.rs` draws faces as Table 3 prints it.

use crate::shader_twins::hemicube::unfold_side;
use crate::shader_twins::image_bound::image_bound;
use crate::shader_twins::item_buffer_paper::draw_triangles;
use crate::shader_twins::projection::{is_covered, pixel_centre, pixel_position, unproject_point};
use crate::shader_twins::view::{ItemBufferTarget, ShooterView, select_faces};
use common::constants::{DEPTH_SCALE, MAX_DEPTH, OUTLINE_MARGIN};
use common::intersect::intersect_face;
use common::mesh::{Mesh, MeshFace};
use common::settings::ItemBufferProjection;
use glam::{Vec2, Vec4};

/// Face IDs + 1, row-major; 0 where no face was drawn.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ItemBuffer {
    /// Pixels per side.
    pub size: u32,
    /// One per pixel.
    pub ids: Vec<u32>,
}

impl ItemBuffer {
    /// Draws the first `faces` faces (Table 1, line 3); the first of equals stays.
    pub fn draw_faces(mesh: &Mesh, view: &ShooterView, faces: u32) -> Self {
        let faces = select_faces(mesh, faces);
        let mut target = ItemBufferTarget::new(view.size);
        match view.projection {
            ItemBufferProjection::Paper => draw_triangles(faces, view, &mut target),
            _ => draw_pixels(faces, view, &mut target),
        }
        Self {
            size: view.size,
            ids: target.ids,
        }
    }
}

fn draw_pixels(faces: &[MeshFace], view: &ShooterView, target: &mut ItemBufferTarget) {
    for (id, face) in faces.iter().enumerate() {
        for side in 0..view.projection.plane_count() {
            let limits = image_bound(view, face, side);
            if limits.x >= limits.z || limits.y >= limits.w {
                continue;
            }
            let p = pixel_position(draw_vertex(limits, side, 0), view.size);
            let q = pixel_position(draw_vertex(limits, side, 3), view.size);
            for y in pixel_range(p.y, q.y, view.size) {
                for x in pixel_range(p.x, q.x, view.size) {
                    if let Some(depth) = draw_fragment(view, face, x, y) {
                        target.draw_pixel(id as u32, x, y, depth);
                    }
                }
            }
        }
    }
}

/// Returns the pixels whose centres lie between `a` and `b`.
fn pixel_range(a: f32, b: f32, size: u32) -> std::ops::Range<u32> {
    let first = (a.min(b) - 0.5).ceil().max(0.0) as u32;
    let end = (a.max(b) - 0.5).floor() + 1.0;
    first..(end as u32).min(size)
}

/// Returns corner `index` of the rectangle `limits` on a side: lower left 0, lower right 1, upper left 2, upper
/// right 3.
fn draw_vertex(limits: Vec4, side: u32, index: u32) -> Vec2 {
    let x = if index & 1 == 1 { limits.z } else { limits.x };
    let y = if index & 2 == 2 { limits.w } else { limits.y };
    unfold_side(side, Vec2::new(x, y))
}

/// Returns the depth of `face` in a pixel; none where the pixel's ray misses it.
pub fn draw_fragment(view: &ShooterView, face: &MeshFace, x: u32, y: u32) -> Option<f32> {
    let p = pixel_centre(x, y, view.size);
    if !is_covered(view.projection, p, view.size) {
        return None;
    }
    let direction = view.frame.to_world(unproject_point(view.projection, p));
    let hit = intersect_face(face, view.frame.centre, direction);
    if hit.t <= 0.0 || hit.inside < -OUTLINE_MARGIN {
        return None;
    }
    Some((hit.t * DEPTH_SCALE).min(MAX_DEPTH))
}
