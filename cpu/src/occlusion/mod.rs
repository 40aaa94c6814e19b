//! Occlusion between faces: convex polygons, shafts, and the occluders that enter a shaft.

pub mod occluders;
pub mod polygon;
pub mod shaft;
