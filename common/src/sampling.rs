//! Between which points of a texel and of a cell visibility is tested: S pairs, spread evenly over
//! both areas at once.
//!
//! Point s of a pair is the s-th of a four-dimensional additive recurrence (Roberts 2018: the
//! generalised golden ratio φ⁵ = φ + 1), shifted around the torus by a hash of the pair, so that
//! neighbours do not repeat one another's error. Whole numbers throughout: every adapter gets the
//! same points. S = 1 is centre to centre. Twin of `gpu/src/shaders/sampling.wgsl`.

use crate::constants::{NEAR, NEAR_QUAD, NEAR_TRIANGLE};
use crate::texel::TexelKind;
use glam::{Vec3, Vec4};

/// φ⁻ᵏ·2³² for k = 1…4: texel u, texel v, cell u, cell v.
pub const STEPS: [u32; 4] = [3_679_390_609, 3_152_041_523, 2_700_274_805, 2_313_257_605];

/// One round of a permuted congruential generator (Jarzynski & Olano 2020).
#[inline(always)]
pub fn hash(x: u32) -> u32 {
    let state = x.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    (word >> 22) ^ word
}

/// Where in a step of 1/1024 a coordinate lies. Not on the outline, nor on the diagonal along which
/// triangles are folded: a point that touches the wall beside its texel would see past it.
pub const INSIDE: [f32; 2] = [0.5, 0.25];

/// Coordinate `axis` of point `s`, 0 < x < 1, moved by `shift`.
#[inline(always)]
pub fn coordinate(s: u32, axis: usize, shift: u32) -> f32 {
    let x = (s + 1).wrapping_mul(STEPS[axis]).wrapping_add(shift);
    ((x >> 22) as f32 + INSIDE[axis & 1]) / 1024.0
}

/// Point `s` on texel `texel` as cell `cell` sees it.
#[inline(always)]
pub fn texel_uv(s: u32, texel: u32, cell: u32) -> [f32; 2] {
    let first = hash(texel ^ hash(cell));
    let second = hash(first);
    [coordinate(s, 0, first), coordinate(s, 1, second)]
}

/// Point `s` on cell `cell`.
pub fn cell_uv(s: u32, cell: u32) -> [f32; 2] {
    let first = hash(cell);
    let second = hash(first);
    [coordinate(s, 2, first), coordinate(s, 3, second)]
}

/// Place number `place` of the even grid by which a near texel's form factor is averaged.
#[inline(always)]
pub fn near_uv(place: u32, kind: TexelKind) -> [f32; 2] {
    let inset = if kind == TexelKind::Quad {
        NEAR_QUAD
    } else {
        NEAR_TRIANGLE
    };
    [along(place % NEAR, inset), along(place / NEAR, inset)]
}

#[inline(always)]
fn along(k: u32, inset: f32) -> f32 {
    (k as f32 + inset) / NEAR as f32
}

/// The point (u, v) of a planar convex quad, or of a triangle that repeats its third corner; w is
/// the area that (u, v) stands for over the mean, so that averages weigh areas alike.
pub fn outline_point(c: &[Vec3; 4], [u, v]: [f32; 2]) -> Vec4 {
    if c[2] == c[3] {
        let (u, v) = fold(u, v);
        return (c[0] + (c[1] - c[0]) * u + (c[2] - c[0]) * v).extend(1.0);
    }
    let low = c[0] * (1.0 - u) + c[1] * u;
    let high = c[3] * (1.0 - u) + c[2] * u;
    let along_u = (c[1] - c[0]) * (1.0 - v) + (c[2] - c[3]) * v;
    let along_v = (c[3] - c[0]) * (1.0 - u) + (c[2] - c[1]) * u;
    let area = (c[2] - c[0]).cross(c[3] - c[1]).length() * 0.5;
    let weight = if area > 0.0 {
        along_u.cross(along_v).length() / area
    } else {
        1.0
    };
    (low * (1.0 - v) + high * v).extend(weight)
}

/// The unit square's upper triangle turned onto its lower one.
#[inline(always)]
pub fn fold(u: f32, v: f32) -> (f32, f32) {
    if u + v > 1.0 {
        (1.0 - u, 1.0 - v)
    } else {
        (u, v)
    }
}
