//! Comparisons of WGSL, twins, rays and item buffers with each other; planted faults make them fail.

mod agree;
mod explained;
mod faults;
mod item_buffer;
mod rows;
mod stages;
mod study;
