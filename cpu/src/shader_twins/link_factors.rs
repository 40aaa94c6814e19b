//! Form factors from the spots of a block to a node.

pub use crate::hierarchy::link::{clipped_factors, mean_factor, unclipped_factors};
pub use crate::rows::lanes::lambert_factor;
pub use common::form_factor::polygon_factor_above;
