//! Evaluates the rows of an atlas: counts caught and missed errors, finds break points, compares error
//! estimates with errors and checks the acceptance gates.

use super::methods::SOLVE_METHODS;
use super::random::COMMAND_NAME;
use super::{AtlasRow, CaseStudy, ErrorMeasure, Processor, SolverSide, WarningOutcome};
use crate::report::format::{format_number, format_percent};
use common::settings::Visibility;
use serde::Serialize;
use serde_json::{Value, json};
use std::collections::{BTreeMap, BTreeSet};

/// Largest share of false alarms among the default's results.
const MAX_FALSE_ALARM_SHARE: f64 = 0.05;
/// Name under which refusals are counted with the warning codes.
const REFUSED_CODE: &str = "(refused)";
/// Errors up to this one are comparable with the traced truth's own; their estimates are not judged.
pub const MIN_JUDGED_ERROR: f64 = 0.002;
/// Largest relative standard error of a judged error.
const MAX_RELATIVE_NOISE: f64 = 0.25;
/// An estimate below this share of the error is far too low.
pub const LOW_RATIO: f64 = 0.5;
/// An estimate above this multiple of the error is far too high.
pub const HIGH_RATIO: f64 = 3.0;

/// Results of a run with their evaluation.
pub struct Atlas {
    /// Results of each case.
    pub studies: Vec<CaseStudy>,
    /// Counts of caught and missed errors.
    pub score: WarningScore,
    /// Estimates against errors, of random scenes.
    pub estimate: Option<EstimateRatios>,
    /// Acceptance gates.
    pub gates: Vec<AtlasGate>,
    /// Name of the GPU.
    pub adapter: Option<String>,
    /// Wall-clock seconds of the run.
    pub seconds: f64,
}

impl Atlas {
    /// Evaluates the results.
    pub fn new(studies: Vec<CaseStudy>, adapter: Option<String>, seconds: f64) -> Self {
        let score = score_warnings(&studies);
        let random = studies.iter().any(|study| study.case.name == COMMAND_NAME);
        let sides = || studies.iter().flat_map(CaseStudy::sides).map(|(_, _, side)| side);
        let estimate = random.then(|| collect_ratios(sides()));
        Self {
            gates: evaluate_gates(&studies, &score, estimate.as_ref()),
            studies,
            score,
            estimate,
            adapter,
            seconds,
        }
    }

    /// Returns the content of `stress.json`.
    pub fn to_json(&self) -> Value {
        let rows: Vec<&AtlasRow> = self.studies.iter().flat_map(|study| &study.rows).collect();
        let case = |study: &CaseStudy| {
            let mut case = json!(study.case);
            case["breaks"] = json!(find_breaks(study));
            case
        };
        json!({
            "rows": rows,
            "cases": self.studies.iter().map(case).collect::<Vec<_>>(),
            "score": self.score,
            "estimate": self.estimate,
            "gates": self.gates,
            "adapter": self.adapter,
            "seconds": self.seconds,
        })
    }
}

/// Number of results of each outcome.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct WarningCounts {
    /// Beyond the limit or refused, with a warning.
    pub caught: usize,
    /// Beyond the limit, without a warning.
    pub missed: usize,
    /// Within the limit, with a warning.
    pub false_alarms: usize,
    /// Within the limit, without a warning.
    pub quiet: usize,
}

impl WarningCounts {
    /// Counts outcomes.
    pub fn of_outcomes<'a>(sides: impl IntoIterator<Item = &'a SolverSide>) -> Self {
        let mut counts = Self::default();
        for side in sides {
            match side.outcome {
                WarningOutcome::Caught => counts.caught += 1,
                WarningOutcome::Missed => counts.missed += 1,
                WarningOutcome::FalseAlarm => counts.false_alarms += 1,
                WarningOutcome::Quiet => counts.quiet += 1,
                WarningOutcome::Uncounted => {}
            }
        }
        counts
    }

    /// Returns the share of false alarms.
    pub fn false_alarm_share(&self) -> f64 {
        let all = self.caught + self.missed + self.false_alarms + self.quiet;
        self.false_alarms as f64 / all.max(1) as f64
    }
}

