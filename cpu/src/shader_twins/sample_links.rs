//! Links of a pair that may be occluded, from pairs of points on node and spots.
//!
//! The twin of `gpu/src/shaders/sample_links.wgsl`: its functions stand where other modules use them, too, and are re-exported.

pub use crate::hierarchy::link::{SampledLinkTask, sample_links};
