//! What two patches exchange with nothing in between.
//!
//! ```text
//! G_ij = A_i F_ij = A_j F_ji = ∫∫ cosθ_i cosθ_j / (π r²) dA_i dA_j
//! ```
//! in squared mesh units. Near pairs by the contour integral, far ones by product Gauss–Legendre of
//! the lowest order whose error is below `TOLERANCE`:
//!
//! Along one parameter of a patch, s ∈ [−1, 1], the kernel is g(d + s·a) with a half an edge. With
//! t = |a|/|d| its Taylor terms are at most B_m tᵐ/(π|d|²), because 1/|d + s·a|⁴ has Gegenbauer
//! coefficients ≤ C(m+3, 3) and each cosine's numerator is ≤ 1 + t|s|:
//! B_m = C(m+3, 3) + 2C(m+2, 3) + C(m+1, 3). The remainder of Gauss–Legendre of order n on the mean
//! is c_n times the term of degree 2n, c_n = 2²ⁿ(n!)⁴/((2n+1)((2n)!)²) (Davis & Rabinowitz 1984,
//! 2.7.12); the errors of the four parameters add.

use super::contour::contour;
use super::gauss::gauss;
use crate::occlusion::polygon::{Plane, Polygon};
use common::constants::CONTACT;
use glam::DVec3;
use std::sync::LazyLock;

/// Error of the far rule, relative to A_i A_j/(π r²) with the least r between the patches.
const TOLERANCE: f64 = 2e-9;
/// Orders of the far rule.
const ORDERS: std::ops::RangeInclusive<usize> = 2..=7;
/// Corners this little behind the other's plane are on it (mesh units): a wall's lowest texels are
/// not cut by the floor's rounding.
const ON: f64 = 1e-12;

/// A convex patch: a texel, or an open part of one.
#[derive(Clone, Copy, Debug)]
pub struct Patch {
    /// Outline.
    pub polygon: Polygon,
    /// Front plane, unit normal.
    pub plane: Plane,
    /// Area in squared mesh units.
    pub area: f64,
    /// Centroid.
    pub centre: DVec3,
    /// Farthest corner from it.
    pub radius: f64,
}

impl Patch {
    /// The patch with the given outline in `plane`.
    pub fn new(polygon: Polygon, plane: Plane) -> Self {
        let centre = polygon.centroid();
        let radius = polygon
            .corners()
            .iter()
            .map(|p| p.distance(centre))
            .fold(0.0, f64::max);
        Self {
            polygon,
            plane,
            area: polygon.vector_area().length(),
            centre,
            radius,
        }
    }

    /// The patch of an outline that runs counter-clockwise from the front.
    pub fn of(corners: &[DVec3]) -> Self {
        let polygon = Polygon::new(corners);
        let normal = polygon.vector_area().normalize_or_zero();
        Self::new(polygon, Plane::through(corners[0], normal))
    }

    /// The part in front of `plane`; whole if it is but for rounding.
    pub fn above(&self, plane: &Plane) -> Option<Self> {
        let [low, high] = self.polygon.heights(plane);
        // Fronts that touch exchange nothing: nobody can tell which lies above the other.
        if high <= f64::from(CONTACT) {
            return None;
        }
        if low >= -ON {
            return Some(*self);
        }
        let part = self.polygon.above(plane);
        (!part.is_empty()).then(|| Self::new(part, self.plane))
    }

