//! Form factors between a receiver's texel and a shooter: F = (irradiance of the texel) / B_shooter.
//!
//! ```text
//! ΔH_j = F_ji · B_i      F_ji = F_ij · A_i / A_j      (reciprocity)
//! ```
//! H in W/m², F dimensionless, 0 when either faces away. f32 throughout: every function here is
//! the twin of the one of the same name in `gpu/src/shaders/form_factor.wgsl`.

use crate::constants::{CONTACT_DISTANCE, MAX_GRAZING_HEIGHT_RATIO, MISS_DISTANCE, PI, POINT_SOURCE_RADII};
use glam::Vec3;

/// The approximations of F that the solvers share.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum FormFactor {
    /// Eq. 2 of the paper: a point shoots at a disc of the *texel's* area; the area ratio
    /// A_i/Δj, which is missing in its text, is applied.
    Paper,
    /// Wallace 1989: the shooter is a disc of its own area A_i.
    Disc,
    /// Lambert's contour sum: exact from the texel's centre to the shooter's polygon; a remote shooter is a point.
    Polygon,
}

/// Geometry of a shooter: a face or one of its patches. Lengths in the mesh's unit.
#[derive(Clone, Copy, Debug)]
pub struct Shooter {
    /// Centroid.
    pub centre: Vec3,
    /// Unit front normal.
    pub normal: Vec3,
    /// Area.
    pub area: f32,
    /// Largest distance of its points from its centre.
    pub radius: f32,
    /// Outline, counter-clockwise from the front; a triangle repeats its third corner.
    pub corners: [Vec3; 4],
}

/// Returns F from the texel at `position` with unit `normal` and area `texel_area` to `shooter`.
pub fn form_factor(kind: FormFactor, shooter: &Shooter, position: Vec3, normal: Vec3, texel_area: f32) -> f32 {
    let d = position - shooter.centre;
    let height = shooter.normal.dot(d);
    if height <= CONTACT_DISTANCE {
        return 0.0;
    }
    let r2 = d.dot(d);
    let r = r2.sqrt();
    // Each cosine is clamped separately: the product of two negative ones would be positive.
    let cos_i = height / r;
    let cos_j = (-normal.dot(d) / r).max(0.0);
    match kind {
        FormFactor::Paper => disc_factor(cos_i, cos_j, r2, shooter.area, texel_area),
        FormFactor::Disc => disc_factor(cos_i, cos_j, r2, shooter.area, shooter.area),
        FormFactor::Polygon if is_remote(r2, shooter.radius) => disc_factor(cos_i, cos_j, r2, shooter.area, 0.0),
        FormFactor::Polygon => polygon_factor(shooter, position, normal),
    }
}

/// Returns whether a shooter is so far away that it is a point source.
#[inline(always)]
pub fn is_remote(r2: f32, radius: f32) -> bool {
    let reach = POINT_SOURCE_RADII * radius;
    r2 > reach * reach
}

/// Returns whether a texel is so far from a shooter that F is evaluated at its centre only: the mean of F
/// over the texel differs by about (radius/distance)²/2 of F. `reach`: see [`crate::mesh::far_distance`].
#[inline(always)]
pub fn is_far(position: Vec3, centre: Vec3, reach: f32) -> bool {
    let d = position - centre;
    d.dot(d) > reach * reach
}

/// Returns the weight of one of a patch's sample points, here `shooter.centre`: the disc factor of `part`,
/// its share of the patch's area. Never 0 where `f`, the whole patch's form factor, is not: the patch's
/// only point may lie below the texel's horizon.
#[inline(always)]
pub fn point_weight(shooter: &Shooter, position: Vec3, normal: Vec3, part: f32, f: f32) -> f32 {
    let d = position - shooter.centre;
    let r2 = d.dot(d);
    let r = r2.sqrt();
    let cos_i = (shooter.normal.dot(d) / r).max(0.0);
    let cos_j = (-normal.dot(d) / r).max(0.0);
    disc_factor(cos_i, cos_j, r2, part, part) + f * 1e-6
}

/// Returns the factor of equation 2 of the paper, times A_i/Δj. `disc_area` is the texel's in the paper,
/// the shooter's in Wallace 1989.
#[inline(always)]
pub fn disc_factor(cos_i: f32, cos_j: f32, r2: f32, shooter_area: f32, disc_area: f32) -> f32 {
    shooter_area * cos_i * cos_j / (PI * r2 + disc_area)
}

/// The part of a shooter's outline above the receiver's horizon, corner by corner.
#[derive(Clone, Copy)]
pub struct ClippedOutline {
    first: Vec3,
    last: Vec3,
    count: u32,
    /// Σ Γ_k·n of the edges between the corners so far.
    sum: f32,
    low: bool,
}

/// Returns `outline` with one more corner, relative to the receiver's position.
#[inline(always)]
pub fn add_corner(outline: ClippedOutline, corner: Vec3, normal: Vec3) -> ClippedOutline {
    if outline.count == 0 {
        return ClippedOutline {
            first: corner,
            last: corner,
            count: 1,
            ..outline
        };
    }
    let sum = outline.sum + edge_term(outline.last, corner, normal, outline.low);
    ClippedOutline {
        last: corner,
        count: outline.count + 1,
        sum,
        ..outline
    }
}

