//! Links of the hierarchical solve, refined level by level (Hanrahan, Salzman & Aupperle 1991): each pair of
//! a block and a node is skipped, linked, or replaced by pairs with the node's children.

pub mod gpu_linker;
mod level_stages;
mod link_buffers;
pub mod link_probe;
