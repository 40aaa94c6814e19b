//! WGSL, scalar twins, rays and item buffers held to each other; and that the verdict can fail.

mod agree;
mod explained;
mod faults;
mod item_buffer;
mod rows;
mod stages;
mod study;
