//! Visibility samples between a texel and a patch: S pairs of points, distributed evenly over both areas at once.
//!
//! Sample s is the s-th point of a four-dimensional additive recurrence (Roberts 2018: the generalised
//! golden ratio φ⁵ = φ + 1), shifted on the torus by a hash of the pair, so that neighbours' errors are
//! independent. The arithmetic is in whole numbers, so that every adapter has the same points. S = 1 is
//! centre to centre. Twin of `gpu/src/shaders/sampling.wgsl`.

use crate::constants::{NEAR_OFFSET_QUAD, NEAR_OFFSET_TRIANGLE, NEAR_POINTS_PER_SIDE};
use crate::texel::TexelKind;
use glam::{Vec3, Vec4};

/// Steps φ⁻ᵏ·2³² of the recurrence for k = 1…4: texel u, texel v, patch u, patch v.
pub const RECURRENCE_STEPS: [u32; 4] = [3_679_390_609, 3_152_041_523, 2_700_274_805, 2_313_257_605];

/// Returns one round of a permuted congruential generator (Jarzynski & Olano 2020).
#[inline(always)]
pub fn pcg_hash(x: u32) -> u32 {
    let state = x.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    (word >> 22) ^ word
}

/// Offsets of u and v in a step of 1/1024. They avoid the outline, and the diagonal along which triangles
/// are folded: a point that touches the wall beside its texel would see past the wall.
pub const STEP_OFFSETS: [f32; 2] = [0.5, 0.25];

/// Returns coordinate `axis` of point `s`, 0 < x < 1, moved by `shift`.
#[inline(always)]
pub fn sample_coordinate(s: u32, axis: usize, shift: u32) -> f32 {
    let x = (s + 1).wrapping_mul(RECURRENCE_STEPS[axis]).wrapping_add(shift);
    ((x >> 22) as f32 + STEP_OFFSETS[axis & 1]) / 1024.0
}

/// Returns sample point `s` on texel `texel` for patch `patch`.
#[inline(always)]
pub fn texel_uv(s: u32, texel: u32, patch: u32) -> [f32; 2] {
    let first = pcg_hash(texel ^ pcg_hash(patch));
    let second = pcg_hash(first);
    [sample_coordinate(s, 0, first), sample_coordinate(s, 1, second)]
}

/// Returns sample point `s` on patch `patch`.
pub fn patch_uv(s: u32, patch: u32) -> [f32; 2] {
    let first = pcg_hash(patch);
    let second = pcg_hash(first);
    [sample_coordinate(s, 2, first), sample_coordinate(s, 3, second)]
}

/// Returns point `place` of the even grid over which a near texel's form factor is averaged.
#[inline(always)]
pub fn near_point_uv(place: u32, kind: TexelKind) -> [f32; 2] {
    let inset = if kind == TexelKind::Quad {
        NEAR_OFFSET_QUAD
    } else {
        NEAR_OFFSET_TRIANGLE
    };
    [
        grid_coordinate(place % NEAR_POINTS_PER_SIDE, inset),
        grid_coordinate(place / NEAR_POINTS_PER_SIDE, inset),
    ]
}

/// Returns the coordinate of column or row `k` of that grid.
#[inline(always)]
pub fn grid_coordinate(k: u32, inset: f32) -> f32 {
    (k as f32 + inset) / NEAR_POINTS_PER_SIDE as f32
}

/// Returns the point (u, v) of a planar convex quad, or of a triangle that repeats its third corner; w is
/// the area that (u, v) represents, over the mean.
pub fn outline_point(c: &[Vec3; 4], [u, v]: [f32; 2]) -> Vec4 {
    if c[2] == c[3] {
        let (u, v) = fold_triangle(u, v);
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

/// Folds the unit square's upper triangle onto its lower one.
#[inline(always)]
pub fn fold_triangle(u: f32, v: f32) -> (f32, f32) {
    if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) }
}
