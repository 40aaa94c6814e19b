//! Form factor from a receiver's texel to a shooter: F = (light received per area) / B_shooter.
//!
//! ```text
//! ΔH_j = F_ji · B_i      F_ji = F_ij · A_i / A_j      (reciprocity)
//! ```
//! H in W/m², F dimensionless, 0 when either faces away. f32 throughout: every function here is
//! the twin of the one of the same name in `gpu/src/shaders/form_factor.wgsl`.

use crate::constants::{CONTACT, LOW, MISS, PI, POINT};
use glam::Vec3;

/// The approximations of F that the solvers share.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum FormFactor {
    /// Eq. 2 of the paper: a point shoots at a disc of the *texel's* area; the area ratio
    /// A_i/Δj that its text leaves out is applied.
    Paper,
    /// Wallace 1989: the shooter is a disc of its own area A_i.
    Disc,
    /// Lambert: exact from the texel's centre to the shooter's polygon, a point where it is remote.
    Polygon,
}

/// What shoots: a face or one of its cells. Lengths in the mesh's unit.
#[derive(Clone, Copy, Debug)]
pub struct Shooter {
    /// Centroid.
    pub centre: Vec3,
    /// Unit front normal.
    pub normal: Vec3,
    /// Area.
    pub area: f32,
    /// No point of it is farther from its centre.
    pub radius: f32,
    /// Outline, counter-clockwise from the front; a triangle repeats its third corner.
    pub corners: [Vec3; 4],
}

/// F from the texel at `position` with unit `normal` and area `texel_area` to `shooter`.
pub fn form_factor(
    kind: FormFactor,
    shooter: &Shooter,
    position: Vec3,
    normal: Vec3,
    texel_area: f32,
) -> f32 {
    let d = position - shooter.centre;
    let height = shooter.normal.dot(d);
    if height <= CONTACT {
        return 0.0;
    }
    let r2 = d.dot(d);
    let r = r2.sqrt();
    // Each cosine is clamped on its own: two negative ones would multiply to light.
    let cos_i = height / r;
    let cos_j = (-normal.dot(d) / r).max(0.0);
    match kind {
        FormFactor::Paper => disc(cos_i, cos_j, r2, shooter.area, texel_area),
        FormFactor::Disc => disc(cos_i, cos_j, r2, shooter.area, shooter.area),
        FormFactor::Polygon if remote(r2, shooter.radius) => {
            disc(cos_i, cos_j, r2, shooter.area, 0.0)
        }
        FormFactor::Polygon => polygon(shooter, position, normal),
    }
}

/// Whether a shooter is so far away that it is a point.
#[inline(always)]
pub fn remote(r2: f32, radius: f32) -> bool {
    let reach = POINT * radius;
    r2 > reach * reach
}

/// Whether a texel is so far from a shooter that its centre stands for all of it: the mean of F
/// over the texel differs by about (radius/distance)²/2 of F. `reach`: see [`crate::mesh::reach`].
#[inline(always)]
pub fn far(position: Vec3, centre: Vec3, reach: f32) -> bool {
    let d = position - centre;
    d.dot(d) > reach * reach
}

/// The weight of one of the points in which a cell is looked at, here `shooter.centre`: the disc
/// factor of `part`, its share of the cell's area. Never 0 where `f`, the whole cell's form
/// factor, is not: the cell's only point may lie below the texel's horizon.
#[inline(always)]
pub fn weight(shooter: &Shooter, position: Vec3, normal: Vec3, part: f32, f: f32) -> f32 {
    let d = position - shooter.centre;
    let r2 = d.dot(d);
    let r = r2.sqrt();
    let cos_i = (shooter.normal.dot(d) / r).max(0.0);
    let cos_j = (-normal.dot(d) / r).max(0.0);
    disc(cos_i, cos_j, r2, part, part) + f * 1e-6
}

/// Equation 2 of the paper, times A_i/Δj: `disc_area` is the texel's there, the shooter's in Wallace.
#[inline(always)]
pub fn disc(cos_i: f32, cos_j: f32, r2: f32, shooter_area: f32, disc_area: f32) -> f32 {
    shooter_area * cos_i * cos_j / (PI * r2 + disc_area)
}

