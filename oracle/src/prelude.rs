//! What a program needs that solves scenes, reads results or judges its own: `use oracle::prelude::*`.

pub use crate::solve::anew::{Judged, judge};
pub use crate::solve::solved::Solved;
pub use crate::solve::solver::{Asked, Solver};
pub use crate::solve::watch::{Watch, unwatched};
pub use crate::solve::{Answer, Question, answer};
pub use common::energy::Energy;
pub use common::import::{ImportOptions, load};
pub use common::scene::{Face, Scene};
pub use common::settings::Settings;
pub use common::solution::{Seconds, Solution, Stored};
pub use common::texel;
pub use common::{Error, Result};
pub use glam::{DVec3, Vec3};
pub use gpu::Gpu;
