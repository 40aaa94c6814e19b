//! Error and time of a solve against one option, all others at stated settings.
//!
//! ```text
//! e(h) ≈ C hᵖ        e: relative RMS of B − E against the truth, means over common texels
//! ```
//! [`sweeps`] is the table of varied options, [`measure`] solves and measures, [`order`] fits p and
//! explains a stalled curve, [`item_buffer`] compares item buffers with rays; [`page`] and
//! [`convergence_json()`] write the results.

pub mod item_buffer;
pub mod measure;
pub mod order;
pub mod page;
pub mod sweeps;

use serde::Serialize;
use serde_json::{Value, json};

/// One solve of a sweep.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct SweepPoint {
    /// Value of the option.
    pub value: f64,
    /// Relative RMS error, worst channel.
    pub error: f64,
    /// Bias of the channel with the largest one.
    pub bias: f64,
    /// Wall-clock seconds of preparation and solve.
    pub seconds: f64,
    /// Number of shots.
    pub shots: u64,
}

/// One measured curve of a sweep.
#[derive(Clone, Debug, Serialize)]
pub struct MeasuredCurve {
    /// Name in the legend.
    pub label: String,
    /// Points, coarse to fine.
    pub points: Vec<SweepPoint>,
    /// Slope of ln e over ln h; none without two points of measurable error.
    pub order: Option<f64>,
    /// Order if the truth has the points' kind of error; only where the truth is a finer point of this
    /// curve.
    #[serde(rename = "order_beside_truth")]
    pub order_beside: Option<f64>,
    /// The finding in words: the gain per step, or the cause of the floor.
    pub finding: String,
    /// True if the last step still reduces the error.
    pub converges: bool,
}

/// One measured sweep.
#[derive(Clone, Debug, Serialize)]
pub struct MeasuredSweep {
    /// Name in headings.
    pub name: &'static str,
    /// Command-line option.
    pub option: &'static str,
    /// Description of the truth.
    pub truth: String,
    /// Settings that are not varied, as in result.json.
    pub base: Value,
    /// Measured curves.
    pub curves: Vec<MeasuredCurve>,
}

/// All measured sweeps of one scene.
#[derive(Clone, Debug, Serialize)]
pub struct ConvergenceStudy {
    /// Name of the scene.
    pub scene: String,
    /// Number of faces.
    pub faces: usize,
    /// Adapter that drew the item buffers.
    pub adapter: String,
    /// Finished sweeps.
    pub sweeps: Vec<MeasuredSweep>,
    /// Comparison of item buffers with rays; empty without an adapter.
    pub item_buffers: Vec<item_buffer::ItemBufferRow>,
}

/// Returns the content of `chart.json`: all scenes in the order given. NaN becomes null.
pub fn convergence_json(studies: &[ConvergenceStudy], seconds: f64) -> Value {
    json!({ "seconds": seconds, "scenes": studies })
}