/// Lambert's sum over the edges of the shooter's outline, clipped to the receiver's horizon where
/// it goes below: F = −1/2π Σ Γ_k·n (counter-clockwise outlines, hence the sign).
pub fn polygon(shooter: &Shooter, position: Vec3, normal: Vec3) -> f32 {
    let heights = shooter.corners.map(|corner| normal.dot(corner - position));
    // What only touches the horizon shines into a texel by its rounding alone.
    if heights.into_iter().all(|height| height <= CONTACT) {
        return 0.0;
    }
    let low = is_low(shooter, position, heights.into_iter().fold(-MISS, f32::max));
    if heights.into_iter().all(|height| height > -CONTACT) {
        return polygon_above(&shooter.corners, position, normal, low);
    }
    let mut clipped = [Vec3::ZERO; 5];
    let mut count = 0;
    let mut a = shooter.corners[3] - position;
    let mut height_a = normal.dot(a);
    for k in 0..4 {
        let b = shooter.corners[k] - position;
        let height_b = normal.dot(b);
        if (height_a > 0.0) != (height_b > 0.0) {
            clipped[count] = a + (b - a) * (height_a / (height_a - height_b));
            count += 1;
        }
        if height_b > 0.0 {
            clipped[count] = b;
            count += 1;
        }
        a = b;
        height_a = height_b;
    }
    if count < 3 {
        return 0.0;
    }
    let mut sum = 0.0;
    for k in 0..count {
        let next = if k + 1 == count { 0 } else { k + 1 };
        sum += edge(clipped[k], clipped[next], normal, low);
    }
    (-sum / (2.0 * PI)).max(0.0)
}

/// Whether nothing of a shooter rises more than [`LOW`] times its distance above the texel's
/// horizon: `highest`, at least, is as far as its plane, and as its outer sphere.
#[inline(always)]
pub fn is_low(shooter: &Shooter, position: Vec3, highest: f32) -> bool {
    let d = position - shooter.centre;
    let beyond = d.dot(d).sqrt() - shooter.radius;
    highest <= LOW * shooter.normal.dot(d).max(beyond)
}

/// [`polygon`] of a shooter that lies above the receiver's horizon: the same sum, nothing to clip.
#[inline(always)]
pub fn polygon_above(corners: &[Vec3; 4], position: Vec3, normal: Vec3, low: bool) -> f32 {
    let [a, b, c, d] = corners.map(|corner| corner - position);
    let mut sum = 0.0;
    sum += edge(a, b, normal, low);
    sum += edge(b, c, normal, low);
    sum += edge(c, d, normal, low);
    sum += edge(d, a, normal, low);
    (-sum / (2.0 * PI)).max(0.0)
}

/// Γ·n of one edge: the angle between its ends times the unit normal of their plane.
#[inline(always)]
pub fn edge(a: Vec3, b: Vec3, normal: Vec3, low: bool) -> f32 {
    if low {
        return low_edge(a, b, normal);
    }
    let c = a.cross(b);
    let s = c.dot(c).sqrt();
    if s == 0.0 {
        return 0.0;
    }
    angle(s, a.dot(b)) / s * c.dot(normal)
}

/// Γ·n of an edge less that of its foot on the texel's plane, θ·x/s − θ₀. The foot of a low shooter
/// does not go round the texel, so all θ₀ sum to 0; here nothing near 1 is left to cancel:
///
/// ```text
/// θ·x/s − θ₀ = (θ − θ₀)·x/s − θ₀·(s − x)/s      s² = x² + w²      s − x = w²/(s + x)
/// ```
pub fn low_edge(a: Vec3, b: Vec3, normal: Vec3) -> f32 {
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
    let mut wider = angle(sine.abs(), cosine);
    if sine < 0.0 {
        wider = -wider;
    }
    let difference = (wider * x - angle(x, c) * less) / s;
    if turn < 0.0 { -difference } else { difference }
}

/// The angle in 0…π whose sine and cosine are proportional to `s` ≥ 0 and `c`. Written out
/// because WGSL allows its own atan2 an error of 4096 ulp; here it is a few ulp on every adapter.
#[inline(always)]
pub fn angle(s: f32, c: f32) -> f32 {
    let x = c.abs();
    let q = s.min(x) / s.max(x);
    let mut a = arctangent(q);
    if s > x {
        a = PI / 2.0 - a;
    }
    if c < 0.0 {
        a = PI - a;
    }
    a
}

/// atan on 0…1 within 3 ulp (Cephes `atanf`).
#[inline(always)]
pub fn arctangent(q: f32) -> f32 {
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
