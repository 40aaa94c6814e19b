//! The GPU solver: hemisphere item buffer, texel pass and choice of the next shooter on the
//! device. Nothing else in the workspace knows wgpu.

pub mod adapter;
mod batch;
mod buffers;
mod memory;
mod pipelines;
mod records;
pub mod shaders;
pub mod solver;

pub use adapter::{Gpu, adapters};
pub use shaders::Fault;
pub use solver::GpuSolver;
