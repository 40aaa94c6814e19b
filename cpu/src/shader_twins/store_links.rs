//! Storage of a level's links behind those of the levels before.

pub use crate::hierarchy::level::store_links;
