//! Points of a texel.
//!
//! The twin of `gpu/src/shaders/texel_point.wgsl`: its functions stand where other modules use them, too, and are re-exported.

pub use common::texel_point::{point_on_texel, texel_point};
