//! Comparisons of WGSL, twins, rays and item buffers with each other; planted faults make them fail.

mod divergence;
mod explained;
mod faults;
mod function_calls;
mod item_buffer;
mod lookup;
mod named_faults;
mod races;
mod rows;
mod stages;
mod study;
