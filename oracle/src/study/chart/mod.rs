//! Speed against accuracy: one scene solved in many ways, each with its seconds and its error.
//!
//! The question is the same for all: the mean reflected radiosity B − E on N×N texels a face. An
//! answer on fewer texels is constant on each of them; one on more is averaged.
//!
//! [`methods`] is the table of ways, [`truth`] what they are judged by, [`measure`] solves one,
//! [`store`] keeps what is done, [`study`] sums up the rounds, [`front`] finds the best; [`plot`],
//! [`page`] and [`json`] tell, [`peers`] reads what other programs did.

pub mod front;
pub mod json;
pub mod labels;
pub mod marks;
pub mod measure;
pub mod methods;
pub mod page;
pub mod peers;
pub mod plot;
pub mod store;
pub mod study;
pub mod truth;
mod words;

use serde::{Deserialize, Serialize};

/// Who solves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Solver {
    /// Rays, or the item buffer's twin.
    Cpu,
    /// Item buffer or rays.
    Gpu,
    /// The dense system.
    Matrix,
}

impl Solver {
    /// In words.
    pub fn name(self) -> &'static str {
        match self {
            Self::Cpu => "CPU",
            Self::Gpu => "GPU",
            Self::Matrix => "matrix",
        }
    }
}

/// One solve, timed and judged.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Measurement {
    /// Mesh and engine, seconds.
    pub prepare: f64,
    /// The solve itself, seconds.
    pub solve: f64,
    /// What was found, or why nothing was.
    pub result: std::result::Result<Figures, String>,
}

impl Measurement {
    /// As a user would wait for it.
    pub fn seconds(&self) -> f64 {
        self.prepare + self.solve
    }

    /// Whether all numbers are numbers: a damaged record may hold anything.
    pub fn is_sound(&self) -> bool {
        let time = |x: f64| x.is_finite() && x >= 0.0;
        let judged = self.result.as_ref().map_or(true, |f| {
            let all = [f.error, f.own_error, f.bias, f.imbalance, f.unshot];
            all.iter().all(|x| x.is_finite()) && f.error >= 0.0
        });
        time(self.prepare) && time(self.solve) && judged
    }
}

/// What a solve came to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Figures {
    /// Relative RMS on the texels asked for, the worst channel.
    pub error: f64,
    /// The same on the solve's own texels where they are coarser, as `diff` has it.
    pub own_error: f64,
    /// The channel with the largest.
    pub bias: f64,
    /// Of the energy.
    pub imbalance: f64,
    /// Unshot over emitted power.
    pub unshot: f64,
    /// Shooters, added over the passes.
    pub shots: u64,
    /// Passes.
    pub passes: u32,
    /// Cells that shot at all.
    pub linked: u64,
    /// Whether the engine shot one cell after the other because it knows no passes.
    pub one_by_one: bool,
}
