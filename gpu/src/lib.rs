//! The GPU solver: hemisphere item buffer, texel pass and choice of the next shooter on the
//! device. No other crate of the workspace uses wgpu.

pub mod adapter;
mod batch;
mod buffers;
mod clock;
mod compiled;
mod context;
mod dispatches;
mod grids;
pub mod hierarchy;
mod host;
mod inspect;
pub mod linked;
mod linker;
mod memory;
mod pace;
mod passes;
mod pipelines;
pub mod probe;
pub mod profile;
mod records;
pub mod shaders;
mod slots;
pub mod solver;
mod stage;

pub use adapter::{Gpu, adapters};
pub use shaders::Fault;
pub use solver::GpuSolver;