/// Number of results with a warning code.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct CodeCount {
    /// Code of the warning.
    pub code: String,
    /// Results beyond the limit with the code.
    pub caught: usize,
    /// Results within the limit with the code.
    pub false_alarms: usize,
}

/// Counts of the atlas.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct WarningScore {
    /// Counts of the default method.
    pub default: WarningCounts,
    /// Counts of all methods.
    pub all: WarningCounts,
    /// Counts of each warning code over all methods, by errors caught.
    pub codes: Vec<CodeCount>,
}

fn score_warnings(studies: &[CaseStudy]) -> WarningScore {
    let all = || {
        studies
            .iter()
            .flat_map(|study| study.sides().map(move |found| (study, found)))
    };
    let counted = all().filter(|(_, (_, _, side))| side.outcome != WarningOutcome::Uncounted);
    let mut counts: BTreeMap<&str, [usize; 2]> = BTreeMap::new();
    for (_, (_, _, side)) in counted {
        let safe = matches!(side.outcome, WarningOutcome::FalseAlarm | WarningOutcome::Quiet);
        let codes = side.warnings.iter().map(String::as_str);
        let codes: BTreeSet<&str> = codes.chain(side.is_refused().then_some(REFUSED_CODE)).collect();
        for code in codes {
            counts.entry(code).or_default()[usize::from(safe)] += 1;
        }
    }
    let code = |(code, [caught, false_alarms]): (&str, [usize; 2])| CodeCount {
        code: code.to_owned(),
        caught,
        false_alarms,
    };
    let mut codes: Vec<CodeCount> = counts.into_iter().map(code).collect();
    codes.sort_by_key(|count| std::cmp::Reverse(count.caught));
    let of_default = all().filter(|(study, (row, ..))| study.is_default(row));
    WarningScore {
        default: WarningCounts::of_outcomes(of_default.map(|(_, (_, _, side))| side)),
        all: WarningCounts::of_outcomes(all().map(|(_, (_, _, side))| side)),
        codes,
    }
}

/// Break points of one method on one solver: the first values at which the error exceeds the limits; none
/// if it never does.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BreakPoint {
    /// Name of the method.
    pub method: &'static str,
    /// The solver.
    pub solver: Processor,
    /// First value at which it is not safe.
    pub degrades_at: Option<f64>,
    /// First value beyond the second limit.
    pub fails_at: Option<f64>,
}

/// Returns the break points of all methods of a case.
pub fn find_breaks(study: &CaseStudy) -> Vec<BreakPoint> {
    let columns = study
        .case
        .methods
        .iter()
        .flat_map(|method| Processor::BOTH.map(|solver| (method.name, solver)));
    let found = columns.filter_map(|(method, solver)| {
        let sides = study
            .sides()
            .filter(|(row, processor, _)| row.method == method && *processor == solver);
        let errors: Vec<(f64, Option<f64>)> = sides.map(|(row, _, side)| (row.value, side.error)).collect();
        let [degrades_at, fails_at] = study.case.measure.limits().map(|limit| {
            let within = |error: Option<f64>| error.is_some_and(|error| error <= limit);
            errors
                .iter()
                .find(|(_, error)| !within(*error))
                .map(|(value, _)| *value)
        });
        (!errors.is_empty()).then_some(BreakPoint {
            method,
            solver,
            degrades_at,
            fails_at,
        })
    });
    found.collect()
}

/// Statistics of estimate over error, over the answers with an error above [`MIN_JUDGED_ERROR`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct EstimateRatios {
    /// Number of answers.
    pub answers: usize,
    /// Number of answers without an estimate; they count as estimate 0.
    pub unknown: usize,
    /// Median of the ratios.
    pub median: f64,
    /// Share of the ratios below [`LOW_RATIO`].
    pub below: f64,
    /// Share of the ratios above [`HIGH_RATIO`].
    pub above: f64,
}

