//! Links of a pair that may be occluded, from pairs of points on node and spots.

pub use crate::hierarchy::link::{SampledLinkTask, sample_links};
