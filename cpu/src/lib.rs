//! The CPU solver: visibility by rays through a BVH, or by the scalar twin of the item buffer;
//! deposit, power and escape are the twins of the shaders of the same names.

pub mod bound;
pub mod deposit;
pub mod escape;
pub mod hemicube;
pub mod intersect;
pub mod item_buffer;
mod item_buffer_tessellated;
pub mod lookup;
pub mod power;
pub mod projection;
pub mod rays;
pub mod solver;
pub mod tessellate;

pub use solver::CpuSolver;
