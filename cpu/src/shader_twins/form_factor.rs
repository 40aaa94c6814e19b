//! Form factor from a texel to the shooting patch.

pub use common::form_factor::{
    add_corner, arc_tangent, disc_factor, edge_term, form_factor, is_far, is_low, is_remote, low_edge_term,
    point_weight, polygon_factor, vector_angle,
};
