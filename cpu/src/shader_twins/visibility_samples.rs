//! Number of visibility samples that a link needs, and of receiver points for its form factor.
//!
//! The twin of `gpu/src/shaders/visibility_samples.wgsl`: its functions stand where other modules use them, too, and are re-exported.

pub use crate::hierarchy::refinement_steps::{
    four_thirds_power, receiver_points_per_side, required_samples, visibility_deviation,
};
