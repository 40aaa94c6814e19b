//! Sums in a fixed order, so that the CPU and every GPU add the same numbers in the same order.
//!
//! The mip-map of the paper's §3.3 as a tree: each of N lanes adds every Nth term, then half of the lanes
//! are added to the other half, and so on. Error ≤ (n/N + log₂N)·ε relative to Σ|term|. Twin of the loops over
//! `stride` in `unshot_power.wgsl`, `patch_transfer.wgsl`, `closure.wgsl` and `select.wgsl`.

use std::ops::Add;

/// Returns Σ term(k) for k < count, in the order of a workgroup of `N` invocations.
#[inline(always)]
pub fn tree_sum<T: Copy + Add<Output = T>, const N: usize>(zero: T, count: usize, term: impl Fn(usize) -> T) -> T {
    // Lanes without a term would add zeros.
    match count {
        0..=4 => lane_sum::<T, 4>(zero, count, term),
        5..=16 => lane_sum::<T, 16>(zero, count, term),
        _ => lane_sum::<T, N>(zero, count, term),
    }
}

#[inline(always)]
fn lane_sum<T: Copy + Add<Output = T>, const N: usize>(zero: T, count: usize, term: impl Fn(usize) -> T) -> T {
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
