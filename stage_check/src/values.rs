//! Values for inputs: seeded random ones, those at limits, and ties.

use rand::rngs::Xoshiro256PlusPlus;
use rand::{RngExt, SeedableRng};
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

/// Returns random integers; the same seed gives the same ones.
pub fn random_u32(seed: u64, count: usize) -> Vec<u32> {
    let source = Xoshiro256PlusPlus::seed_from_u64(seed);
    source.random_iter().take(count).collect()
}

/// Returns random numbers in a range; the same seed gives the same ones.
pub fn random_f32(seed: u64, count: usize, range: Range<f32>) -> Vec<f32> {
    let source = Xoshiro256PlusPlus::seed_from_u64(seed);
    let units = source.random_iter::<f32>().take(count);
    units
        .map(|unit| range.start + unit * (range.end - range.start))
        .collect()
}

/// Returns random picks of a few values: of limits, or of two values for many ties.
pub fn random_of<T: Copy>(seed: u64, count: usize, values: &[T]) -> Vec<T> {
    let picks = random_u32(seed, if values.is_empty() { 0 } else { count });
    picks.iter().map(|bits| values[*bits as usize % values.len()]).collect()
}
