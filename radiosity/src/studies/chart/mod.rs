//! Speed against accuracy: one scene solved by many methods, each with its time and its error.
//!
//! All methods compute the mean reflected radiosity B − E on N×N texels per face. A solution on
//! fewer texels is constant on each of them; one on more is averaged.
//!
//! [`methods`] is the table of methods, [`truth`] provides the truth, [`measure`] solves and times
//! one method, [`store`] keeps measurements between runs, [`points`] collects them,
//! [`pareto`] finds the front; [`plot`], [`page`] and [`json`] write the results, [`peers`] reads
//! measurements of other programs. [`vary`] measures the error against one option.

pub mod json;
pub mod labels;
pub mod measure;
pub mod methods;
pub mod page;
pub mod pareto;
pub mod peers;
pub mod plot;
pub mod points;
pub mod store;
pub mod truth;
pub mod vary;

use serde::{Deserialize, Serialize};

/// Solver of a chart's method.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum SolverKind {
    /// CPU: rays or the scalar item buffer.
    Cpu,
    /// GPU: item buffer or rays.
    Gpu,
    /// Dense linear system.
    Matrix,
}

impl SolverKind {
    /// Returns the name shown on the page.
    pub fn name(self) -> &'static str {
        match self {
            Self::Cpu => "CPU",
            Self::Gpu => "GPU",
            Self::Matrix => "matrix",
        }
    }
}

/// Time and error of one solve.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Measurement {
    /// Seconds to build mesh and engine.
    pub prepare: f64,
    /// Seconds of the solve itself.
    pub solve: f64,
    /// The figures, or the reason that there are none.
    pub result: std::result::Result<SolveFigures, String>,
}

impl Measurement {
    /// Returns the total wall-clock seconds.
    pub fn total_seconds(&self) -> f64 {
        self.prepare + self.solve
    }

    /// Returns whether all numbers are finite and in range; a damaged record may hold anything.
    pub fn is_sound(&self) -> bool {
        let time = |x: f64| x.is_finite() && x >= 0.0;
        let judged = self.result.as_ref().map_or(true, |f| {
            let all = [f.error, f.own_error, f.bias, f.imbalance, f.unshot];
            all.iter().all(|x| x.is_finite()) && f.error >= 0.0
        });
        time(self.prepare) && time(self.solve) && judged
    }
}

/// Error and effort of one solve.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SolveFigures {
    /// Relative RMS error on the requested texels, worst channel.
    pub error: f64,
    /// Relative RMS error on the solve's own texels if they are coarser, as in `diff`.
    pub own_error: f64,
    /// Bias of the channel with the largest one.
    pub bias: f64,
    /// Imbalance of the energy.
    pub imbalance: f64,
    /// Unshot power over emitted power.
    pub unshot: f64,
    /// Shots, summed over the passes.
    pub shots: u64,
    /// Passes of the iteration.
    pub passes: u32,
    /// Patches that shot at least once.
    pub linked: u64,
    /// True if the engine shot patch by patch because it supports no passes.
    pub one_by_one: bool,
}
