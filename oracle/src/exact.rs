//! Exact results in f64 by methods independent of the solvers: closed forms, Lambert's sum, the double contour
//! integral, and enclosures with known solutions.
//!
//! F_ij is the share of the light leaving i that arrives at j. Outlines are planar, convex and run
//! counter-clockwise as seen from their front.

pub mod direct_light;

use common::polygon::clip_by_plane;
use glam::DVec3;
use std::f64::consts::PI;

/// Returns the form factor of two facing rectangles `a`×`b` at distance `c` (Howell, *Catalog of Configuration
/// Factors*, C-11).
pub fn parallel_rectangles(a: f64, b: f64, c: f64) -> f64 {
    let (x, y) = (a / c, b / c);
    let (p, q) = ((1.0 + x * x).sqrt(), (1.0 + y * y).sqrt());
    let logarithm = (p * q / (1.0 + x * x + y * y).sqrt()).ln();
    let arcs = x * q * (x / q).atan() + y * p * (y / p).atan() - x * x.atan() - y * y.atan();
    2.0 / (PI * x * y) * (logarithm + arcs)
}

/// Returns the form factor from a rectangle `width`×`edge` to the perpendicular one `height`×`edge` that shares
/// `edge` (Howell C-14).
pub fn perpendicular_rectangles(edge: f64, width: f64, height: f64) -> f64 {
    let (w, h) = (width / edge, height / edge);
    let (w2, h2) = (w * w, h * h);
    let diagonal = (w2 + h2).sqrt();
    let arcs = w * (1.0 / w).atan() + h * (1.0 / h).atan() - diagonal * (1.0 / diagonal).atan();
    let all = 1.0 + w2 + h2;
    let logarithm = ((1.0 + w2) * (1.0 + h2) / all).ln()
        + w2 * (w2 * all / ((1.0 + w2) * (w2 + h2))).ln()
        + h2 * (h2 * all / ((1.0 + h2) * (h2 + w2))).ln();
    (arcs + logarithm / 4.0) / (PI * w)
}

/// Returns the form factor from a disc of radius `r1` to a coaxial one of radius `r2` at distance `h` (Howell C-41).
pub fn coaxial_discs(r1: f64, r2: f64, h: f64) -> f64 {
    let (a, b) = (r1 / h, r2 / h);
    let s = 1.0 + (1.0 + b * b) / (a * a);
    (s - (s * s - 4.0 * (b / a).powi(2)).sqrt()) / 2.0
}

/// Returns the radiosity of any closed surface that emits `emission` and reflects `reflectance` everywhere:
/// B = E + ρB.
pub fn furnace_radiosity(emission: f64, reflectance: f64) -> f64 {
    emission / (1.0 - reflectance)
}

/// Returns the radiosity of top, bottom and each side of a unit cube with one patch per face. All faces reflect
/// `reflectance`, and the top emits 1.
///
/// With f to the opposite and g = (1 − f)/4 to each adjacent face, t − b = 1 − ρf(t − b) and
/// s = ρ(g(t + b) + (2g + f)s), which leaves one unknown, t + b.
pub fn cube_radiosities(reflectance: f64) -> [f64; 3] {
    let f = parallel_rectangles(1.0, 1.0, 1.0);
    let g = (1.0 - f) / 4.0;
    let difference = 1.0 / (1.0 + reflectance * f);
    let side_per_sum = reflectance * g / (1.0 - reflectance * (2.0 * g + f));
    let sum = 1.0 / (1.0 - reflectance * (f + 8.0 * g * side_per_sum));
    [(sum + difference) / 2.0, (sum - difference) / 2.0, side_per_sum * sum]
}

/// Returns the form factor from a surface point to the part of a polygon above the surface's horizon (Lambert 1760):
/// F = −1/2π Σ angle(Rk, Rk+1)·unit(Rk × Rk+1)·n. It is 0 if the polygon shows its back.
pub fn point_to_polygon(point: DVec3, normal: DVec3, polygon: &[DVec3]) -> f64 {
    let clipped = clip_by_plane(polygon, point, normal);
    let sum: f64 = polygon_edges(&clipped)
        .map(|(a, b)| {
            let (a, b) = (a - point, b - point);
            let c = a.cross(b);
            c.length().atan2(a.dot(b)) * c.normalize_or_zero().dot(normal)
        })
        .sum();
    (-sum / (2.0 * PI)).max(0.0)
}

