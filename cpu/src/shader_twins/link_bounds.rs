//! Bounds of what a node and the spots of a block exchange.
//!
//! The twin of `gpu/src/shaders/link_bounds.wgsl`: its functions stand where other modules use them, too, and are re-exported.

pub use crate::hierarchy::link::{bound_link, bound_links, disc_factor_at, facing_disc_factor, height_above};
