//! Relighting, and the picture of a relit room.

mod adaptive;
mod composite;
mod paper;
mod rays;
mod scene;
mod shaders;
mod signed;
