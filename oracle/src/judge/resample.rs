//! Texels of one face in two resolutions: exact area averages on a common grid.
//!
//! ```text
//! v'_t = Σ_s A_st v_s / Σ_s A_st        A_st: the area that texel s and texel t share
//! ```
//! so Σ A v is kept whatever the resolutions. On a quad the grid lines are straight and the
//! shared piece is a block of the bilinear map; on a triangle all lines run in three directions,
//! and the piece is bounded by intervals of u, v and u + v in whole numbers.

use common::scene::{Face, Shape};
use common::texel::{count, triangle_position};
use glam::DVec3;

/// The area that a texel of one grid shares with a texel of another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Piece {
    /// The texel of the first grid.
    pub from: u32,
    /// The texel of the second grid.
    pub to: u32,
    /// Scene units squared.
    pub area: f64,
}

/// The resolution on which W×H texels `a` and `b` are compared: each side is their greatest
/// common divisor, so that texels are unions of whole ones, unless that leaves less than a
/// quarter of the coarser; then the coarser, whose texels cut finer ones.
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

fn gcd(a: u32, b: u32) -> u32 {
    if b == 0 { a } else { gcd(b, a % b) }
}

/// All pieces that the texels of `from` and `to` share on `face`; their areas add up to its own.
pub fn pieces(face: &Face, from: [u32; 2], to: [u32; 2]) -> Vec<Piece> {
    match face.shape {
        Shape::Quad => quad(face, from, to),
        Shape::Triangle => triangle(face, from[1], to[1]),
    }
}

/// The areas of the texels that the pieces make up.
pub fn areas(pieces: &[Piece], to: [u32; 2]) -> Vec<f64> {
    let mut areas = vec![0.0; count(to) as usize];
    for piece in pieces {
        areas[piece.to as usize] += piece.area;
    }
    areas
}

/// Area averages of `values` (one per texel of the first grid) on the second.
pub fn average(values: &[DVec3], pieces: &[Piece], to: [u32; 2]) -> Vec<DVec3> {
    let mut sums = vec![DVec3::ZERO; count(to) as usize];
    for piece in pieces {
        sums[piece.to as usize] += values[piece.from as usize] * piece.area;
    }
    divide(sums, &areas(pieces, to))
}

/// Standard errors of such averages when those of the `values` are independent.
pub fn average_error(errors: &[DVec3], pieces: &[Piece], to: [u32; 2]) -> Vec<DVec3> {
    let mut sums = vec![DVec3::ZERO; count(to) as usize];
    for piece in pieces {
        sums[piece.to as usize] += (errors[piece.from as usize] * piece.area).powf(2.0);
    }
    let sums = sums.into_iter().map(|sum| sum.map(f64::sqrt)).collect();
    divide(sums, &areas(pieces, to))
}

/// A texel without area keeps 0: it counts for nothing.
fn divide(sums: Vec<DVec3>, areas: &[f64]) -> Vec<DVec3> {
    sums.into_iter()
        .zip(areas)
        .map(|(sum, area)| {
            if *area > 0.0 {
                sum / *area
            } else {
                DVec3::ZERO
            }
        })
        .collect()
}

/// The parts into which both divisions of a side cut it: (part of `a`, part of `b`, ends).
fn segments(a: u32, b: u32) -> Vec<(u32, u32, [f64; 2])> {
    // In units of 1/ab of the side all cuts are whole numbers.
    let (wide, step_a, step_b) = (u64::from(a) * u64::from(b), u64::from(b), u64::from(a));
    let mut parts = Vec::new();
    let mut start = 0;
    while start < wide {
        let (i, j) = (start / step_a, start / step_b);
        let end = ((i + 1) * step_a).min((j + 1) * step_b);
        parts.push((
            i as u32,
            j as u32,
            [start, end].map(|k| k as f64 / wide as f64),
        ));
        start = end;
    }
    parts
}

fn quad(face: &Face, from: [u32; 2], to: [u32; 2]) -> Vec<Piece> {
    let [columns, rows] = [0, 1].map(|k| segments(from[k], to[k]));
    let mut pieces = Vec::with_capacity(columns.len() * rows.len());
    for (j, j_to, v) in &rows {
        for (i, i_to, u) in &columns {
            let [a, b, c, d] =
                [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(s, t)| face.point(u[s], v[t]));
            pieces.push(Piece {
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

fn triangle(face: &Face, from: u32, to: u32) -> Vec<Piece> {
    // In units of 1/(from·to) of the sides all bounds are whole numbers; u, v < unit.
    let unit = f64::from(from) * f64::from(to);
    let whole = face.area() / (unit * unit / 2.0);
    let mut pieces = Vec::new();
    for index in 0..from * from {
        let mine = bounds(from, index, i64::from(to));
        for other in candidates(&mine, to, i64::from(from)) {
            let theirs = bounds(to, other, i64::from(from));
            let shared = shared_area(&mine, &theirs);
            if shared > 0.0 {
                pieces.push(Piece {
                    from: index,
                    to: other,
                    area: shared * whole,
                });
            }
        }
    }
    pieces
}

/// The bounds of a sub-triangle of `side` rows, each `step` units wide.
fn bounds(side: u32, index: u32, step: i64) -> Bounds {
    let (i, j, upright) = triangle_position(side, index);
    let (i, j) = (i64::from(i), i64::from(j));
    let s = i + j + i64::from(!upright);
    [i, j, s].map(|k| [k * step, (k + 1) * step])
}

/// The sub-triangles of the other grid (`side` rows, `step` units wide) that may share area.
fn candidates(mine: &Bounds, side: u32, step: i64) -> Vec<u32> {
    let [columns, rows] = [0, 1].map(|k| mine[k][0] / step..=(mine[k][1] - 1) / step);
    let side = i64::from(side);
    let mut found = Vec::new();
    for j in rows {
        for i in columns.clone() {
            for inverted in 0..2 {
                if i + j + inverted < side {
                    found.push((j * (2 * side - j) + 2 * i + inverted) as u32);
                }
            }
        }
    }
    found
}

/// The area within both bounds: the box in u, v, cut by two parallel lines.
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
