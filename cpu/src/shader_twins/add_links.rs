//! Irradiance of a block's lanes, link by link: a method of [`BlockLink`].
//!
//! The twin of `gpu/src/shaders/add_links.wgsl`: its functions stand where other modules use them, too, and are re-exported.

pub use crate::hierarchy::link::BlockLink;
