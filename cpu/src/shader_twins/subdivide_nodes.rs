//! Subdivision: the children of subdivided nodes are the next level's pairs.
//!
//! The twin of `gpu/src/shaders/subdivide_nodes.wgsl`: its functions stand where other modules use them, too, and are re-exported.

pub use crate::hierarchy::level::subdivide_nodes;
