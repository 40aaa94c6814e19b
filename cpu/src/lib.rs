//! The CPU solver: visibility by rays through a BVH, or by the scalar twin of the item buffer;
//! deposit, power and escape are the twins of the shaders of the same names. The dense system over
//! all texels is [`matrix`].

pub mod bound;
pub mod collect;
pub mod cover;
pub mod deposit;
pub mod escape;
pub mod exchange;
pub mod hemicube;
pub mod intersect;
pub mod item_buffer;
mod item_buffer_tessellated;
pub mod link;
pub mod links;
pub mod lookup;
pub mod matrix;
pub mod power;
pub mod projection;
pub mod rays;
pub mod sampling;
pub mod solver;
pub mod tessellate;

pub use solver::CpuSolver;
