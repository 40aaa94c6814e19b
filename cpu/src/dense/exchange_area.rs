//! Exchange areas of two unoccluded pieces of surface:
//!
//! ```text
//! G_ij = A_i F_ij = A_j F_ji = ∫∫ cosθ_i cosθ_j / (π r²) dA_i dA_j
//! ```
//! in squared mesh units. Near pairs by the contour integral, far ones by product Gauss–Legendre of
//! the lowest order whose error is below `FAR_RULE_TOLERANCE`:
//!
//! Along one parameter of a piece, s ∈ [−1, 1], the kernel is g(d + s·a) with a half an edge. With
//! t = |a|/|d| its Taylor terms are at most B_m tᵐ/(π|d|²), because 1/|d + s·a|⁴ has Gegenbauer
//! coefficients ≤ C(m+3, 3) and each cosine's numerator is ≤ 1 + t|s|:
//! B_m = C(m+3, 3) + 2C(m+2, 3) + C(m+1, 3). The remainder of Gauss–Legendre of order n on the mean
//! is c_n times the term of degree 2n, c_n = 2²ⁿ(n!)⁴/((2n+1)((2n)!)²) (Davis & Rabinowitz 1984,
//! 2.7.12); the errors of the four parameters add.

use super::contour_integral::contour_integral;
use super::quadrature::gauss_legendre;
use crate::occlusion::polygon::{ConvexPolygon, OrientedPlane};
use common::constants::CONTACT_DISTANCE;
use glam::DVec3;
use std::sync::LazyLock;

/// Error of the far rule, relative to A_i A_j/(π r²) with the least r between the pieces.
const FAR_RULE_TOLERANCE: f64 = 2e-9;
/// Orders of the far rule.
const FAR_RULE_ORDERS: std::ops::RangeInclusive<usize> = 2..=7;
/// Corners closer than this behind the other's plane count as on it (mesh units), so that the floor's rounding does not
/// cut a wall's lowest texels.
const COPLANAR_DISTANCE: f64 = 1e-12;

/// A planar convex piece of surface: a texel, or an open part of one.
#[derive(Clone, Copy, Debug)]
pub struct SurfacePiece {
    /// Outline.
    pub polygon: ConvexPolygon,
    /// Front plane, unit normal.
    pub plane: OrientedPlane,
    /// Area in squared mesh units.
    pub area: f64,
    /// Centroid.
    pub centre: DVec3,
    /// Distance of the farthest corner from the centroid.
    pub radius: f64,
}

impl SurfacePiece {
    /// Makes a piece of an outline in `plane`.
    pub fn new(polygon: ConvexPolygon, plane: OrientedPlane) -> Self {
        let centre = polygon.centroid();
        let radius = polygon.corners().iter().map(|p| p.distance(centre)).fold(0.0, f64::max);
        Self {
            polygon,
            plane,
            area: polygon.vector_area().length(),
            centre,
            radius,
        }
    }

    /// Makes a piece of an outline that runs counter-clockwise as seen from the front.
    pub fn from_outline(corners: &[DVec3]) -> Self {
        let polygon = ConvexPolygon::new(corners);
        let normal = polygon.vector_area().normalize_or_zero();
        Self::new(polygon, OrientedPlane::through_point(corners[0], normal))
    }

    /// Returns the part in front of `plane`; the whole piece if only rounding lies behind it.
    pub fn part_above(&self, plane: &OrientedPlane) -> Option<Self> {
        let [low, high] = self.polygon.height_range(plane);
        // Fronts that touch exchange nothing: rounding decides which lies above the other.
        if high <= f64::from(CONTACT_DISTANCE) {
            return None;
        }
        if low >= -COPLANAR_DISTANCE {
            return Some(*self);
        }
        let part = self.polygon.clip_above(plane);
        (!part.is_empty()).then(|| Self::new(part, self.plane))
    }

    /// Returns half of the longer of each two opposite edges, and true for a parallelogram; none for more than four
    /// corners.
    fn half_edges(&self) -> Option<([f64; 2], bool)> {
        let c = self.polygon.corners();
        let [a, b, c, d] = match c.len() {
            3 => [c[0], c[1], c[2], c[2]],
            4 => [c[0], c[1], c[2], c[3]],
            _ => return None,
        };
        let longer = |x: DVec3, y: DVec3| 0.5 * x.length_squared().max(y.length_squared()).sqrt();
        let skew = (a - b + c - d).length_squared();
        let halves = [longer(b - a, c - d), longer(c - b, d - a)];
        Some((halves, skew <= 1e-20 * halves[0] * halves[1]))
    }
}

/// Returns the parts of two pieces that lie in front of each other's planes, if there are any.
pub fn facing_parts(a: &SurfacePiece, b: &SurfacePiece) -> Option<(SurfacePiece, SurfacePiece)> {
    Some((a.part_above(&b.plane)?, b.part_above(&a.plane)?))
}

/// Returns G of two pieces that lie in front of each other's planes.
pub fn exchange_area(a: &SurfacePiece, b: &SurfacePiece) -> f64 {
    match (far_rule_order(a, b), far_rule_order(b, a)) {
        (Some(m), Some(n)) => far_exchange(a, m, b, n),
        _ => contour_integral(&a.polygon, &b.polygon),
    }
}

