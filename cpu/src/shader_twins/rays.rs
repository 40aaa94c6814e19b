//! Visibility between points of patch and texel, by rays: the twin's functions are methods of [`Rays`].
//!
//! The twin of `gpu/src/shaders/rays.wgsl`: its functions stand where other modules use them, too, and are re-exported.

pub use common::rays::Rays;
