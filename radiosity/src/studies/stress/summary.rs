//! Evaluates the rows of an atlas: counts caught and missed errors, finds break points, compares error
//! estimates with errors and checks the acceptance gates.

use super::methods::SOLVE_METHODS;
use super::{AtlasRow, CaseStudy, ErrorMeasure, SolverSide, WarningOutcome};
use crate::report::format::{format_number, format_percent};
use common::settings::Visibility;
use oracle::solve::solver::SolverKind;
use serde::Serialize;
use serde_json::{Value, json};

/// Largest share of false alarms among the default's results.
const MAX_FALSE_ALARM_SHARE: f64 = 0.05;
/// Errors up to this one are comparable with the traced truth's own; their estimates are not judged.
pub const MIN_JUDGED_ERROR: f64 = 0.002;
/// Largest relative standard error of a judged error.
const MAX_RELATIVE_NOISE: f64 = 0.25;
/// Largest share of the answers that miss the requested error.
const MAX_MISS_SHARE: f64 = 0.05;
/// Largest error of an answer that misses, as a multiple of the requested error.
const MAX_REQUEST_RATIO: f64 = 1.3;
/// An estimate below this share of the error is far too low.
const LOW_RATIO: f64 = 0.5;
/// An estimate above this multiple of the error is far too high.
const HIGH_RATIO: f64 = 3.0;

/// Results of a run with their evaluation.
pub struct Atlas {
    /// Results of each case.
    pub studies: Vec<CaseStudy>,
    /// Counts of the default method.
    pub score: WarningCounts,
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
        let score = WarningCounts::new(&studies);
        let random = studies.iter().filter(|study| study.case.is_random());
        let estimate = EstimateRatios::new(random.flat_map(CaseStudy::sides).map(|(_, _, side)| side));
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
            "score": { "default": self.score },
            "estimate": self.estimate,
            "gates": self.gates,
            "adapter": self.adapter,
            "seconds": self.seconds,
        })
    }
}

/// Number of the default's results of each outcome.
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
    fn new(studies: &[CaseStudy]) -> Self {
        let count = |outcome: WarningOutcome| {
            let all = studies
                .iter()
                .flat_map(|study| study.sides().map(move |found| (study, found)));
            let own = all.filter(|(study, (row, _, side))| study.is_default(row) && side.outcome == outcome);
            own.count()
        };
        Self {
            caught: count(WarningOutcome::Caught),
            missed: count(WarningOutcome::Missed),
            false_alarms: count(WarningOutcome::FalseAlarm),
            quiet: count(WarningOutcome::Quiet),
        }
    }

    /// Returns the counts in words.
    pub fn describe_counts(&self) -> String {
        format!(
            "{} caught, {} missed, {} false alarms, {} quiet",
            self.caught, self.missed, self.false_alarms, self.quiet
        )
    }
}

/// Break points of one method on one solver: the first values at which the error exceeds the limits; none
/// if it never does.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BreakPoint {
    /// Name of the method.
    pub method: &'static str,
    /// The solver.
    pub solver: SolverKind,
    /// First value at which it is not safe.
    pub degrades_at: Option<f64>,
    /// First value beyond the second limit.
    pub fails_at: Option<f64>,
}

/// Returns the break points of all methods of a case.
pub fn find_breaks(study: &CaseStudy) -> Vec<BreakPoint> {
    let methods = study.case.methods.iter();
    let columns = methods.flat_map(|method| [SolverKind::Cpu, SolverKind::Gpu].map(|solver| (method.name, solver)));
    let run = columns.filter(|(method, solver)| study.sides_of(method, *solver).next().is_some());
    let found = run.map(|(method, solver)| {
        let [degrades_at, fails_at] = study.case.measure.limits().map(|limit| {
            let within = |side: &SolverSide| side.error.is_some_and(|error| error <= limit);
            let mut broken = study.sides_of(method, solver).filter(|(_, side)| !within(side));
            broken.next().map(|(row, _)| row.value)
        });
        BreakPoint {
            method,
            solver,
            degrades_at,
            fails_at,
        }
    });
    found.collect()
}

/// Statistics of estimate over error, over the answers with an error above [`MIN_JUDGED_ERROR`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct EstimateRatios {
    /// Number of answers.
    pub answers: usize,
    /// Number of answers without an estimate; they count as estimate 0.
    pub unknown: usize,
    /// Median of the ratios.
    pub median: f64,
    /// Share of the ratios below one half.
    pub below: f64,
    /// Share of the ratios above three.
    pub above: f64,
}

