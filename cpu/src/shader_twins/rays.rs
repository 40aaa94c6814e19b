//! Visibility between points of patch and texel, by rays: the twin's functions are methods of [`Rays`].

pub use common::rays::Rays;