/// Returns Lambert's sum over the edges of the shooter's outline, clipped to the receiver's horizon:
/// F = −1/2π Σ Γ_k·n (counter-clockwise outlines, hence the sign).
pub fn polygon_factor(shooter: &Shooter, position: Vec3, normal: Vec3) -> f32 {
    let heights = shooter.corners.map(|corner| normal.dot(corner - position));
    // A shooter that only touches the horizon would shine by rounding alone.
    if heights.into_iter().all(|height| height <= CONTACT_DISTANCE) {
        return 0.0;
    }
    let low = is_low(shooter, position, heights.into_iter().fold(-MISS_DISTANCE, f32::max));
    if heights.into_iter().all(|height| height > -CONTACT_DISTANCE) {
        return polygon_factor_above(&shooter.corners, position, normal, low);
    }
    let mut outline = ClippedOutline {
        first: Vec3::ZERO,
        last: Vec3::ZERO,
        count: 0,
        sum: 0.0,
        low,
    };
    let mut a = shooter.corners[3] - position;
    let mut height_a = normal.dot(a);
    for k in 0..4 {
        let b = shooter.corners[k] - position;
        let height_b = normal.dot(b);
        if (height_a > 0.0) != (height_b > 0.0) {
            let crossing = a + (b - a) * (height_a / (height_a - height_b));
            outline = add_corner(outline, crossing, normal);
        }
        if height_b > 0.0 {
            outline = add_corner(outline, b, normal);
        }
        a = b;
        height_a = height_b;
    }
    if outline.count < 3 {
        return 0.0;
    }
    let sum = outline.sum + edge_term(outline.last, outline.first, normal, low);
    (-sum / (2.0 * PI)).max(0.0)
}

/// Returns whether no point of a shooter rises more than [`MAX_GRAZING_HEIGHT_RATIO`] times its distance above the texel's
/// horizon. The distance of the `highest` point is at least that of the shooter's plane, and that of its
/// bounding sphere.
#[inline(always)]
pub fn is_low(shooter: &Shooter, position: Vec3, highest: f32) -> bool {
    let d = position - shooter.centre;
    let beyond = d.dot(d).sqrt() - shooter.radius;
    highest <= MAX_GRAZING_HEIGHT_RATIO * shooter.normal.dot(d).max(beyond)
}

/// Returns [`polygon_factor`] of a shooter above the receiver's horizon, without clipping.
#[inline(always)]
pub fn polygon_factor_above(corners: &[Vec3; 4], position: Vec3, normal: Vec3, low: bool) -> f32 {
    let [a, b, c, d] = corners.map(|corner| corner - position);
    let mut sum = 0.0;
    sum += edge_term(a, b, normal, low);
    sum += edge_term(b, c, normal, low);
    sum += edge_term(c, d, normal, low);
    sum += edge_term(d, a, normal, low);
    (-sum / (2.0 * PI)).max(0.0)
}

/// Returns Γ·n of one edge: the angle between its ends times the unit normal of their plane.
#[inline(always)]
pub fn edge_term(a: Vec3, b: Vec3, normal: Vec3, low: bool) -> f32 {
    if low {
        return low_edge_term(a, b, normal);
    }
    let c = a.cross(b);
    let s = c.dot(c).sqrt();
    if s == 0.0 {
        return 0.0;
    }
    vector_angle(s, a.dot(b)) / s * c.dot(normal)
}

/// Returns Γ·n of an edge less that of its projection onto the texel's plane, θ·x/s − θ₀. The projection
/// of a low shooter does not enclose the texel, so all θ₀ sum to 0; no terms near 1 cancel here:
///
/// ```text
/// θ·x/s − θ₀ = (θ − θ₀)·x/s − θ₀·(s − x)/s      s² = x² + w²      s − x = w²/(s + x)
/// ```
#[inline(always)]
pub fn low_edge_term(a: Vec3, b: Vec3, normal: Vec3) -> f32 {
    let height_a = normal.dot(a);
    let height_b = normal.dot(b);
    let foot_a = a - normal * height_a;
    let foot_b = b - normal * height_b;
    let turn = foot_a.cross(foot_b).dot(normal);
    let x = turn.abs();
    let w = foot_b * height_a - foot_a * height_b;
    let w2 = w.dot(w);
    let s = (x * x + w2).sqrt();
    if s == 0.0 {
        return 0.0;
    }
    let less = w2 / (s + x);
    let c = foot_a.dot(foot_b);
    let rise = height_a * height_b;
    let sine = c * less - rise * x;
    let cosine = c * (c + rise) + x * s;
    let mut wider = vector_angle(sine.abs(), cosine);
    if sine < 0.0 {
        wider = -wider;
    }
    let difference = (wider * x - vector_angle(x, c) * less) / s;
    if turn < 0.0 { -difference } else { difference }
}

/// Returns the angle in 0…π whose sine and cosine are proportional to `s` ≥ 0 and `c`, within a few ulp on
/// every adapter: WGSL allows its own atan2 an error of 4096 ulp.
#[inline(always)]
pub fn vector_angle(s: f32, c: f32) -> f32 {
    let x = c.abs();
    let q = s.min(x) / s.max(x);
    let mut a = arc_tangent(q);
    if s > x {
        a = PI / 2.0 - a;
    }
    if c < 0.0 {
        a = PI - a;
    }
    a
}

/// Returns the arc tangent on 0…1 within 3 ulp (Cephes `atanf`).
#[inline(always)]
pub fn arc_tangent(q: f32) -> f32 {
    let mut x = q;
    let mut offset = 0.0;
    if q > 0.414_213_57 {
        x = (q - 1.0) / (q + 1.0);
        offset = PI / 4.0;
    }
    let z = x * x;
    let p = ((0.080_537_45 * z - 0.138_776_85) * z + 0.199_777_11) * z - 0.333_329_5;
    offset + (p * z * x + x)
}
