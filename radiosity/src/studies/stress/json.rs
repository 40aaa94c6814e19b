//! Content of `stress.json`.

use super::gates::AtlasGate;
use super::score::WarningScore;
use super::{CaseStudy, breaks};
use serde_json::{Value, json};

/// Summary of a run over all cases.
pub struct AtlasSummary<'a> {
    /// Count of caught and missed errors.
    pub score: &'a WarningScore,
    /// Acceptance gates.
    pub gates: &'a [AtlasGate],
    /// Name of the GPU.
    pub adapter: Option<&'a str>,
    /// Wall-clock seconds of the run.
    pub seconds: f64,
}

/// Returns all rows and cases with the summary.
pub fn atlas_json(studies: &[CaseStudy], summary: &AtlasSummary) -> Value {
    let rows: Vec<_> = studies.iter().flat_map(|study| &study.rows).collect();
    let case = |study: &CaseStudy| {
        let mut case = json!(study.info);
        case["breaks"] = json!(breaks::find_breaks(study));
        case
    };
    json!({
        "rows": rows,
        "cases": studies.iter().map(case).collect::<Vec<_>>(),
        "score": summary.score,
        "false_alarm_share": summary.score.default.false_alarm_share(),
        "gates": summary.gates,
        "adapter": summary.adapter,
        "seconds": summary.seconds,
    })
}