impl EstimateRatios {
    /// Evaluates the answers; none if none is judged.
    fn new<'a>(sides: impl Iterator<Item = &'a SolverSide>) -> Option<Self> {
        let judged = sides.filter_map(|side| {
            let known = |error: &f64| *error > MIN_JUDGED_ERROR && side.noise <= MAX_RELATIVE_NOISE * error;
            Some((side.estimate, side.error.filter(known)?))
        });
        let judged: Vec<(Option<f64>, f64)> = judged.collect();
        let ratios = judged.iter().map(|(estimate, error)| estimate.unwrap_or(0.0) / error);
        let mut ratios: Vec<f64> = ratios.collect();
        ratios.sort_by(f64::total_cmp);
        let n = ratios.len();
        let share = |far: fn(f64) -> bool| ratios.iter().filter(|ratio| far(**ratio)).count() as f64 / n as f64;
        (n > 0).then(|| Self {
            answers: n,
            unknown: judged.iter().filter(|(estimate, _)| estimate.is_none()).count(),
            median: 0.5 * (ratios[(n - 1) / 2] + ratios[n / 2]),
            below: share(|ratio| ratio < LOW_RATIO),
            above: share(|ratio| ratio > HIGH_RATIO),
        })
    }

    /// Returns the statistics in words.
    pub fn describe_ratios(&self) -> String {
        format!(
            "estimate over error, {} answers: median {}, below half {}, above three times {}",
            self.answers,
            format_number(self.median),
            format_percent(self.below),
            format_percent(self.above)
        )
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

fn evaluate_gates(studies: &[CaseStudy], score: &WarningCounts, estimate: Option<&EstimateRatios>) -> Vec<AtlasGate> {
    let bad = |is_bad: &dyn Fn(&CaseStudy, &AtlasRow, SolverKind, &SolverSide) -> bool| -> Vec<String> {
        let all = studies
            .iter()
            .flat_map(|study| study.sides().map(move |found| (study, found)));
        let bad = all.filter(|(study, (row, device, side))| is_bad(study, row, *device, side));
        bad.map(|(_, (row, device, side))| describe_side(row, device, side))
            .collect()
    };
    let is_of_default = |outcome: WarningOutcome| {
        move |study: &CaseStudy, row: &AtlasRow, _: SolverKind, side: &SolverSide| {
            study.is_default(row) && side.outcome == outcome
        }
    };
    let all = (score.caught + score.missed + score.false_alarms + score.quiet).max(1);
    let has_few_alarms = score.false_alarms as f64 <= MAX_FALSE_ALARM_SHARE * all as f64;
    let mut alarms = bad(&is_of_default(WarningOutcome::FalseAlarm));
    alarms.retain(|_| !has_few_alarms);
    let leaks = |study: &CaseStudy, row: &AtlasRow, device, side: &SolverSide| {
        let leaks = side.error.is_none_or(|error| error > ErrorMeasure::Leak.limits()[0]);
        study.case.measure == ErrorMeasure::Leak && uses_rays(row, device) && leaks
    };
    let mut missed = bad(&|_, row, _, side| row.exceeds_request(side, 1.0));
    if missed.len() as f64 <= MAX_MISS_SHARE * all as f64 {
        missed.clear();
    }
    let mut gates = vec![
        (
            "nothing panics, hangs or is not a number",
            bad(&|_, _, _, side| side.is_broken()),
        ),
        (
            "the default is right to 2 %, or warned about",
            bad(&is_of_default(WarningOutcome::Missed)),
        ),
        ("the requested error is kept by 95 % of the answers", missed),
        (
            "no error above 1.3 times the requested one",
            bad(&|_, row, _, side| row.exceeds_request(side, MAX_REQUEST_RATIO)),
        ),
        ("false alarms in at most 5 % of the default's answers", alarms),
        ("no light through walls by rays", bad(&leaks)),
    ];
    if let Some(ratios) = estimate {
        let unless = |holds: bool, value: String| Vec::from_iter((!holds).then_some(value));
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
fn uses_rays(row: &AtlasRow, device: SolverKind) -> bool {
    let mut methods = SOLVE_METHODS.iter().filter(|method| method.name == row.method);
    methods.any(|method| method.settings_on(1, device == SolverKind::Gpu).transport.visibility == Visibility::Rays)
}

/// Describes one solver's result in a line.
fn describe_side(row: &AtlasRow, device: SolverKind, side: &SolverSide) -> String {
    let result = match (&side.message, side.error) {
        (Some(message), _) => message.clone(),
        (None, Some(error)) => format!("{error:.3e}"),
        (None, None) => "no answer".into(),
    };
    let solver = device.name();
    format!("{} {} {} {solver}: {result}", row.case, row.value, row.method)
}
