//! The GPU solver: hemisphere item buffer, texel pass and choice of the next shooter on the
//! device. No other crate of the workspace uses wgpu.
//!
//! ```
//! use common::mesh::Mesh;
//! use common::scene::{Face, Scene};
//! use common::settings::{Schedule, Transport};
//! use common::shooting::solve;
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
//! let mut watch = |_: &_, _| ControlFlow::Continue(());
//! let run = solve(&mut engine, &Schedule::default(), &mut watch)?;
//! // Facing unit squares at distance 1 exchange 19.98 %, and so do their quarters, on average.
//! let taken = run.shots[0].form_factor_sum;
//! assert!((taken - 0.1998).abs() < 0.002, "{taken}");
//! # Ok(())
//! # }
//! ```

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
