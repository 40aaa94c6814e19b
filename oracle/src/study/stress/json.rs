//! `stress.json`.

use super::gates::Gate;
use super::score::Score;
use super::{Study, breaks};
use serde_json::{Value, json};

/// What is the same for all cases.
pub struct Told<'a> {
    /// The count.
    pub score: &'a Score,
    /// The gates.
    pub gates: &'a [Gate],
    /// The GPU's name.
    pub adapter: Option<&'a str>,
    /// Wall-clock seconds of all.
    pub seconds: f64,
}

/// All rows of all cases, and what they come to.
pub fn json(studies: &[Study], told: &Told) -> Value {
    let rows: Vec<_> = studies.iter().flat_map(|study| &study.rows).collect();
    let case = |study: &Study| {
        let mut case = json!(study.about);
        case["breaks"] = json!(breaks::of(study));
        case
    };
    json!({
        "rows": rows,
        "cases": studies.iter().map(case).collect::<Vec<_>>(),
        "score": told.score,
        "false_alarm_share": told.score.default.false_share(),
        "gates": told.gates,
        "adapter": told.adapter,
        "seconds": told.seconds,
    })
}
