//! Storage of a level's links behind those of the levels before.
//!
//! The twin of `gpu/src/shaders/store_links.wgsl`: its functions stand where other modules use them, too, and are re-exported.

pub use crate::hierarchy::level::store_links;
