//! The pipeline that solves a scene to an error, and the means to judge it: exact answers, a path tracer,
//! the comparison of both solvers, the difference of two results.
//!
//! A scene is solved in a few lines; [`prelude`] has what that needs, and `examples` more:
//!
//! ```
//! use oracle::prelude::*;
//!
//! # fn main() -> Result<()> {
//! let square = [DVec3::ZERO, DVec3::X, DVec3::ONE - DVec3::Z, DVec3::Y];
//! let lamp = Face::quad("lamp", square, Vec3::ONE, Vec3::ZERO);
//! let above = square.map(|corner| corner + DVec3::Z);
//! let wall = Face::quad("wall", above, Vec3::ZERO, Vec3::splat(0.5)).reversed();
//! let scene = Scene {
//!     name: "plates".into(),
//!     faces: vec![lamp, wall],
//!     ..Scene::default()
//! };
//! let target = ErrorTarget {
//!     error: 0.01,
//!     texels: Some(4),
//! };
//! let request = SolveRequest {
//!     task: &scene,
//!     settings: &Settings::default(),
//!     solver: SolverChoice::Hierarchy(target),
//! };
//! let answer = solve_request(&request, &without_progress())?;
//! let Solved { mesh, run, .. } = &answer.solved;
//! let energy = EnergyBalance::new(mesh, &run.field, &run.shots);
//! // Facing unit squares at distance 1 exchange 19.98 %: the wall absorbs half of what it gets, and the
//! // black lamp its share of the other half.
//! let absorbed = energy.share_of_emitted(energy.absorbed);
//! assert!((absorbed - 0.1199).abs() < 0.001, "{absorbed}");
//! # Ok(())
//! # }
//! ```

#![cfg_attr(
    not(test),
    deny(clippy::disallowed_methods, clippy::print_stdout, clippy::print_stderr)
)]

pub mod compare;
pub mod diff;
pub mod exact;
pub mod path_tracer;
pub mod prelude;
pub mod relight;
pub mod solve;
pub mod trace;
