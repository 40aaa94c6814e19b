//! What may stand between two faces, or on one.

pub mod occluders;
pub mod polygon;
pub mod shaft;
