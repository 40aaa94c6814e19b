//! The CPU solver: visibility by rays through a BVH, or by the scalar twin of the item buffer;
//! deposit, power and escape are the twins of the shaders of the same names. The dense system over
//! all texels is [`matrix`].

pub mod accumulate;
pub mod bound;
mod candidates;
pub mod cover;
pub mod deposit;
pub mod escape;
pub mod hemicube;
pub mod intersect;
pub mod item_buffer;
mod item_buffer_tessellated;
mod lanes;
pub mod link;
pub mod links;
pub mod lookup;
pub mod matrix;
pub mod memory;
pub mod occluders;
pub mod polygon;
pub mod power;
pub mod projection;
pub mod rays;
mod receivers;
mod row;
pub mod sampling;
mod shadow;
pub mod shaft;
pub mod solver;
pub mod tessellate;

pub use solver::CpuSolver;
