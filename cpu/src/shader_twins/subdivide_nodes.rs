//! Subdivision: the children of subdivided nodes are the next level's pairs.

pub use crate::hierarchy::level::subdivide_nodes;
