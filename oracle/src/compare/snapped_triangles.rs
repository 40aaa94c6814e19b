//! What the pixels of the paper's item buffer can show: a rasteriser snaps vertices to a grid, and each has its own.

use common::mesh::{Mesh, MeshFace};
use cpu::shader_twins::image_bound::is_hidden_face;
use cpu::shader_twins::item_buffer_paper::{ProjectedVertex, draw_vertex};
use cpu::shader_twins::projection::{is_covered, pixel_centre};
use cpu::shader_twins::view::ShooterView;
use glam::DVec2;
use std::f64::consts::SQRT_2;

/// Distance in pixels by which a vertex may move: across a cell of the coarsest grid that Vulkan allows, of four bits.
const MAX_VERTEX_SHIFT: f64 = SQRT_2 / 16.0;
/// Altitudes below so many shifts make a sliver: its depths in a pixel are between those of its vertices, and it may vanish.
const SLIVER_SHIFTS: f64 = 4.0;
/// Change of the depth's gradient by such shifts of vertices, in triangles that are no slivers: by a quarter of an altitude at
/// either side.
const GRADIENT_FACTOR: f64 = 2.0;
/// Roundings by which an adapter's depth may differ, of the size of the vertices' depths.
const DEPTH_ROUNDINGS: f64 = 32.0 * f32::EPSILON as f64;

/// Depths that a triangle may have in a pixel.
struct PossibleDepths {
    nearest: f64,
    farthest: f64,
    /// True if the pixel is inside of the triangle and of the depth's range however the vertices are snapped.
    certain: bool,
}

/// True if the pixel `k` may show face `id` − 1, or nothing for 0, however the vertices are snapped.
pub fn may_show(mesh: &Mesh, view: &ShooterView, k: u32, id: u32) -> bool {
    let (x, y) = (k % view.size, k / view.size);
    if !is_covered(view.projection, pixel_centre(x, y, view.size), view.size) {
        return id == 0;
    }
    let pixel = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
    let (mut own, mut nearest) = (f64::INFINITY, f64::INFINITY);
    for (face, number) in mesh.faces.iter().zip(1..) {
        for depths in face_depths(view, face, pixel) {
            if number == id {
                own = own.min(depths.nearest);
            }
            if depths.certain {
                nearest = nearest.min(depths.farthest);
            }
        }
    }
    match id {
        0 => nearest == f64::INFINITY,
        _ => own < f64::INFINITY && own <= nearest,
    }
}

/// Iterates over the depths that the two triangles of a face may have in a pixel.
fn face_depths(view: &ShooterView, face: &MeshFace, pixel: DVec2) -> impl Iterator<Item = PossibleDepths> {
    let triangles = match is_hidden_face(view, face) {
        true => Vec::new(),
        false => {
            let [a, b, c, d] = [0, 1, 2, 3].map(|corner| draw_vertex(view, face, corner));
            vec![[a, b, c], [a, c, d]]
        }
    };
    (triangles.into_iter()).filter_map(move |triangle| triangle_depths(&triangle, pixel))
}

/// Returns the depths that a triangle may have in a pixel; none if it is not there.
fn triangle_depths(triangle: &[ProjectedVertex; 3], pixel: DVec2) -> Option<PossibleDepths> {
    let corners = triangle.map(|vertex| vertex.pixel.as_dvec2());
    let depths = triangle.map(|vertex| f64::from(vertex.depth));
    let double_area = (corners[1] - corners[0]).perp_dot(corners[2] - corners[0]);
    let sign = if double_area < 0.0 { -1.0 } else { 1.0 };
    let (mut inside, mut altitude) = (f64::INFINITY, f64::INFINITY);
    let (mut depth, mut gradient) = (0.0, DVec2::ZERO);
    for k in 0..3 {
        let (a, b) = (corners[(k + 1) % 3], corners[(k + 2) % 3]);
        let edge = b - a;
        let inward = edge.perp() * sign;
        inside = inside.min((pixel - a).dot(inward) / inward.length());
        altitude = altitude.min(double_area.abs() / inward.length());
        depth += depths[k] * (pixel - a).dot(inward) / double_area.abs();
        gradient += inward * (depths[k] / double_area.abs());
    }
    let is_sliver = altitude.is_nan() || altitude < SLIVER_SHIFTS * MAX_VERTEX_SHIFT;
    if inside < -MAX_VERTEX_SHIFT {
        return None;
    }
    let rounding = DEPTH_ROUNDINGS * depths.iter().fold(1.0, |size: f64, depth| size.max(depth.abs()));
    let spread = GRADIENT_FACTOR * gradient.length() * MAX_VERTEX_SHIFT + rounding;
    let [nearest, farthest] = match is_sliver {
        true => [
            depths.into_iter().fold(f64::INFINITY, f64::min) - rounding,
            depths.into_iter().fold(f64::NEG_INFINITY, f64::max) + rounding,
        ],
        false => [depth - spread, depth + spread],
    };
    let certain = !is_sliver && inside >= MAX_VERTEX_SHIFT && nearest >= 0.0 && farthest <= 1.0;
    (nearest <= 1.0 && farthest >= 0.0).then_some(PossibleDepths {
        nearest: nearest.max(0.0),
        farthest,
        certain,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec2;

    fn triangle(depth: f32) -> [ProjectedVertex; 3] {
        [[0.0, 0.0], [8.0, 0.0], [0.0, 8.0]].map(|[x, y]| ProjectedVertex {
            pixel: Vec2::new(x, y),
            depth: depth + 0.01 * x,
        })
    }

    #[test]
    fn triangle_is_certain_inside_possible_at_its_edge_and_absent_outside() {
        for turned in [false, true] {
            let mut corners = triangle(0.5);
            if turned {
                corners.swap(1, 2);
            }
            let at = |x: f64, y: f64| triangle_depths(&corners, DVec2::new(x, y));
            let inside = at(2.0, 2.0).unwrap();
            assert!(inside.certain && inside.nearest < 0.52 && 0.52 < inside.farthest);
            assert!(inside.farthest - inside.nearest < 0.01);
            assert!(!at(0.05, 2.0).unwrap().certain && !at(-0.05, 2.0).unwrap().certain);
            assert!(at(-0.2, 2.0).is_none() && at(6.0, 6.0).is_none());
        }
    }

    #[test]
    fn depth_outside_of_its_range_is_clipped() {
        let at = |depth: f32| triangle_depths(&triangle(depth), DVec2::new(2.0, 2.0));
        assert!(at(-0.1).is_none() && at(1.1).is_none());
        assert!(!at(-0.02).unwrap().certain && at(0.1).unwrap().certain);
    }

    #[test]
    fn sliver_may_vanish() {
        let corners = [[0.0, 0.0], [8.0, 0.0], [8.0, 0.1]].map(|[x, y]| ProjectedVertex {
            pixel: Vec2::new(x, y),
            depth: 0.5,
        });
        let found = triangle_depths(&corners, DVec2::new(7.0, 0.04)).unwrap();
        assert!(!found.certain && found.nearest < 0.5 && 0.5 < found.farthest);
    }
}
