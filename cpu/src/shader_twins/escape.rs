//! Share of a shooter's cosine hemisphere that meets no front: open sky and black backs.

pub use common::escape::{escaped_share, meets_front, nearest_crossing, ray_origin};
