//! The item buffer by tessellation: the ID of the nearest face in every pixel, faces drawn as
//! triangles. Twin of `gpu/src/shaders/item_buffer_tessellated.wgsl` and of the rasteriser that
//! runs it.
//!
//! Depth is the distance along the pixel's own ray to the face's plane, so that tessellation
//! moves outlines only. `paper` keeps the planar depth of Table 3, which clips at half a unit.

use crate::twin::projection::{pixel_centre, pixels, project, unproject};
use crate::twin::tessellate::{level, spread};
use crate::twin::view::{Target, View};
use common::constants::{BELOW, DEPTH_MAX, DEPTH_SCALE, HIDDEN, LEVELS, PAPER_FAR, PAPER_NEAR};
use common::mesh::MeshFace;
use common::settings::Projection;
use glam::Vec2;

/// Steps per pixel to which rasterisers snap vertices.
const SUBPIXELS: f32 = 256.0;

/// Draws all faces: coarse ones first, each level in face order.
pub fn draw_tessellated(faces: &[MeshFace], view: &View, target: &mut Target) {
    let mut raster = Raster { view, target };
    let levels: Vec<u32> = faces.iter().map(|face| level(view, face)).collect();
    for wanted in 0..LEVELS {
        for (k, face) in faces.iter().enumerate() {
            debug_assert!(levels[k] <= HIDDEN);
            if levels[k] == wanted {
                raster.draw_face(k as u32, face, 1 << wanted);
            }
        }
    }
}

/// A projected vertex.
#[derive(Clone, Copy)]
struct Vertex {
    /// Position in pixels.
    pixel: Vec2,
    /// Sine of the elevation above the shooter's horizon.
    elevation: f32,
    /// Table 3's depth, moved from −1…1 to 0…1.
    depth: f32,
}

struct Raster<'a> {
    view: &'a View,
    target: &'a mut Target,
}

impl Raster<'_> {
    fn draw_face(&mut self, id: u32, face: &MeshFace, parts: u32) {
        let at = |i: u32, j: u32| {
            vertex(
                self.view,
                face,
                i as f32 / parts as f32,
                j as f32 / parts as f32,
            )
        };
        for j in 0..parts {
            for i in 0..parts {
                let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
                self.draw_triangle(id, face, [a, b, c]);
                self.draw_triangle(id, face, [a, c, d]);
            }
        }
    }

    /// Every pixel whose centre lies inside; on an edge by the top-left rule.
    fn draw_triangle(&mut self, id: u32, face: &MeshFace, mut v: [Vertex; 3]) {
        let snap = |v: &Vertex| {
            let p = (v.pixel * SUBPIXELS).round();
            [p.x as i64, p.y as i64]
        };
        let edge = |a: [i64; 2], b: [i64; 2], p: [i64; 2]| {
            (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])
        };
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
        let step = SUBPIXELS as i64;
        let last = i64::from(self.view.size) - 1;
        let range = |axis: usize| {
            let low = s
                .iter()
                .map(|p| p[axis])
                .min()
                .unwrap_or(0)
                .div_euclid(step);
            let high = s
                .iter()
                .map(|p| p[axis])
                .max()
                .unwrap_or(0)
                .div_euclid(step);
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
                    let mix = |f: fn(&Vertex) -> f32| f(&v[0]) * a + f(&v[1]) * b + f(&v[2]) * c;
                    let (x, y) = (x as u32, y as u32);
                    let (elevation, planar) = (mix(|v| v.elevation), mix(|v| v.depth));
                    if let Some(depth) = fragment(self.view, face, x, y, elevation, planar) {
                        self.target.write(id, x, y, depth);
                    }
                }
            }
        }
    }
}

/// The vertex at (u, v) of a face.
fn vertex(view: &View, face: &MeshFace, u: f32, v: f32) -> Vertex {
    let [a, b, c, d] = face.corners.map(|corner| corner - view.frame.centre);
    let s = spread(a, b, u) * (1.0 - v) + spread(d, c, u) * v;
    let t = spread(a, d, v) * (1.0 - u) + spread(b, c, v) * u;
    let low = a * (1.0 - s) + b * s;
    let high = d * (1.0 - s) + c * s;
    // Table 3, line 3; lines 4 to 6 are `project`; line 7, where v.z is negative in front, is `printed`.
    let local = view.frame.turn(low * (1.0 - t) + high * t);
    let z = local.z * view.unit;
    let printed = (2.0 * z * PAPER_FAR - PAPER_NEAR) / (PAPER_FAR - PAPER_NEAR);
    Vertex {
        pixel: pixels(project(view.projection, local), view.size),
        elevation: local.z / local.dot(local).sqrt(),
        depth: printed * 0.5 + 0.5,
    }
}

/// The depth of `face` in a pixel; none where it is not drawn.
fn fragment(
    view: &View,
    face: &MeshFace,
    x: u32,
    y: u32,
    elevation: f32,
    planar: f32,
) -> Option<f32> {
    let p = pixel_centre(x, y, view.size);
    if p.x * p.x + p.y * p.y > 1.0 {
        return None;
    }
    if view.projection == Projection::Paper {
        return (0.0..=1.0).contains(&planar).then_some(planar);
    }
    if elevation < BELOW {
        return None;
    }
    let direction = view.frame.to_world(unproject(view.projection, p));
    let facing = face.normal.dot(direction);
    let t = face.normal.dot(face.corners[0] - view.frame.centre) / facing;
    if facing == 0.0 || t <= 0.0 {
        return None;
    }
    Some((t * DEPTH_SCALE).min(DEPTH_MAX))
}
