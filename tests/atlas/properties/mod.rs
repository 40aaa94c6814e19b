//! What must hold of any scene, whatever its answer: properties, held on scenes drawn at random, by
//! the CPU and by the GPU, by one sample and by many, by every iteration, of quads and of triangles.

mod kit;
mod light;
mod links;
mod objects;
mod places;
mod same;
mod scenes;
mod symmetry;
