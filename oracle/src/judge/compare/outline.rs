//! Where the true outlines of faces lie in the item buffer.

use common::constants::LEVELS;
use common::mesh::Mesh;
use cpu::twin::projection::{pixels, project};
use cpu::twin::tessellate::spread;
use cpu::twin::view::View;
use glam::Vec2;

/// Distance from `p` to the nearest true outline of `faces`, if it is within 2 pixels.
pub fn outline(mesh: &Mesh, view: &View, p: Vec2, faces: &[u32]) -> Option<f32> {
    let parts = 1u32 << (LEVELS - 1);
    let mut nearest = f32::INFINITY;
    for face in faces {
        let corners = mesh.faces[*face as usize]
            .corners
            .map(|c| c - view.frame.centre);
        for k in 0..4 {
            let (a, b) = (corners[k], corners[(k + 1) % 4]);
            let at = |i: u32| {
                let t = spread(a, b, i as f32 / parts as f32);
                let v = view.frame.turn(a * (1.0 - t) + b * t);
                pixels(project(view.projection, v), view.size)
            };
            for i in 0..parts {
                let (start, end) = (at(i), at(i + 1));
                // A longer part leaps from one side of the hemicube to another.
                if start.distance(end) < view.size as f32 / 16.0 {
                    nearest = nearest.min(segment_distance(p, start, end));
                }
            }
        }
    }
    (nearest <= 2.0).then_some(nearest)
}

fn segment_distance(p: Vec2, a: Vec2, b: Vec2) -> f32 {
    let along = b - a;
    let t = ((p - a).dot(along) / along.length_squared().max(1e-12)).clamp(0.0, 1.0);
    p.distance(a + along * t)
}
