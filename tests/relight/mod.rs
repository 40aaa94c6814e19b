//! Relighting, and the picture of a relit room.

mod asked;
mod composite;
mod paper;
mod scene;
mod shaders;
mod signed;
