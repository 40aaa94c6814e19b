//! Bounds of what a node and the spots of a block exchange.

pub use crate::hierarchy::link::{
    bound_link, bound_links, disc_factor_at, facing_disc_factor, height_above, long_quad_factor,
};
