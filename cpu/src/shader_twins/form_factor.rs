//! Form factor from a texel to the shooting patch.
//!
//! The twin of `gpu/src/shaders/form_factor.wgsl`: its functions stand where other modules use them, too, and are re-exported.

pub use common::form_factor::{
    add_corner, arc_tangent, disc_factor, edge_term, form_factor, is_far, is_low, is_remote, low_edge_term,
    point_weight, polygon_factor, vector_angle,
};
