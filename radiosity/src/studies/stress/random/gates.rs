//! Acceptance gates on random scenes.

use super::RandomFindings;
use super::ratio::{EstimateRatios, HIGH_RATIO, LOW_RATIO};
use crate::report::format::{format_number, format_percent};
use crate::studies::stress::gates::{AtlasGate, MAX_FALSE_ALARM_SHARE, describe_bad_rows, make_gate};
use crate::studies::stress::outcome::{self, WarningOutcome, warning_outcome as of_side};
use crate::studies::stress::{RELATIVE_RMS, SolverSide};

/// Range of the median of estimate over error.
pub const MEDIAN_RANGE: [f64; 2] = [0.8, 1.5];
/// Largest share of estimates below [`LOW_RATIO`] of the error.
pub const MAX_LOW_SHARE: f64 = 0.03;
/// Largest share of estimates above [`HIGH_RATIO`] of the error.
pub const MAX_HIGH_SHARE: f64 = 0.05;

/// Evaluates all gates.
pub fn evaluate_gates(findings: &RandomFindings, ratios: &EstimateRatios) -> Vec<AtlasGate> {
    let count = |wanted: WarningOutcome| describe_bad(findings, |side| of_side(RELATIVE_RMS, side) == wanted);
    let alarms = count(WarningOutcome::FalseAlarm);
    let sides = findings
        .all
        .iter()
        .flat_map(|result| outcome::solver_sides(&result.row))
        .count();
    let many = alarms.len() as f64 > MAX_FALSE_ALARM_SHARE * sides as f64;
    let ratio = |name, held: bool, value: String| make_gate(name, (!held).then_some(value).into_iter().collect());
    let held = |share: f64, max_share: f64| ratios.answers == 0 || share <= max_share;
    let [low, high] = MEDIAN_RANGE;
    let within = ratios.answers == 0 || (low..=high).contains(&ratios.median);
    vec![
        make_gate(
            "nothing panics, hangs or is not a number",
            describe_bad(findings, SolverSide::is_broken),
        ),
        make_gate("right to 2 %, or warned about", count(WarningOutcome::Missed)),
        make_gate(
            "false alarms in at most 5 % of the answers",
            if many { alarms } else { Vec::new() },
        ),
        ratio(
            "estimate over error: median within 0.8 and 1.5",
            within,
            format_number(ratios.median),
        ),
        ratio(
            "estimate below half of the error: at most 3 %",
            held(ratios.below, MAX_LOW_SHARE),
            format_percent(ratios.below),
        ),
        ratio(
            "estimate above three times the error: at most 5 %",
            held(ratios.above, MAX_HIGH_SHARE),
            format_percent(ratios.above),
        ),
    ]
}

fn describe_bad(findings: &RandomFindings, bad: impl Fn(&SolverSide) -> bool) -> Vec<String> {
    let rows = findings.all.iter().map(|result| &result.row);
    describe_bad_rows(rows, |_, _, side| bad(side)).collect()
}

/// Formats the limits on [`EstimateRatios`] for the page.
pub fn format_limits() -> String {
    format!(
        "median {}…{}, below {} in at most {}, above {} in at most {}",
        format_number(MEDIAN_RANGE[0]),
        format_number(MEDIAN_RANGE[1]),
        format_number(LOW_RATIO),
        format_percent(MAX_LOW_SHARE),
        format_number(HIGH_RATIO),
        format_percent(MAX_HIGH_SHARE)
    )
}

#[cfg(test)]
mod tests {
    use super::super::super::fixture::{make_row, make_side};
    use super::super::{RandomFindings, RandomResult};
    use super::*;

    /// Returns the broken gates of answers with error, estimate and warning code (may be empty).
    fn broken(answers: &[(f64, f64, &str)]) -> Vec<&'static str> {
        let found = |(seed, (error, estimate, code)): (usize, &(f64, f64, &str))| RandomResult {
            seed: seed as u64,
            description: String::new(),
            texels: 6,
            row: make_row(
                seed as f64,
                SolverSide {
                    estimate: Some(*estimate),
                    ..make_side(Some(*error), code)
                },
                None,
            ),
        };
        let findings = RandomFindings {
            all: answers.iter().enumerate().map(found).collect(),
            worst: Vec::new(),
        };
        let gates = evaluate_gates(&findings, &findings.estimate_ratios());
        let broken = gates.into_iter().filter(|gate| !gate.held);
        broken.map(|gate| gate.name).collect()
    }

    #[test]
    fn each_gate_can_break() {
        let good = [(0.01, 0.011, ""); 40];
        let with = |more: &[(f64, f64, &str)]| broken(&[&good[..], more].concat());
        assert!(with(&[]).is_empty() && broken(&[]).is_empty());
        assert!(with(&[(0.03, 0.03, "cells")]).is_empty());
        assert!(with(&[(0.01, 0.004, ""), (0.01, 0.031, "")]).is_empty());
        for (more, name) in [
            (&[(f64::NAN, 0.01, "cells")][..], "nothing panics"),
            (&[(0.021, 0.021, "")], "right to 2 %"),
            (&[(0.01, 0.01, "cells"); 3], "false alarms"),
            (&[(0.01, 0.02, ""); 41], "estimate over error"),
            (&[(0.01, 0.004, ""); 2], "estimate below half"),
            (&[(0.01, 0.031, ""); 3], "estimate above three"),
        ] {
            let found = with(more);
            assert!(found.iter().any(|gate| gate.starts_with(name)), "{name}: {found:?}");
            assert!(found.len() == 1 || name == "nothing panics", "{found:?}");
        }
    }
}
