//! Points of a texel.

pub use common::texel_point::{point_on_texel, texel_point};
