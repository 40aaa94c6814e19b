//! Radiosity on the CPU: progressive refinement ([`solver`]), hierarchical radiosity ([`hierarchy`]) and the dense
//! system over all texels ([`dense`]). Each shader of the GPU has a scalar twin in [`shader_twins`].
//!
//! ```
//! use common::energy::EnergyBalance;
//! use common::mesh::Mesh;
//! use common::scene::{Face, Scene};
//! use common::settings::{Schedule, Transport};
//! use common::shooting::shoot_until_converged;
//! use cpu::CpuSolver;
//! use glam::{DVec3, Vec3};
//! use std::ops::ControlFlow;
//!
//! # fn main() -> common::Result<()> {
//! let square = [DVec3::ZERO, DVec3::X, DVec3::ONE - DVec3::Z, DVec3::Y];
//! let lamp = Face::quad("lamp", square, Vec3::ONE, Vec3::ZERO);
//! let above = square.map(|corner| corner + DVec3::Z);
//! let wall = Face::quad("wall", above, Vec3::ZERO, Vec3::splat(0.5)).reversed();
//! let scene = Scene {
//!     faces: vec![lamp, wall],
//!     ..Scene::default()
//! };
//! let mesh = Mesh::uniform(&scene, 8, 2)?;
//! let mut engine = CpuSolver::new(&mesh, &Transport::default());
//! let mut report = |_: &_, _| ControlFlow::Continue(());
//! let run = shoot_until_converged(&mut engine, &Schedule::default(), &mut report)?;
//! let energy = EnergyBalance::new(&mesh, &run.field, &run.shots);
//! // Facing unit squares at distance 1 exchange 19.98 %: the wall absorbs half of what it gets, and the
//! // black lamp its share of the other half.
//! let absorbed = energy.share_of_emitted(energy.absorbed);
//! assert!((absorbed - 0.1199).abs() < 0.001, "{absorbed}");
//! # Ok(())
//! # }
//! ```

pub mod dense;
pub mod hierarchy;
pub mod links;
pub mod memory;
pub mod occlusion;
pub mod ray_cast;
mod rows;
pub mod shader_twins;
pub mod solver;
mod space_curve;

pub use solver::CpuSolver;
