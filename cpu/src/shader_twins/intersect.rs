//! Intersection of a ray with a face.

pub use common::intersect::{Crossing, inside_distance, intersect_face, intersect_planes, touches_plane};
