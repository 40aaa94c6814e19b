//! Names for programs that solve scenes, read results or judge their own: `use oracle::prelude::*`.

pub use crate::solve::progress::{ProgressMonitor, without_progress};
pub use crate::solve::residual::{JudgedResult, judge_result};
pub use crate::solve::solved::Solved;
pub use crate::solve::solver::{ErrorTarget, SolverChoice};
pub use crate::solve::{SolveAnswer, SolveRequest, solve_request};
pub use common::energy::EnergyBalance;
pub use common::import::{ImportOptions, load_scene};
pub use common::scene::{Face, Scene};
pub use common::settings::Settings;
pub use common::solution::{PhaseSeconds, Solution, StoredSolution};
pub use common::texel;
pub use common::{Error, Result};
pub use glam::{DVec3, Vec3};
pub use gpu::Gpu;