/// Returns F from the outline `a` to the outline `b` without occluders.
pub fn form_factor(a: &[DVec3], b: &[DVec3]) -> f64 {
    let (a, b) = (SurfacePiece::from_outline(a), SurfacePiece::from_outline(b));
    facing_parts(&a, &b).map_or(0.0, |(front_a, front_b)| exchange_area(&front_a, &front_b) / a.area)
}

/// Returns the far rule's order on `a` against `b`; none if the pieces are too close.
fn far_rule_order(a: &SurfacePiece, b: &SurfacePiece) -> Option<usize> {
    let ([first, second], flat) = a.half_edges()?;
    let distance = a.centre.distance(b.centre) - a.radius - b.radius;
    if distance <= 0.0 {
        return None;
    }
    let inverse = 1.0 / distance;
    let n = FAR_RULE_ORDERS
        .map(|n| {
            (
                n,
                remainder_bound(n, first * inverse) + remainder_bound(n, second * inverse),
            )
        })
        .find(|(_, error)| *error <= FAR_RULE_TOLERANCE / 2.0)?
        .0;
    // A bilinear piece's density is linear along each parameter: one degree more.
    Some(if flat { n } else { n + 1 })
}

/// Returns the remainder c_n B_2n t^2n.
fn remainder_bound(n: usize, t: f64) -> f64 {
    static FACTORS: LazyLock<Vec<f64>> = LazyLock::new(|| {
        (0..=*FAR_RULE_ORDERS.end())
            .map(|n| {
                let factorial = |k: usize| (1..=k).map(|x| x as f64).product::<f64>();
                let choose = |m: usize| (m * (m - 1) * (m - 2)) as f64 / 6.0;
                let m = 2 * n;
                let b = choose(m + 3) + 2.0 * choose(m + 2) + if m > 1 { choose(m + 1) } else { 0.0 };
                let share = factorial(n).powi(4) / ((m + 1) as f64 * factorial(m).powi(2));
                2f64.powi(m as i32) * share * b
            })
            .collect()
    });
    FACTORS[n] * t.powi(2 * n as i32)
}

/// Quadrature nodes of a piece, as arrays so that the double loop vectorises.
struct QuadratureNodes {
    x: [f64; 64],
    y: [f64; 64],
    z: [f64; 64],
    weight: [f64; 64],
    count: usize,
}

/// Returns the nodes of product Gauss–Legendre of order `n` ≤ 8 on a piece of at most four corners.
fn quadrature_nodes(piece: &SurfacePiece, n: usize) -> QuadratureNodes {
    let mut nodes = QuadratureNodes {
        x: [0.0; 64],
        y: [0.0; 64],
        z: [0.0; 64],
        weight: [0.0; 64],
        count: 0,
    };
    for quad in piece.polygon.quad_pieces() {
        for_each_node(&quad, n, |p, weight| {
            let k = nodes.count;
            if k < 64 {
                (nodes.x[k], nodes.y[k], nodes.z[k]) = (p.x, p.y, p.z);
                nodes.weight[k] = weight;
                nodes.count += 1;
            }
        });
    }
    nodes
}

/// Visits the points and area weights of product Gauss–Legendre on a bilinear quad.
pub fn for_each_node([a, b, c, d]: &[DVec3; 4], n: usize, mut visit: impl FnMut(DVec3, f64)) {
    for (v, weight_v) in gauss_legendre(n) {
        let v = 0.5 + 0.5 * v;
        let (left, right) = (a.lerp(*d, v), b.lerp(*c, v));
        let along = right - left;
        for (u, weight_u) in gauss_legendre(n) {
            let u = 0.5 + 0.5 * u;
            let across = (d - a).lerp(c - b, u);
            visit(
                left + along * u,
                0.25 * weight_u * weight_v * along.cross(across).length(),
            );
        }
    }
}

fn far_exchange(a: &SurfacePiece, m: usize, b: &SurfacePiece, n: usize) -> f64 {
    let (p, q) = (quadrature_nodes(a, m), quadrature_nodes(b, n));
    let (na, nb) = (a.plane.normal, b.plane.normal);
    let count = q.count.min(64);
    let (x, y, z, weight) = (&q.x[..count], &q.y[..count], &q.z[..count], &q.weight[..count]);
    let mut sum = 0.0;
    for k in 0..p.count.min(64) {
        let mut inner = 0.0;
        for j in 0..count {
            let (dx, dy, dz) = (x[j] - p.x[k], y[j] - p.y[k], z[j] - p.z[k]);
            let r2 = dx * dx + dy * dy + dz * dz;
            let cos_a = na.x * dx + na.y * dy + na.z * dz;
            let cos_b = nb.x * dx + nb.y * dy + nb.z * dz;
            inner -= weight[j] * cos_a * cos_b / (r2 * r2);
        }
        sum += inner * p.weight[k];
    }
    (sum / std::f64::consts::PI).max(0.0)
}
