//! Intersection of a ray with a face.
//!
//! The twin of `gpu/src/shaders/intersect.wgsl`: its functions stand where other modules use them, too, and are re-exported.

pub use common::intersect::{Crossing, inside_distance, intersect_face, intersect_planes, touches_plane};
