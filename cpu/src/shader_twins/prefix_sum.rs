//! Prefix sums over the pairs of a level: where each pair's children go in the next level, and its link among
//! the links.
//!
//! The twin of `gpu/src/shaders/prefix_sum.wgsl`: its functions stand where other modules use them, too, and are re-exported.

pub use crate::hierarchy::level::{pair_counts, prefix_sum};
