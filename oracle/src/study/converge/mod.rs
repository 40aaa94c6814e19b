//! Convergence: how the error falls, and the time grows, with each parameter of a solve.
//!
//! ```text
//! e(h) ≈ C hᵖ        e: relative RMS of B − E against the truth, means over common texels
//! ```
//! [`sweeps`] is the table of what is varied, [`run`] solves and measures, [`fit`] finds the
//! order p, [`finding`] says what stops a curve that no longer falls, [`chart`], [`page`] and
//! [`json()`] tell.

pub mod chart;
pub mod finding;
pub mod fit;
pub mod item_buffer;
pub mod page;
pub mod run;
pub mod sweeps;

use serde::Serialize;
use serde_json::{Value, json};

/// One solve of a sweep.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Point {
    /// The parameter.
    pub value: f64,
    /// Relative RMS, the worst channel.
    pub error: f64,
    /// Bias of the channel with the largest.
    pub bias: f64,
    /// Wall-clock, preparation and shooting.
    pub seconds: f64,
    /// Shots.
    pub shots: usize,
}

/// One curve of a sweep, as measured.
#[derive(Clone, Debug, Serialize)]
pub struct MeasuredCurve {
    /// In the legend.
    pub label: String,
    /// Coarse to fine.
    pub points: Vec<Point>,
    /// The slope of ln e over ln h; none without two points of measurable error.
    pub order: Option<f64>,
    /// The order if the truth shares the points' error, where it is the same curve's finer point.
    #[serde(rename = "order_beside_truth")]
    pub order_beside: Option<f64>,
    /// Whether the last step still reduces the error, and if not, why.
    pub finding: String,
    /// Whether it does.
    pub converges: bool,
}

/// One sweep, as measured.
#[derive(Clone, Debug, Serialize)]
pub struct MeasuredSweep {
    /// In headings.
    pub name: &'static str,
    /// On the command line.
    pub option: &'static str,
    /// What the errors are measured against.
    pub truth: String,
    /// Everything that is not varied, as result.json has it.
    pub base: Value,
    /// Its curves.
    pub curves: Vec<MeasuredCurve>,
}

/// All sweeps of one scene.
#[derive(Clone, Debug, Serialize)]
pub struct Study {
    /// The scene.
    pub scene: String,
    /// Its faces.
    pub faces: usize,
    /// Who drew the item buffers.
    pub adapter: String,
    /// Those done.
    pub sweeps: Vec<MeasuredSweep>,
    /// Item buffers against rays; empty without an adapter.
    pub item_buffers: Vec<item_buffer::Row>,
}

/// `converge.json`: all scenes, in the order given. NaN becomes null.
pub fn json(studies: &[Study], seconds: f64) -> Value {
    json!({ "seconds": seconds, "scenes": studies })
}
