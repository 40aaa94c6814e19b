//! Properties of any solution, checked on random scenes of quads and triangles: on the CPU and on the GPU, with one
//! sample and many, by every iteration.

mod equivalence;
mod light;
mod rounding;
mod scenes;
mod setups;
mod symmetry;
