//! The item buffer by tessellation: the ID of the nearest face in every pixel, faces drawn as triangles.
//! Shader and rasteriser in one.
//!
//! Depth is the distance along the pixel's own ray to the face's plane, so that tessellation
//! moves outlines only. `paper` keeps the planar depth of Table 3, which clips at half a unit.

use crate::shader_twins::edge_subdivision::subdivide_edge;
use crate::shader_twins::projection::{pixel_centre, pixel_position, project_direction, unproject_point};
use crate::shader_twins::tessellate::tessellate;
use crate::shader_twins::view::{ItemBufferTarget, ShooterView};
use common::constants::{DEPTH_SCALE, MAX_DEPTH, MIN_ELEVATION_SINE, PAPER_FAR_PLANE, PAPER_NEAR_PLANE};
use common::mesh::MeshFace;
use common::settings::ItemBufferProjection;
use glam::Vec2;

/// Steps per pixel to which rasterisers snap vertices.
const SUBPIXEL_STEPS: f32 = 256.0;

/// Draws all faces: coarse ones first, each level in face order.
pub fn draw_tessellated(faces: &[MeshFace], view: &ShooterView, target: &mut ItemBufferTarget) {
    let mut raster = TriangleRaster { view, target };
    for (level, list) in tessellate(view, faces).iter().enumerate() {
        for k in list {
            raster.draw_face(*k, &faces[*k as usize], 1 << level);
        }
    }
}

/// A projected vertex.
#[derive(Clone, Copy)]
struct ProjectedVertex {
    /// Position in pixels.
    pixel: Vec2,
    /// Sine of the elevation above the shooter's horizon.
    elevation: f32,
    /// Table 3's depth, moved from −1…1 to 0…1.
    depth: f32,
}

struct TriangleRaster<'a> {
    view: &'a ShooterView,
    target: &'a mut ItemBufferTarget,
}

impl TriangleRaster<'_> {
    fn draw_face(&mut self, id: u32, face: &MeshFace, parts: u32) {
        let at = |i: u32, j: u32| vertex(self.view, face, i as f32 / parts as f32, j as f32 / parts as f32);
        for j in 0..parts {
            for i in 0..parts {
                let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
                self.draw_triangle(id, face, [a, b, c]);
                self.draw_triangle(id, face, [a, c, d]);
            }
        }
    }

    /// Draws every pixel whose centre lies inside; on an edge by the top-left rule.
    fn draw_triangle(&mut self, id: u32, face: &MeshFace, mut v: [ProjectedVertex; 3]) {
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
                    let mix = |f: fn(&ProjectedVertex) -> f32| f(&v[0]) * a + f(&v[1]) * b + f(&v[2]) * c;
                    let (x, y) = (x as u32, y as u32);
                    let (elevation, planar) = (mix(|v| v.elevation), mix(|v| v.depth));
                    if let Some(depth) = fragment(self.view, face, x, y, elevation, planar) {
                        self.target.draw_pixel(id, x, y, depth);
                    }
                }
            }
        }
    }
}

/// Returns the vertex at (u, v) of a face.
fn vertex(view: &ShooterView, face: &MeshFace, u: f32, v: f32) -> ProjectedVertex {
    let [a, b, c, d] = face.corners.map(|corner| corner - view.frame.centre);
    let s = subdivide_edge(a, b, u) * (1.0 - v) + subdivide_edge(d, c, u) * v;
    let t = subdivide_edge(a, d, v) * (1.0 - u) + subdivide_edge(b, c, v) * u;
    let low = a * (1.0 - s) + b * s;
    let high = d * (1.0 - s) + c * s;
    // Table 3, line 3; lines 4 to 6 are `project_direction`; line 7, where v.z is negative in front, is `printed`.
    let local = view.frame.rotate_to_local(low * (1.0 - t) + high * t);
    let z = local.z * view.unit;
    let printed = (2.0 * z * PAPER_FAR_PLANE - PAPER_NEAR_PLANE) / (PAPER_FAR_PLANE - PAPER_NEAR_PLANE);
    ProjectedVertex {
        pixel: pixel_position(project_direction(view.projection, local), view.size),
        elevation: local.z / local.dot(local).sqrt(),
        depth: printed * 0.5 + 0.5,
    }
}

/// Returns the depth of `face` in a pixel; none where it is not drawn.
fn fragment(view: &ShooterView, face: &MeshFace, x: u32, y: u32, elevation: f32, planar: f32) -> Option<f32> {
    let p = pixel_centre(x, y, view.size);
    if p.x * p.x + p.y * p.y > 1.0 {
        return None;
    }
    if view.projection == ItemBufferProjection::Paper {
        return (0.0..=1.0).contains(&planar).then_some(planar);
    }
    if elevation < MIN_ELEVATION_SINE {
        return None;
    }
    let direction = view.frame.to_world(unproject_point(view.projection, p));
    let facing = face.normal.dot(direction);
    let t = face.normal.dot(face.corners[0] - view.frame.centre) / facing;
    if facing == 0.0 || t <= 0.0 {
        return None;
    }
    Some((t * DEPTH_SCALE).min(MAX_DEPTH))
}
