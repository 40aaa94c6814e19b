//! Refinement of a pair of a node and a block in four steps: skip, subdivide or link.

pub use crate::hierarchy::level::append_work;
pub use crate::hierarchy::link::{is_above_horizon, visible_fraction};
pub use crate::hierarchy::refinement_steps::{
    is_dark, is_leaf, refine_by_source, refine_by_visibility, reflected_light, request_samples, start_sampling,
};
