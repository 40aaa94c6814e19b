//! Points of nodes and of the spots of a block.

pub use crate::hierarchy::block::{grid_uv, is_triangle, spot_point};
pub use common::sampling::outline_point;