/// Returns the form factor from polygon `a` to polygon `b` without occlusion by the double contour integral
/// F = 1/(2πA) ∮∮ ln r · da·db (Sparrow 1963), the inner edge in closed form, the outer by quadrature.
///
/// The parts behind the other's plane exchange no light and are clipped first; all of the remaining parts see each
/// other, as the integral requires.
pub fn polygon_to_polygon(a: &[DVec3], b: &[DVec3]) -> f64 {
    let (area_a, area_b) = (vector_area(a), vector_area(b));
    let (front_a, front_b) = (clip_by_plane(a, b[0], area_b), clip_by_plane(b, a[0], area_a));
    let sum: f64 = polygon_edges(&front_a)
        .flat_map(|edge| polygon_edges(&front_b).map(move |other| (edge, other)))
        .map(|(edge, other)| integrate_edge_pair(edge, other))
        .sum();
    sum / (2.0 * PI * area_a.length())
}

/// Returns the vector area, half the sum of the cross products of successive corners: along the front normal, with
/// the length of the area.
pub fn vector_area(polygon: &[DVec3]) -> DVec3 {
    polygon_edges(polygon)
        .map(|(a, b)| (a - polygon[0]).cross(b - polygon[0]))
        .sum::<DVec3>()
        * 0.5
}

fn polygon_edges(polygon: &[DVec3]) -> impl Iterator<Item = (DVec3, DVec3)> {
    (0..polygon.len()).map(|k| (polygon[k], polygon[(k + 1) % polygon.len()]))
}

/// Returns ∫∫ ln r da·db over two edges. The outer edge is cut where it passes an end of the inner one, since the
/// inner integral has a kink there if the edges touch.
fn integrate_edge_pair((a, b): (DVec3, DVec3), inner: (DVec3, DVec3)) -> f64 {
    let along = b - a;
    let cosine = along.dot((inner.1 - inner.0).normalize_or_zero());
    if cosine == 0.0 {
        return 0.0;
    }
    let pass = |p: DVec3| ((p - a).dot(along) / along.length_squared()).clamp(0.0, 1.0);
    let (s, t) = (pass(inner.0), pass(inner.1));
    let cuts = [0.0, s.min(t), s.max(t), 1.0];
    let part = |k: usize| tanh_sinh_quadrature(cuts[k], cuts[k + 1], |x| integrate_log_distance(a + along * x, inner));
    cosine * (part(0) + part(1) + part(2))
}

/// Returns ∫ ln|p − q| dq along an edge: ½s·ln(s² + d²) − s + d·atan(s/d), with s along the edge from the foot of p and
/// d the distance of p.
fn integrate_log_distance(p: DVec3, (q, end): (DVec3, DVec3)) -> f64 {
    let direction = (end - q).normalize_or_zero();
    let (from, to) = (direction.dot(q - p), direction.dot(end - p));
    let d = (q - p).reject_from_normalized(direction).length();
    let primitive = |s: f64| {
        let square = s * s + d * d;
        let logarithm = if square > 0.0 { 0.5 * s * square.ln() } else { 0.0 };
        logarithm - s + d * s.atan2(d)
    };
    primitive(to) - primitive(from)
}

/// Integrates `f` by tanh-sinh quadrature (Takahasi & Mori 1974). The ends may be singular; with step 1/16 the error is
/// rounding only for functions that are analytic inside.
fn tanh_sinh_quadrature(from: f64, to: f64, f: impl Fn(f64) -> f64) -> f64 {
    const STEP: f64 = 1.0 / 16.0;
    if from >= to {
        return 0.0;
    }
    let sum: f64 = (-56..=56)
        .map(|k| {
            let u = f64::from(k) * STEP;
            let v = PI / 2.0 * u.sinh();
            let weight = PI / 4.0 * u.cosh() / v.cosh().powi(2);
            weight * f(from + (to - from) / (1.0 + (-2.0 * v).exp()))
        })
        .sum();
    sum * STEP * (to - from)
}

#[cfg(test)]
mod tests;