    /// Half the longer of each two opposite edges, for a patch of at most four corners; the flag
    /// says whether it is a parallelogram.
    fn halves(&self) -> Option<([f64; 2], bool)> {
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

/// The parts of two patches that lie in front of each other's planes, if there are any.
pub fn facing(a: &Patch, b: &Patch) -> Option<(Patch, Patch)> {
    Some((a.above(&b.plane)?, b.above(&a.plane)?))
}

/// G of two patches that lie in front of each other's planes.
pub fn exchange(a: &Patch, b: &Patch) -> f64 {
    match (order(a, b), order(b, a)) {
        (Some(m), Some(n)) => far(a, m, b, n),
        _ => contour(&a.polygon, &b.polygon),
    }
}

/// F from the outline `a` to the outline `b` with nothing in between.
pub fn form_factor(a: &[DVec3], b: &[DVec3]) -> f64 {
    let (a, b) = (Patch::of(a), Patch::of(b));
    facing(&a, &b).map_or(0.0, |(front_a, front_b)| {
        exchange(&front_a, &front_b) / a.area
    })
}

/// The far rule's order on `a` against `b`, if there is one.
fn order(a: &Patch, b: &Patch) -> Option<usize> {
    let ([first, second], flat) = a.halves()?;
    let distance = a.centre.distance(b.centre) - a.radius - b.radius;
    if distance <= 0.0 {
        return None;
    }
    let inverse = 1.0 / distance;
    let n = ORDERS
        .map(|n| (n, bound(n, first * inverse) + bound(n, second * inverse)))
        .find(|(_, error)| *error <= TOLERANCE / 2.0)?
        .0;
    // A bilinear patch's density is linear along each parameter: one degree more.
    Some(if flat { n } else { n + 1 })
}

/// c_n B_2n t^2n.
fn bound(n: usize, t: f64) -> f64 {
    static FACTORS: LazyLock<Vec<f64>> = LazyLock::new(|| {
        (0..=*ORDERS.end())
            .map(|n| {
                let factorial = |k: usize| (1..=k).map(|x| x as f64).product::<f64>();
                let choose = |m: usize| (m * (m - 1) * (m - 2)) as f64 / 6.0;
                let m = 2 * n;
                let b =
                    choose(m + 3) + 2.0 * choose(m + 2) + if m > 1 { choose(m + 1) } else { 0.0 };
                let share = factorial(n).powi(4) / ((m + 1) as f64 * factorial(m).powi(2));
                2f64.powi(m as i32) * share * b
            })
            .collect()
    });
    FACTORS[n] * t.powi(2 * n as i32)
}

/// Nodes of a patch, as arrays so that the double loop vectorises.
struct Nodes {
    x: [f64; 64],
    y: [f64; 64],
    z: [f64; 64],
    weight: [f64; 64],
    count: usize,
}

/// Product Gauss–Legendre of order `n` ≤ 8 on a patch of at most four corners.
fn nodes(patch: &Patch, n: usize) -> Nodes {
    let mut nodes = Nodes {
        x: [0.0; 64],
        y: [0.0; 64],
        z: [0.0; 64],
        weight: [0.0; 64],
        count: 0,
    };
    for quad in patch.polygon.quads() {
        each_node(&quad, n, |p, weight| {
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

/// Points and area weights of product Gauss–Legendre on a bilinear quad.
pub fn each_node([a, b, c, d]: &[DVec3; 4], n: usize, mut visit: impl FnMut(DVec3, f64)) {
    for (v, weight_v) in gauss(n) {
        let v = 0.5 + 0.5 * v;
        let (left, right) = (a.lerp(*d, v), b.lerp(*c, v));
        let along = right - left;
        for (u, weight_u) in gauss(n) {
            let u = 0.5 + 0.5 * u;
            let across = (d - a).lerp(c - b, u);
            visit(
                left + along * u,
                0.25 * weight_u * weight_v * along.cross(across).length(),
            );
        }
    }
}

fn far(a: &Patch, m: usize, b: &Patch, n: usize) -> f64 {
    let (p, q) = (nodes(a, m), nodes(b, n));
    let (na, nb) = (a.plane.normal, b.plane.normal);
    let count = q.count.min(64);
    let (x, y, z, weight) = (
        &q.x[..count],
        &q.y[..count],
        &q.z[..count],
        &q.weight[..count],
    );
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