/// Returns the ratio of an answer; none if it is not judged.
fn estimate_ratio(side: &SolverSide) -> Option<f64> {
    let known = |error: &f64| *error > MIN_JUDGED_ERROR && side.noise <= MAX_RELATIVE_NOISE * error;
    let error = side.error.filter(known)?;
    Some(side.estimate.unwrap_or(0.0) / error)
}

fn collect_ratios<'a>(sides: impl Iterator<Item = &'a SolverSide>) -> EstimateRatios {
    let judged: Vec<(&SolverSide, f64)> = sides.filter_map(|side| Some((side, estimate_ratio(side)?))).collect();
    let mut ratios: Vec<f64> = judged.iter().map(|(_, ratio)| *ratio).collect();
    ratios.sort_by(f64::total_cmp);
    let n = ratios.len();
    if n == 0 {
        return EstimateRatios::default();
    }
    let share = |far: fn(f64) -> bool| ratios.iter().filter(|ratio| far(**ratio)).count() as f64 / n as f64;
    EstimateRatios {
        answers: n,
        unknown: judged.iter().filter(|(side, _)| side.estimate.is_none()).count(),
        median: 0.5 * (ratios[(n - 1) / 2] + ratios[n / 2]),
        below: share(|ratio| ratio < LOW_RATIO),
        above: share(|ratio| ratio > HIGH_RATIO),
    }
}

/// One requirement and its violations.
#[derive(Clone, Debug, Serialize)]
pub struct AtlasGate {
    /// Description of the requirement.
    pub name: &'static str,
    /// True if it holds.
    pub held: bool,
    /// Rows that violate it.
    pub broken: Vec<String>,
}

fn evaluate_gates(studies: &[CaseStudy], score: &WarningScore, estimate: Option<&EstimateRatios>) -> Vec<AtlasGate> {
    let bad = |is_bad: fn(&CaseStudy, &AtlasRow, Processor, &SolverSide) -> bool| -> Vec<String> {
        let all = studies
            .iter()
            .flat_map(|study| study.sides().map(move |found| (study, found)));
        let bad = all.filter(|(study, (row, processor, side))| is_bad(study, row, *processor, side));
        bad.map(|(_, (row, processor, side))| describe_side(row, processor, side))
            .collect()
    };
    let mut alarms = Vec::new();
    if score.default.false_alarm_share() > MAX_FALSE_ALARM_SHARE {
        alarms = bad(|study, row, _, side| study.is_default(row) && side.outcome == WarningOutcome::FalseAlarm);
    }
    let mut gates = vec![
        (
            "nothing panics, hangs or is not a number",
            bad(|_, _, _, side| side.is_broken()),
        ),
        (
            "the default is right to 2 %, or warned about",
            bad(|study, row, _, side| study.is_default(row) && side.outcome == WarningOutcome::Missed),
        ),
        ("false alarms in at most 5 % of the default's answers", alarms),
        (
            "no light through walls by rays",
            bad(|study, row, processor, side| {
                let leaks = side.error.is_none_or(|error| error > ErrorMeasure::Leak.limits()[0]);
                study.case.measure == ErrorMeasure::Leak && uses_rays(row, processor) && leaks
            }),
        ),
    ];
    if let Some(ratios) = estimate {
        let unless = |held: bool, value: String| {
            if held || ratios.answers == 0 {
                Vec::new()
            } else {
                vec![value]
            }
        };
        gates.extend([
            (
                "estimate over error: median within 0.8 and 1.5",
                unless((0.8..=1.5).contains(&ratios.median), format_number(ratios.median)),
            ),
            (
                "estimate below half of the error: at most 3 %",
                unless(ratios.below <= 0.03, format_percent(ratios.below)),
            ),
            (
                "estimate above three times the error: at most 5 %",
                unless(ratios.above <= 0.05, format_percent(ratios.above)),
            ),
        ]);
    }
    let gate = |(name, broken): (&'static str, Vec<String>)| AtlasGate {
        name,
        held: broken.is_empty(),
        broken,
    };
    gates.into_iter().map(gate).collect()
}

