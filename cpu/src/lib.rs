//! The CPU solver: visibility by rays through a BVH, or by the scalar twin of the item buffer;
//! deposit, power and escape are the twins of the shaders of the same names. The dense system over
//! all texels is [`matrix`].

pub mod hierarchy;
pub mod links;
pub mod matrix;
pub mod memory;
pub mod occlusion;
mod rows;
pub mod solver;
pub mod twin;

pub use solver::CpuSolver;
