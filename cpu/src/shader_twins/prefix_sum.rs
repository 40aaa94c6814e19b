//! Prefix sums over the pairs of a level: where each pair's children go in the next level, and its link among
//! the links.

pub use crate::hierarchy::level::{pair_counts, prefix_sum};
