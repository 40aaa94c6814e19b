//! Number of visibility samples that a link needs, and of receiver points for its form factor.

pub use crate::hierarchy::refinement_steps::{
    four_thirds_power, receiver_points_per_side, required_samples, visibility_deviation,
};
