//! Work lists of the pairs whose spots the next stage computes. The GPU refines a level of pairs in common;
//! the CPU refines pair by pair and needs no lists.

pub use crate::hierarchy::level::{WorkList, clear_work_lists};
