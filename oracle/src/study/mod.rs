//! Measurements behind the defaults.

pub mod item_buffer;
