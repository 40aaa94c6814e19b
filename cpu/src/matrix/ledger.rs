//! Where the power went, as the log of shots that the energy balance reads: each texel shoots once
//! what leaves it in the end.
//!
//! The open part of a texel shoots A(o∘E + ρ∘H); of that ΣF arrives, and the share of its cosine
//! hemisphere that meets no front escapes. What its covered part emits is lost behind the body that
//! stands on it.

use super::open::Element;
use super::{Answer, Matrix};
use crate::twin::escape::meets_front;
use common::escape::{DIRECTIONS, directions};
use common::mesh::Mesh;
use common::rays::Rays;
use common::shooting::Shot;
use glam::DVec3;
use rayon::prelude::*;
use std::f32::consts::TAU;

/// The escaped share of each element's open part: one ray in each of the fixed directions, turned
/// by an angle of its own so that neighbours do not err alike, from points all over the open part.
pub fn escaped_shares(mesh: &Mesh, rays: &Rays, elements: &[Element]) -> Vec<f64> {
    let directions = directions();
    elements
        .par_iter()
        .enumerate()
        .map(|(k, element)| {
            if element.patches.is_empty() {
                return 0.0;
            }
            let face = &mesh.faces[element.face as usize];
            let (s, c) = (sequence(k, 0.618_033_988_749_895) as f32 * TAU).sin_cos();
            let tangent = face.tangent * c + face.normal.cross(face.tangent) * s;
            let bitangent = face.normal.cross(tangent);
            let lost = directions
                .iter()
                .enumerate()
                .filter(|(n, d)| {
                    let (u, v) = (
                        sequence(k + n, 0.754_877_666_246_693),
                        sequence(k + n, 0.569_840_290_998_053),
                    );
                    let origin = point(element, u, v).as_vec3();
                    let direction = tangent * d.x + bitangent * d.y + face.normal * d.z;
                    !meets_front(rays, face.sheet, origin, direction)
                })
                .count();
            lost as f64 / DIRECTIONS as f64
        })
        .collect()
}

fn sequence(k: usize, alpha: f64) -> f64 {
    (0.5 + alpha * k as f64).fract()
}

/// The point of the open part at (u, v) of the unit square, equal areas to equal areas.
fn point(element: &Element, u: f64, v: f64) -> DVec3 {
    let open: f64 = element.patches.iter().map(|patch| patch.area).sum();
    let mut left = u * open;
    let mut last = element.patches[0].centre;
    for patch in &element.patches {
        let c = patch.polygon.corners();
        for k in 1..c.len().saturating_sub(1) {
            let (along, across) = (c[k] - c[0], c[k + 1] - c[0]);
            let area = 0.5 * along.cross(across).length();
            if left < area {
                // A triangle from the unit square: the root makes its rows equally dense.
                let root = (left / area).sqrt();
                return c[0] + (along * (1.0 - v) + across * v) * root;
            }
            left -= area;
            last = patch.centre;
        }
    }
    last
}

/// What every texel shot.
pub fn shots(mesh: &Mesh, matrix: &Matrix, emission: &[DVec3], answer: &Answer) -> Vec<Shot> {
    let sums = matrix.sums();
    let mut shots = Vec::new();
    for (cell, owner) in mesh.cells.iter().enumerate() {
        for k in owner.first as usize..(owner.first + owner.count) as usize {
            let (area, open) = (matrix.areas[k], matrix.open[k]);
            let lost = emission[k] * (1.0 - open);
            let shot = |radiosity: DVec3, form_factor_sum: f64, escaped: f64| Shot {
                cell: cell as u32,
                power: (radiosity * area).as_vec3().into(),
                form_factor_sum: form_factor_sum as f32,
                escaped: escaped as f32,
                unshot: 0.0,
            };
            shots.push(shot(answer.radiosity[k] - lost, sums[k], matrix.escaped[k]));
            if lost != DVec3::ZERO {
                shots.push(shot(lost, 0.0, 1.0));
            }
        }
    }
    shots
}

/// Max and area-weighted mean of |1 − ΣF − escaped| over the open parts.
pub fn closure(matrix: &Matrix) -> [f64; 2] {
    let (mut worst, mut sum, mut weight) = (0.0f64, 0.0, 0.0);
    for (k, taken) in matrix.sums().iter().enumerate() {
        let open = matrix.areas[k] * matrix.open[k];
        if open > 0.0 {
            let defect = (1.0 - taken - matrix.escaped[k]).abs();
            worst = worst.max(defect);
            sum += defect * open;
            weight += open;
        }
    }
    [worst, if weight > 0.0 { sum / weight } else { 0.0 }]
}
