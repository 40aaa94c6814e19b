//! Work lists of the pairs whose spots the next stage computes. The GPU refines a level of pairs in common;
//! the CPU refines pair by pair and needs no lists.
//!
//! The twin of `gpu/src/shaders/clear_work_lists.wgsl`: its functions stand where other modules use them, too, and are re-exported.

pub use crate::hierarchy::level::{WorkList, clear_work_lists};
