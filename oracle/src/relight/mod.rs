//! Relighting: virtual objects in a captured room. [`captured_room`] reads the capture, [`stage`] adds the objects,
//! [`task`] relights them as a task of [`crate::solve`], and [`adaptive`] does so to a requested error.

pub mod adaptive;
pub mod captured_room;
mod receiver_blocks;
pub mod stage;
pub mod task;