/// Returns whether the method uses ray visibility.
fn uses_rays(row: &AtlasRow, processor: Processor) -> bool {
    let mut methods = SOLVE_METHODS.iter().filter(|method| method.name == row.method);
    methods.any(|method| method.settings_on(1, processor == Processor::Gpu).transport.visibility == Visibility::Rays)
}

/// Describes one solver's result in a line.
fn describe_side(row: &AtlasRow, processor: Processor, side: &SolverSide) -> String {
    let result = match (&side.message, side.error) {
        (Some(message), _) => message.clone(),
        (None, Some(error)) => format!("{error:.3e}"),
        (None, None) => "no answer".into(),
    };
    format!(
        "{} {} {} {}: {result}",
        row.case,
        row.value,
        row.method,
        processor.name()
    )
}

#[cfg(test)]
mod tests {
    use super::super::fixture::{make_row, make_side, make_study};
    use super::super::random::RANDOM_CASE;
    use super::*;
    use approx::abs_diff_eq;

    fn random_atlas(answers: &[(f64, Option<f64>, &str)]) -> Atlas {
        let row = |(error, estimate, code): &(f64, Option<f64>, &str)| {
            let side = SolverSide {
                estimate: *estimate,
                ..make_side(Some(*error), code)
            };
            make_row(1.0, side, None)
        };
        let study = CaseStudy {
            case: RANDOM_CASE,
            ..make_study(answers.iter().map(row).collect())
        };
        Atlas::new(vec![study], None, 1.0)
    }

    #[test]
    fn ratios_cover_only_errors_above_the_floor() {
        let ratios = |pairs: &[(f64, Option<f64>)]| {
            let answers: Vec<_> = pairs.iter().map(|(error, estimate)| (*error, *estimate, "")).collect();
            random_atlas(&answers).estimate.unwrap()
        };
        let found = ratios(&[
            (0.01, Some(0.004)),
            (0.01, Some(0.01)),
            (0.02, Some(0.024)),
            (0.01, Some(0.031)),
            (0.01, None),
            (0.002, Some(1.0)),
        ]);
        let expected = EstimateRatios {
            answers: 5,
            unknown: 1,
            median: 1.0,
            below: 0.4,
            above: 0.2,
        };
        assert_eq!(found, expected);
        let even = ratios(&[(0.01, Some(0.01)), (0.01, Some(0.02))]);
        assert!(abs_diff_eq!(even.median, 1.5, epsilon = 1e-12));
        assert_eq!(ratios(&[(0.001, Some(0.0))]), EstimateRatios::default());
    }

    #[test]
    fn each_gate_of_random_scenes_can_break() {
        let broken = |answers: &[(f64, Option<f64>, &str)]| -> Vec<&'static str> {
            let gates = random_atlas(answers).gates.into_iter().filter(|gate| !gate.held);
            gates.map(|gate| gate.name).collect()
        };
        let good = [(0.01, Some(0.011), ""); 40];
        let with = |more: &[(f64, Option<f64>, &str)]| broken(&[&good[..], more].concat());
        assert!(with(&[]).is_empty() && broken(&[]).is_empty());
        assert!(with(&[(0.03, Some(0.03), "cells")]).is_empty());
        assert!(with(&[(0.01, Some(0.004), ""), (0.01, Some(0.031), "")]).is_empty());
        for (more, name) in [
            (&[(f64::NAN, Some(0.01), "cells")][..], "nothing panics"),
            (&[(0.021, Some(0.021), "")], "the default is right to 2 %"),
            (&[(0.01, Some(0.01), "cells"); 3], "false alarms"),
            (&[(0.01, Some(0.02), ""); 41], "estimate over error"),
            (&[(0.01, Some(0.004), ""); 2], "estimate below half"),
            (&[(0.01, Some(0.031), ""); 3], "estimate above three"),
        ] {
            let found = with(more);
            assert!(found.iter().any(|gate| gate.starts_with(name)), "{name}: {found:?}");
            assert!(found.len() == 1 || name == "nothing panics", "{found:?}");
        }
    }
}
