//! The item buffer as Table 3 prints it: only the corners of faces are projected, edges are straight on the disc, and
//! planar depth clips at half a unit. Shader and rasteriser in one.

use crate::shader_twins::image_bound::is_hidden_face;
use crate::shader_twins::projection::{is_covered, pixel_centre, pixel_position, project_direction};
use crate::shader_twins::view::{ItemBufferTarget, ShooterView};
use common::constants::{PAPER_FAR_PLANE, PAPER_NEAR_PLANE};
use common::mesh::MeshFace;
use glam::Vec2;

/// Steps per pixel to which rasterisers snap vertices.
const SUBPIXEL_STEPS: f32 = 256.0;

/// Draws two triangles for each face, in face order.
pub fn draw_triangles(faces: &[MeshFace], view: &ShooterView, target: &mut ItemBufferTarget) {
    let mut raster = TriangleRaster { view, target };
    for (id, face) in (0..).zip(faces).filter(|(_, face)| !is_hidden_face(view, face)) {
        let [a, b, c, d] = [0, 1, 2, 3].map(|corner| draw_vertex(view, face, corner));
        raster.draw_triangle(id, [a, b, c]);
        raster.draw_triangle(id, [a, c, d]);
    }
}

/// A projected vertex.
#[derive(Clone, Copy)]
pub struct ProjectedVertex {
    /// Position in pixels.
    pub pixel: Vec2,
    /// Table 3's depth, moved from −1…1 to 0…1.
    pub depth: f32,
}

struct TriangleRaster<'a> {
    view: &'a ShooterView,
    target: &'a mut ItemBufferTarget,
}

impl TriangleRaster<'_> {
    /// Draws every pixel whose centre lies inside; on an edge by the top-left rule.
    fn draw_triangle(&mut self, id: u32, mut v: [ProjectedVertex; 3]) {
        let snap = |v: &ProjectedVertex| {
            let p = (v.pixel * SUBPIXEL_STEPS).round();
            [p.x as i64, p.y as i64]
        };
        let edge =
            |a: [i64; 2], b: [i64; 2], p: [i64; 2]| (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]);
        let mut s = [snap(&v[0]), snap(&v[1]), snap(&v[2])];
        let mut area = edge(s[0], s[1], s[2]);
        if area == 0 {
            return;
        }
        if area < 0 {
            v.swap(1, 2);
            s.swap(1, 2);
            area = -area;
        }
        let step = SUBPIXEL_STEPS as i64;
        let last = i64::from(self.view.size) - 1;
        let range = |axis: usize| {
            let low = s.iter().map(|p| p[axis]).min().unwrap_or(0).div_euclid(step);
            let high = s.iter().map(|p| p[axis]).max().unwrap_or(0).div_euclid(step);
            low.clamp(0, last + 1)..=high.clamp(-1, last)
        };
        let top_left = |a: [i64; 2], b: [i64; 2]| b[1] < a[1] || (b[1] == a[1] && b[0] > a[0]);
        for y in range(1) {
            for x in range(0) {
                let p = [x * step + step / 2, y * step + step / 2];
                let inside = |k: usize| {
                    let (a, b) = (s[(k + 1) % 3], s[(k + 2) % 3]);
                    let e = edge(a, b, p);
                    (e > 0 || (e == 0 && top_left(a, b))).then_some(e as f32 / area as f32)
                };
                if let (Some(a), Some(b), Some(c)) = (inside(0), inside(1), inside(2)) {
                    let planar = v[0].depth * a + v[1].depth * b + v[2].depth * c;
                    let (x, y) = (x as u32, y as u32);
                    if let Some(depth) = draw_fragment(self.view, x, y, planar) {
                        self.target.draw_pixel(id, x, y, depth);
                    }
                }
            }
        }
    }
}

/// Returns a corner of a face as a vertex.
pub fn draw_vertex(view: &ShooterView, face: &MeshFace, corner: usize) -> ProjectedVertex {
    // Table 3, line 3; lines 4 to 6 are `project_direction`; line 7, where v.z is negative in front, is `printed`.
    let local = view.frame.to_local(face.corners[corner]);
    let z = local.z * view.unit;
    let printed = (2.0 * z * PAPER_FAR_PLANE - PAPER_NEAR_PLANE) / (PAPER_FAR_PLANE - PAPER_NEAR_PLANE);
    ProjectedVertex {
        pixel: pixel_position(project_direction(view.projection, local), view.size),
        depth: printed * 0.5 + 0.5,
    }
}

/// Returns the depth in a pixel; none where nothing is drawn.
fn draw_fragment(view: &ShooterView, x: u32, y: u32, planar: f32) -> Option<f32> {
    let shown = is_covered(view.projection, pixel_centre(x, y, view.size), view.size);
    (shown && (0.0..=1.0).contains(&planar)).then_some(planar)
}
