//! Resampling of one face's texels to another resolution: exact area averages on a common grid.
//!
//! ```text
//! v'_t = Σ_s A_st v_s / Σ_s A_st        A_st: the area that texel s and texel t share
//! ```
//! so Σ A v is the same for all resolutions. On a quad the grid lines are straight and the
//! shared piece is a block of the bilinear map; on a triangle all lines have one of three directions,
//! and the piece is bounded by intervals of u, v and u + v in whole numbers.

use crate::scene::{Face, Shape};
use crate::texel::{texel_count, triangle_index, triangle_position};
use glam::DVec3;

/// Area that a texel of one grid shares with a texel of another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SharedPiece {
    /// Texel of the first grid.
    pub from: u32,
    /// Texel of the second grid.
    pub to: u32,
    /// Shared area, scene units squared.
    pub area: f64,
}

/// Returns the resolution on which W×H texels `a` and `b` are compared. Each side is their greatest
/// common divisor, so that its texels are unions of whole ones, unless this is less than a quarter of the
/// coarser side; then it is the coarser side, whose texels divide finer ones.
pub fn common_resolution(a: [u32; 2], b: [u32; 2]) -> [u32; 2] {
    [0, 1].map(|k| {
        let (shared, coarser) = (gcd(a[k], b[k]), a[k].min(b[k]));
        if 4 * u64::from(shared) >= u64::from(coarser) {
            shared
        } else {
            coarser
        }
    })
}

/// Returns half of each even number of texels.
pub fn halve_even(texels: [u32; 2]) -> [u32; 2] {
    texels.map(|n| if n.is_multiple_of(2) { n / 2 } else { n })
}

fn gcd(a: u32, b: u32) -> u32 {
    if b == 0 { a } else { gcd(b, a % b) }
}

/// Returns all pieces that the texels of `from` and `to` share on `face`; their areas sum to the face's.
pub fn shared_pieces(face: &Face, from: [u32; 2], to: [u32; 2]) -> Vec<SharedPiece> {
    match face.shape {
        Shape::Quad => quad_pieces(face, from, to),
        Shape::Triangle => triangle_pieces(face, from[1], to[1]),
    }
}

/// Returns the areas of the texels of the second grid, as sums of their pieces.
pub fn summed_areas(pieces: &[SharedPiece], to: [u32; 2]) -> Vec<f64> {
    let mut areas = vec![0.0; texel_count(to) as usize];
    for piece in pieces {
        areas[piece.to as usize] += piece.area;
    }
    areas
}

/// Returns the area averages of `values`, one per texel of the first grid, on the second grid.
pub fn area_average(values: &[DVec3], pieces: &[SharedPiece], to: [u32; 2]) -> Vec<DVec3> {
    let mut sums = vec![DVec3::ZERO; texel_count(to) as usize];
    for piece in pieces {
        sums[piece.to as usize] += values[piece.from as usize] * piece.area;
    }
    divide_by_area(sums, &summed_areas(pieces, to))
}

/// Returns the standard errors of area averages from the independent standard `errors` of the values.
pub fn average_standard_error(errors: &[DVec3], pieces: &[SharedPiece], to: [u32; 2]) -> Vec<DVec3> {
    let mut sums = vec![DVec3::ZERO; texel_count(to) as usize];
    for piece in pieces {
        sums[piece.to as usize] += (errors[piece.from as usize] * piece.area).powf(2.0);
    }
    let sums = sums.into_iter().map(|sum| sum.map(f64::sqrt)).collect();
    divide_by_area(sums, &summed_areas(pieces, to))
}

/// Divides sums by areas; a texel without area has 0.
fn divide_by_area(sums: Vec<DVec3>, areas: &[f64]) -> Vec<DVec3> {
    let mean = |(sum, area): (DVec3, &f64)| if *area > 0.0 { sum / *area } else { DVec3::ZERO };
    sums.into_iter().zip(areas).map(mean).collect()
}

