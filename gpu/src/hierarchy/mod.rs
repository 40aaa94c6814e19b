//! The links of a hierarchical solve, found level by level: pairs of blocks and nodes come to nothing, to
//! links, or to pairs with the node's parts.

mod buffers;
pub mod finder;
mod stages;
