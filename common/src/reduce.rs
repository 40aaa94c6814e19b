//! Sums in a fixed order, so that the CPU and every GPU add the same numbers the same way.
//!
//! The mip-map of the paper's §3.3 as a tree: N lanes add every Nth term each, then
//! halve. Error ≤ (n/N + log₂N)·ε relative to Σ|term|. Twin of the loops over
//! `stride` in `power.wgsl`, `received.wgsl`, `closure.wgsl` and `select.wgsl`.

use std::ops::Add;

/// Σ term(k) for k < count, in the order of a workgroup of `N` invocations.
#[inline(always)]
pub fn tree_sum<T: Copy + Add<Output = T>, const N: usize>(
    zero: T,
    count: usize,
    term: impl Fn(usize) -> T,
) -> T {
    // Lanes without a term would add zeros.
    match count {
        0..=4 => halved::<T, 4>(zero, count, term),
        5..=16 => halved::<T, 16>(zero, count, term),
        _ => halved::<T, N>(zero, count, term),
    }
}

#[inline(always)]
fn halved<T: Copy + Add<Output = T>, const N: usize>(
    zero: T,
    count: usize,
    term: impl Fn(usize) -> T,
) -> T {
    let mut lane = [zero; N];
    for k in 0..count {
        lane[k % N] = lane[k % N] + term(k);
    }
    let mut stride = N / 2;
    while stride > 0 {
        for k in 0..stride {
            lane[k] = lane[k] + lane[k + stride];
        }
        stride /= 2;
    }
    lane[0]
}
