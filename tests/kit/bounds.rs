//! Error bounds of discretised form factors: the centroid rule, and rounding in f32.

use common::energy::EnergyBalance;
use common::shooting::Shot;
use glam::{DVec3, Vec3};
use std::f64::consts::PI;
use std::fmt::Display;

/// Unit roundoff of f32.
pub const U: f64 = 1.0 / (1u64 << 24) as f64;

/// `common::form_factor::arctangent` on 0…1, whose larger branch is π/4 + atan((q − 1)/(q + 1)):
/// three roundings of a quotient ≤ 0.415 (1.3u), π/4 (0.4u), the result (0.5u), the polynomial (0.3u).
pub const ARCTANGENT_ROUNDING: f64 = 2.5 * U;

/// `common::form_factor::angle` on 0…π: the quotient (0.5u), its arctangent, π/2 (0.8u) and the
/// first difference (1u), π (1.5u) and the second (2u).
pub const ANGLE_ROUNDING: f64 = ARCTANGENT_ROUNDING + 5.8 * U;

/// Asserts that a value is what is expected, within a bound.
pub fn assert_near(what: impl Display, value: f64, expected: f64, bound: f64) {
    let off = (value - expected).abs();
    assert!(off <= bound, "{what}: {value} is not {expected} ± {bound:e}");
}

/// Returns a bound of |A·f(centroid) − ∫f| over a triangle or parallelogram with corners centroid + v_k.
///
/// Both have Σ v_k v_kᵀ = 12 × the covariance of a uniform point, so Taylor's second-order term is
/// (A/24) Σ f″(v_k, v_k); the largest f″ over the texel's centre, corners and mid-edges bounds it
/// together with the remainder. Where f jumps (a texel at the end of a shared edge) the error is at
/// most A × the range of f, which is then the smaller of the two.
pub fn centroid_rule(corners: &[DVec3], centroid: DVec3, area: f64, f: &dyn Fn(DVec3) -> f64) -> f64 {
    // Just inside: f may be singular on the outline. The step's own error is 1e−6 of f″.
    const INSIDE: f64 = 0.99;
    const STEP: f64 = 1e-3;
    let n = corners.len();
    let mut points = vec![centroid];
    for k in 0..n {
        let (a, b) = (corners[k] - centroid, corners[(k + 1) % n] - centroid);
        points.extend([centroid + a * INSIDE, centroid + (a + b) * (INSIDE / 2.0)]);
    }
    let second = |p: DVec3, v: DVec3| {
        let step = (v - centroid) * STEP;
        ((f(p + step) - 2.0 * f(p) + f(p - step)) / (STEP * STEP)).abs()
    };
    let curvature: f64 = corners
        .iter()
        .map(|v| points.iter().map(|p| second(*p, *v)).fold(0.0, f64::max))
        .sum();
    let range = points.iter().map(|p| (f(*p) - f(centroid)).abs()).fold(0.0, f64::max);
    area * (curvature / 24.0).min(range)
}

/// Returns the error of a vector between two points of the mesh, relative to its length r: both ends are
/// rounded (|coordinates| ≤ 1, √3·u each), and so is the difference.
fn vector_rounding(r: f64) -> f64 {
    U * (2.0 * 3f64.sqrt() / r + 1.0)
}

/// Returns the rounding of `common::form_factor::polygon` at `point`, mesh units.
///
/// An edge with ends a, b and angle θ gives θ·(a × b)·n/|a × b|. With η the relative error of
/// a × b against |a||b| (both vectors, and 3u for its products and differences), its direction is
/// off by η/sin θ, θ by √2·η and [`ANGLE_ROUNDING`], and n, the quotient and the product by 2u·θ + 3u·θ;
/// four additions of terms ≤ π add 4u·π.
pub fn polygon_rounding(point: DVec3, polygon: &[DVec3]) -> f64 {
    let n = polygon.len();
    let edges = (0..n).map(|k| {
        let (a, b) = (polygon[k] - point, polygon[(k + 1) % n] - point);
        let theta = a.angle_between(b);
        let eta = vector_rounding(a.length()) + vector_rounding(b.length()) + 3.0 * U;
        eta * (theta / theta.sin() + 2f64.sqrt()) + ANGLE_ROUNDING + U * 9.0 * PI
    });
    edges.sum::<f64>() / (2.0 * PI)
}

/// Returns the rounding of the disc factors, mesh units: `d` from shooter to texel, `cosines` there.
///
/// Each cosine is off by the vector's error, the normal's 2u, 3u of the dot product and u of the
/// quotient; r² by twice the vector's error and 3u; two areas, π, three products, the sum and the
/// quotient by u each.
pub fn disc_rounding(d: DVec3, cosines: [f64; 2], shooter_area: f64, disc_area: f64) -> f64 {
    let r = d.length();
    let vector = vector_rounding(r);
    let share = shooter_area / (PI * r * r + disc_area);
    let [i, j] = cosines;
    share * ((i + j) * (vector + 6.0 * U) + i * j * (2.0 * vector + 11.0 * U))
}

/// Returns a bound of the energy imbalance by f32 rounding, as a share of the emitted power (0/0 = 0).
///
/// Each shot: the flux is a sum over ≤ 81 texels in 64 lanes (a product and 7 additions, 8u), ΣF one
/// over texels and ≤ 512 patches (17u), F·B and ρ·F·B are a product each (2u); the two quotients are
/// 1u each, 5u in WGSL: 40u of the power shot, and ΣF times it where the point factors exceed 1.
/// Each addition to a texel rounds its H and its r: 2u of what they hold.
pub fn energy_rounding(energy: &EnergyBalance, area_unit: f64, shots: &[Shot]) -> f64 {
    let sum = |part: [f64; 3]| part.iter().sum::<f64>();
    let shot: f64 = shots
        .iter()
        .map(|s| f64::from(Vec3::from(s.power).element_sum() * s.form_factor_sum.max(1.0)))
        .sum();
    // The log's power is in the mesh's unit of area.
    let shot = shot * area_unit;
    let held = 2.0 * shots.len() as f64 * (sum(energy.absorbed) + sum(energy.unshot));
    if shots.is_empty() {
        0.0
    } else {
        U * (40.0 * shot + held) / sum(energy.emitted)
    }
}
