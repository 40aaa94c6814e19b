//! Share of a shooter's cosine hemisphere that meets no front: open sky and black backs.
//!
//! The twin of `gpu/src/shaders/escape.wgsl`: its functions stand where other modules use them, too, and are re-exported.

pub use common::escape::{escaped_share, meets_front, nearest_crossing, ray_origin};
