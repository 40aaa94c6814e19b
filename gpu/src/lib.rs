//! Radiosity on the GPU (wgpu): item buffers, links, deposits and the selection of the next shooter run on
//! the device. Adapters and the parsing of WGSL come from `stage_check`; no other crate of the workspace uses wgpu.
//!
//! ```
//! use common::mesh::Mesh;
//! use common::scene::{Face, Scene};
//! use common::settings::{Schedule, Transport};
//! use common::shooting::shoot_until_converged;
//! use glam::{DVec3, Vec3};
//! use gpu::{Gpu, GpuSolver};
//! use std::ops::ControlFlow;
//!
//! # fn main() -> common::Result<()> {
//! let gpu = match Gpu::open(None) {
//!     Err(common::Error::NoAdapter(_)) => return Ok(()),
//!     opened => opened?,
//! };
//! let square = [DVec3::ZERO, DVec3::X, DVec3::ONE - DVec3::Z, DVec3::Y];
//! let lamp = Face::quad("lamp", square, Vec3::ONE, Vec3::ZERO);
//! let above = square.map(|corner| corner + DVec3::Z);
//! let wall = Face::quad("wall", above, Vec3::ZERO, Vec3::splat(0.5)).reversed();
//! let scene = Scene {
//!     faces: vec![lamp, wall],
//!     ..Scene::default()
//! };
//! let mesh = Mesh::uniform(&scene, 8, 2)?;
//! let mut engine = GpuSolver::new(&gpu, &mesh, &Transport::default())?;
//! let mut report = |_: &_, _| ControlFlow::Continue(());
//! let run = shoot_until_converged(&mut engine, &Schedule::default(), &mut report)?;
//! // Facing unit squares at distance 1 exchange 19.98 %, and so do their quarters, on average.
//! let received = run.shots[0].form_factor_sum;
//! assert!((received - 0.1998).abs() < 0.002, "{received}");
//! # Ok(())
//! # }
//! ```
//!
//! In a browser nothing may wait for the device: a function that does never returns there. A page awaits [`Gpu::request`],
//! [`GpuSolver::request`] and [`GpuSolver::request_run`]; the functions that wait are the same ones, driven to their end.
//! Checks, passes and the linker have no other.

pub mod adapter;
mod bindings;
pub mod buffer_ends;
pub mod call_clock;
mod compute_stage;
mod device_queue;
mod dispatch_arguments;
pub mod function_caller;
pub mod function_calls;
pub mod hierarchy;
mod link_recorder;
pub mod link_records;
mod memory_estimate;
mod module_text;
mod pass_stages;
mod pipeline_cache;
pub mod probe;
mod records;
pub mod shader_files;
pub mod shader_mutants;
pub mod shaders;
mod shot_slots;
mod shot_stages;
pub mod solver;
mod solver_buffers;
mod solver_context;
mod stage_readback;
mod stage_times;
mod submission_pace;
mod watch_log;

pub use adapter::{Gpu, list_adapters};
pub use shader_files::{SHADER_STAGES, ShaderFile, ShaderStage};
pub use shaders::ShaderFault;
pub use solver::GpuSolver;
