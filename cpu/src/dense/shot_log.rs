//! The log of shots of a dense solution, for the energy balance: each texel shoots once, with all power that leaves it.
//!
//! The open part of a texel shoots A(o∘E + ρ∘H); of that ΣF arrives, and the share of its cosine
//! hemisphere that meets no front escapes. The emission of its covered part is lost behind the body that
//! stands on it.

use super::open_area::Element;
use super::open_points::draw_point;
use super::{ClosureDefects, DenseSolution, Matrix};
use common::escape::{ESCAPE_DIRECTION_COUNT, escape_directions, meets_front, weyl_sequence};
use common::mesh::Mesh;
use common::rays::Rays;
use common::shooting::Shot;
use glam::{DVec3, Quat};
use rayon::prelude::*;
use std::f32::consts::TAU;

/// Returns the escaped share of each element's open part: one ray in each of the fixed directions, rotated by an angle
/// per element so that errors of neighbours are not correlated, from points all over the open part.
pub fn escaped_shares(mesh: &Mesh, rays: &Rays, elements: &[Element]) -> Vec<f64> {
    let directions = escape_directions();
    elements
        .par_iter()
        .enumerate()
        .map(|(k, element)| {
            let outlines = element.open_outlines();
            let face = &mesh.faces[element.face as usize];
            let turn = Quat::from_rotation_z(weyl_sequence(k, 0.618_033_988_749_895) as f32 * TAU);
            let lost = directions
                .iter()
                .enumerate()
                .filter(|(n, d)| {
                    let uv =
                        [0.754_877_666_246_693, 0.569_840_290_998_053].map(|alpha| weyl_sequence(k + n, alpha) as f32);
                    draw_point(&outlines, uv)
                        .is_some_and(|at| !meets_front(rays, face.sheet, at, face.direction_in_frame(turn * **d)))
                })
                .count();
            lost as f64 / ESCAPE_DIRECTION_COUNT as f64
        })
        .collect()
}

/// Returns the shots of all texels.
pub fn texel_shots(mesh: &Mesh, matrix: &Matrix, emission: &[DVec3], answer: &DenseSolution) -> Vec<Shot> {
    let sums = matrix.form_factor_sums();
    let mut shots = Vec::new();
    for (patch, owner) in mesh.patches.iter().enumerate() {
        for k in owner.first as usize..(owner.first + owner.count) as usize {
            let (area, open) = (matrix.areas[k], matrix.open[k]);
            let lost = mesh.texels[k].emission.as_dvec3() * (1.0 - open);
            let shot = |radiosity: DVec3, form_factor_sum: f64, escaped: f64| Shot {
                patch: patch as u32,
                power: (radiosity * area).as_vec3().into(),
                form_factor_sum: form_factor_sum as f32,
                escaped: escaped as f32,
                unshot: 0.0,
            };
            let covered = emission[k] * (1.0 - open);
            shots.push(shot(answer.radiosity[k] - covered, sums[k], matrix.escaped[k]));
            if lost != DVec3::ZERO {
                shots.push(shot(lost, 0.0, 1.0));
            }
        }
    }
    shots
}

/// Returns the closure defects of all texels.
pub fn closure_defects(matrix: &Matrix) -> ClosureDefects {
    let (mut max, mut sum, mut weight) = (0.0f64, 0.0, 0.0);
    for (k, taken) in matrix.form_factor_sums().iter().enumerate() {
        let open = matrix.areas[k] * matrix.open[k];
        if open > 0.0 {
            let defect = (1.0 - taken - matrix.escaped[k]).abs();
            max = max.max(defect);
            sum += defect * open;
            weight += open;
        }
    }
    let mean = if weight > 0.0 { sum / weight } else { 0.0 };
    ClosureDefects { max, mean }
}
