//! Irradiance of a block's lanes, link by link: a method of [`BlockLink`].

pub use crate::hierarchy::link::BlockLink;
