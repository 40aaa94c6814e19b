//! Points of nodes and of the spots of a block.
//!
//! The twin of `gpu/src/shaders/surface_points.wgsl`: its functions stand where other modules use them, too, and are re-exported.

pub use crate::hierarchy::block::{grid_uv, is_triangle, spot_point};
pub use common::sampling::outline_point;
