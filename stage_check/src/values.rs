//! Values for inputs: seeded random ones, those at limits, and ties.

use std::ops::Range;

/// Numbers at which branches and roundings change: zeros of both signs, one and its neighbours, the smallest normal
/// number, the largest. Numbers below the smallest normal one are left out: a device may take them for 0.
pub const F32_LIMITS: [f32; 12] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    1.0 - f32::EPSILON / 2.0,
    1.0 + f32::EPSILON,
    f32::EPSILON,
    16_777_216.0,
    f32::MIN_POSITIVE,
    -f32::MIN_POSITIVE,
    f32::MAX,
    f32::MIN,
];

/// Integers at which a sign, a power of two or an addition overflows.
pub const U32_LIMITS: [u32; 6] = [0, 1, 0xffff, 0x7fff_ffff, 0x8000_0000, u32::MAX];

/// Returns random integers; the same seed gives the same ones (SplitMix64, its upper half).
pub fn random_u32(seed: u64, count: usize) -> Vec<u32> {
    let number = |k: u64| {
        let mut z = (seed ^ 0x5851_f42d_4c95_7f2d).wrapping_add(k.wrapping_mul(0x9e37_79b9_7f4a_7c15));
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 32) as u32
    };
    (1..=count as u64).map(number).collect()
}

/// Returns random numbers in a range; the same seed gives the same ones.
pub fn random_f32(seed: u64, count: usize, range: Range<f32>) -> Vec<f32> {
    let unit = |bits: &u32| (bits >> 8) as f32 / 16_777_216.0;
    let width = range.end - range.start;
    let of = |bits| range.start + unit(bits) * width;
    random_u32(seed, count).iter().map(of).collect()
}

/// Returns random picks of a few values: of limits, or of two values for many ties.
pub fn random_of<T: Copy>(seed: u64, count: usize, values: &[T]) -> Vec<T> {
    let picks = random_u32(seed, if values.is_empty() { 0 } else { count });
    picks.iter().map(|bits| values[*bits as usize % values.len()]).collect()
}
