//! The exact exchange area of two unoccluded polygons by the double contour integral:
//!
//! ```text
//! A_i F_ij = 1/2π ∮∮ ln r dr_i·dr_j                     (Sparrow 1963)
//! ```
//! The inner integral over an edge is elementary; the outer one is taken by Gauss–Legendre of the
//! order that its nearest singularity requires, or by tanh-sinh where edges touch or almost touch.

use super::quadrature::{gauss_legendre, tanh_sinh};
use crate::occlusion::polygon::ConvexPolygon;
use glam::DVec3;
use std::f64::consts::PI;

/// Returns A_i F_ij; each polygon lies in front of the other's plane.
pub fn contour_integral(a: &ConvexPolygon, b: &ConvexPolygon) -> f64 {
    let sum: f64 = a
        .edges()
        .flat_map(|outer| b.edges().map(move |inner| edge_pair_integral(outer, inner)))
        .sum();
    (sum / (2.0 * PI)).max(0.0)
}

/// Returns ∫∫ ln r da·db over two edges.
fn edge_pair_integral([a, b]: [DVec3; 2], inner: [DVec3; 2]) -> f64 {
    let along = b - a;
    let cosine = along.dot((inner[1] - inner[0]).normalize_or_zero());
    // Perpendicular but for rounding, which would cost as much as any other pair.
    if cosine.abs() <= 1e-14 * along.length() || !cosine.is_finite() {
        return 0.0;
    }
    let closest = closest_approach(a, along, inner);
    let outer = |s: f64| log_distance(a + along * s, inner);
    let mean = match quadrature_order(a, b, along, inner, closest) {
        Some(n) => {
            0.5 * gauss_legendre(n)
                .iter()
                .map(|(x, w)| w * outer(0.5 + 0.5 * x))
                .sum::<f64>()
        }
        None => integrate_singular(a, along, inner, closest),
    };
    cosine * mean
}

/// Returns the closest approach of the lines of two edges: its parameter on the outer edge (0…1 inside) and its
/// distance in lengths of the outer edge. None for parallel edges, whose distance is constant, and for an inner edge
/// that does not span that point.
fn closest_approach(a: DVec3, along: DVec3, inner: [DVec3; 2]) -> Option<[f64; 2]> {
    let length = (inner[1] - inner[0]).length();
    let direction = (inner[1] - inner[0]) / length;
    let across = along.reject_from_normalized(direction);
    let square = across.length_squared();
    if square <= 1e-24 * along.length_squared() {
        return None;
    }
    let away = (a - inner[0]).reject_from_normalized(direction);
    let s = -away.dot(across) / square;
    let foot = direction.dot(a + along * s - inner[0]) / length;
    let distance = (away + across * s).length() / square.sqrt();
    // Beside the edge the arcs of its two ends cancel; half a length is a margin for complex s.
    (-0.5..=1.5).contains(&foot).then_some([s, distance])
}

/// Returns a Gauss order that reaches 1e−11 of the edge's size, or none. The inner integral
/// is analytic up to the complex s at which an end of the inner edge, or its line, is at distance
/// 0; the ellipse with foci at the ends of the outer edge through that point has semi-axes' sum ρ,
/// and the error is O(ρ^−2n) (Trefethen 2008, theorem 4.5).
fn quadrature_order(a: DVec3, b: DVec3, along: DVec3, inner: [DVec3; 2], closest: Option<[f64; 2]>) -> Option<usize> {
    let length = along.length();
    let mut axis = inner
        .iter()
        .map(|q| ((q - a).length() + (q - b).length()) / length)
        .fold(f64::INFINITY, f64::min);
    if let Some([s, distance]) = closest {
        axis = axis.min(s.hypot(distance) + (1.0 - s).hypot(distance));
    }
    let rho = axis + (axis * axis - 1.0).max(0.0).sqrt();
    match rho {
        // ρ^−2n ≤ 1e−12.
        r if r >= 5.7 => Some(8),
        r if r >= 2.4 => Some(16),
        r if r >= 1.55 => Some(32),
        _ => None,
    }
}

/// Returns the mean of the inner integral where the edges touch or almost touch. The outer edge is cut where it passes
/// an end of the inner one or comes closest to it, so that singularities lie at ends.
fn integrate_singular(a: DVec3, along: DVec3, inner: [DVec3; 2], closest: Option<[f64; 2]>) -> f64 {
    let pass = |p: DVec3| ((p - a).dot(along) / along.length_squared()).clamp(0.0, 1.0);
    let mut cuts = [
        0.0,
        pass(inner[0]),
        pass(inner[1]),
        closest.map_or(1.0, |[s, _]| s.clamp(0.0, 1.0)),
        1.0,
    ];
    cuts.sort_by(f64::total_cmp);
    cuts.windows(2)
        .filter(|cut| cut[1] > cut[0])
        .map(|cut| {
            let (from, to) = (a + along * cut[0], a + along * cut[1]);
            let sum: f64 = tanh_sinh()
                .iter()
                .map(|(share, weight)| {
                    weight
                        * (log_distance(from + (to - from) * share, inner)
                            + log_distance(to + (from - to) * share, inner))
                })
                .sum();
            sum * (cut[1] - cut[0])
        })
        .sum()
}

/// Returns ∫ ln|p − q| dq along an edge: with s along the edge from the projection of p, and d its distance,
/// ½s·ln(s² + d²) − s + d·atan(s/d).
fn log_distance(p: DVec3, [q, end]: [DVec3; 2]) -> f64 {
    let length = (end - q).length();
    let direction = (end - q) / length;
    let from = direction.dot(q - p);
    let to = from + length;
    let square = (q - p).reject_from_normalized(direction).length_squared();
    let d = square.sqrt();
    let logarithm = |s: f64| {
        let r2 = s * s + square;
        if r2 > 0.0 { 0.5 * s * r2.ln() } else { 0.0 }
    };
    // atan(to/d) − atan(from/d) as one angle.
    let angle = (d * length).atan2(square + from * to);
    logarithm(to) - logarithm(from) - length + d * angle
}
