//! Comparison, explanation of differences, exact answers, pictures and the report.
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
//! let asked = Asked {
//!     error: 0.01,
//!     texels: Some(4),
//! };
//! let question = Question {
//!     task: &scene,
//!     settings: &Settings::default(),
//!     solver: Solver::Hierarchy(asked),
//! };
//! let answer = answer(&question, &unwatched())?;
//! let Solved { mesh, run, .. } = &answer.solved;
//! let energy = Energy::new(mesh, &run.field, &run.shots);
//! // Facing unit squares at distance 1 exchange 19.98 %: the wall absorbs half of what it gets, and the
//! // black lamp its share of the other half.
//! let absorbed = energy.share(energy.absorbed);
//! assert!((absorbed - 0.1199).abs() < 0.001, "{absorbed}");
//! # Ok(())
//! # }
//! ```

#![cfg_attr(
    not(test),
    deny(clippy::disallowed_methods, clippy::print_stdout, clippy::print_stderr)
)]

pub mod cli;
pub mod judge;
pub mod merge;
pub mod plan;
pub mod prelude;
pub mod relight;
pub mod show;
pub mod solve;
pub mod study;