/// Returns the segments into which both divisions of a side, by `a` and by `b`, divide it: (part of `a`,
/// part of `b`, ends).
fn side_segments(a: u32, b: u32) -> Vec<(u32, u32, [f64; 2])> {
    // In units of 1/ab of the side all ends are whole numbers.
    let (wide, step_a, step_b) = (u64::from(a) * u64::from(b), u64::from(b), u64::from(a));
    let mut parts = Vec::new();
    let mut start = 0;
    while start < wide {
        let (i, j) = (start / step_a, start / step_b);
        let end = ((i + 1) * step_a).min((j + 1) * step_b);
        parts.push((i as u32, j as u32, [start, end].map(|k| k as f64 / wide as f64)));
        start = end;
    }
    parts
}

fn quad_pieces(face: &Face, from: [u32; 2], to: [u32; 2]) -> Vec<SharedPiece> {
    let [columns, rows] = [0, 1].map(|k| side_segments(from[k], to[k]));
    let mut pieces = Vec::with_capacity(columns.len() * rows.len());
    for (j, j_to, v) in &rows {
        for (i, i_to, u) in &columns {
            let [a, b, c, d] = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(s, t)| face.point_at(u[s], v[t]));
            pieces.push(SharedPiece {
                from: j * from[0] + i,
                to: j_to * to[0] + i_to,
                area: (c - a).cross(d - b).length() * 0.5,
            });
        }
    }
    pieces
}

/// Bounds of u, v and u + v.
type Bounds = [[i64; 2]; 3];

fn triangle_pieces(face: &Face, from: u32, to: u32) -> Vec<SharedPiece> {
    // In units of 1/(from·to) of the sides all bounds are whole numbers; u, v < unit.
    let unit = f64::from(from) * f64::from(to);
    let whole = face.area() / (unit * unit / 2.0);
    let mut pieces = Vec::new();
    for index in 0..from * from {
        let first = triangle_bounds(from, index, i64::from(to));
        for other in candidate_triangles(&first, to, i64::from(from)) {
            let second = triangle_bounds(to, other, i64::from(from));
            let shared = shared_area(&first, &second);
            if shared > 0.0 {
                pieces.push(SharedPiece {
                    from: index,
                    to: other,
                    area: shared * whole,
                });
            }
        }
    }
    pieces
}

/// Returns the bounds of sub-triangle `index` of `side` rows, each `step` units wide.
fn triangle_bounds(side: u32, index: u32, step: i64) -> Bounds {
    let (i, j, upright) = triangle_position(side, index);
    let (i, j) = (i64::from(i), i64::from(j));
    let s = i + j + i64::from(!upright);
    [i, j, s].map(|k| [k * step, (k + 1) * step])
}

/// Returns the sub-triangles of the other grid (`side` rows, `step` units wide) that may share area.
fn candidate_triangles(first: &Bounds, side: u32, step: i64) -> Vec<u32> {
    let [columns, rows] = [0, 1].map(|k| (first[k][0] / step) as u32..=((first[k][1] - 1) / step) as u32);
    let lattice = rows.flat_map(|j| columns.clone().map(move |i| (i, j)));
    let triangles = lattice.flat_map(|(i, j)| [(i, j, true), (i, j, false)]);
    let inside = triangles.filter(|(i, j, upright)| i + j + u32::from(!upright) < side);
    inside
        .map(|(i, j, upright)| triangle_index(side, i, j, upright))
        .collect()
}

/// Returns the area within both bounds: the box in u, v between two parallel lines.
fn shared_area(a: &Bounds, b: &Bounds) -> f64 {
    let [u, v, s] = [0, 1, 2].map(|k| [a[k][0].max(b[k][0]), a[k][1].min(b[k][1])]);
    if u[0] >= u[1] || v[0] >= v[1] || s[0] >= s[1] {
        return 0.0;
    }
    // Twice the area of the box below the line u + v = s.
    let below = |s: i64| {
        let corner = |u: i64, v: i64| i128::from((s - u - v).max(0)).pow(2);
        corner(u[0], v[0]) - corner(u[1], v[0]) - corner(u[0], v[1]) + corner(u[1], v[1])
    };
    (below(s[1]) - below(s[0])) as f64 / 2.0
}

#[cfg(test)]
mod tests;
