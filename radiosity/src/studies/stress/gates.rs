//! Acceptance gates of the atlas; each gate lists the rows that break it.

use super::methods::{AtlasMethod, DEFAULT_METHOD, methods_of as methods};
use super::outcome::{self, Processor, WarningOutcome, warning_outcome};
use super::score::WarningScore;
use super::trial::MethodSuite;
use super::{AtlasRow, CaseStudy, LEAK_MEASURE, SAFE_LEAK, SolverSide, Verdict};
use common::settings::Visibility;
use serde::Serialize;

/// Largest share of false alarms among the default's results.
pub const MAX_FALSE_ALARM_SHARE: f64 = 0.05;

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

/// Evaluates all gates.
pub fn evaluate_gates(studies: &[CaseStudy], score: &WarningScore) -> Vec<AtlasGate> {
    let default = &score.default;
    let mut alarms = Vec::new();
    if default.false_alarm_share() > MAX_FALSE_ALARM_SHARE {
        alarms = describe_bad_sides(studies, |study, row, _, side| {
            row.method == DEFAULT_METHOD && warning_outcome(study.info.measure, side) == WarningOutcome::FalseAlarm
        });
        alarms.push(format!("{} of {} sides", default.false_alarms, default.total_sides()));
    }
    vec![
        make_gate(
            "nothing panics, hangs or is not a number",
            describe_bad_sides(studies, |_, _, _, side| side.is_broken()),
        ),
        make_gate(
            "the default is right to 2 %, or warned about",
            describe_bad_sides(studies, |_, row, _, side| {
                row.method == DEFAULT_METHOD && side.verdict != Verdict::Safe && !side.is_warned()
            }),
        ),
        make_gate("false alarms in at most 5 % of the default's rows", alarms),
        make_gate(
            "no light through walls by rays",
            describe_bad_sides(studies, |study, row, processor, side| {
                study.info.measure == LEAK_MEASURE
                    && uses_rays(row, processor)
                    && side.error.is_none_or(|error| error > SAFE_LEAK)
            }),
        ),
    ]
}

/// Makes a gate, which holds if no row breaks it.
pub fn make_gate(name: &'static str, broken: Vec<String>) -> AtlasGate {
    AtlasGate {
        name,
        held: broken.is_empty(),
        broken,
    }
}

/// Returns whether the method uses ray visibility.
fn uses_rays(row: &AtlasRow, processor: Processor) -> bool {
    let all = methods(MethodSuite::All);
    let method: Option<&AtlasMethod> = all.iter().find(|m| m.name == row.method);
    method.is_some_and(|m| m.settings_on(1, processor == Processor::Gpu).transport.visibility == Visibility::Rays)
}

type SidePredicate = fn(&CaseStudy, &AtlasRow, Processor, &SolverSide) -> bool;

/// Describes the results of all studies that are `bad`.
fn describe_bad_sides(studies: &[CaseStudy], bad: SidePredicate) -> Vec<String> {
    let each = studies.iter().flat_map(|study| {
        let broken = describe_bad_rows(&study.rows, move |row, processor, side| {
            bad(study, row, processor, side)
        });
        broken.collect::<Vec<_>>()
    });
    each.collect()
}

/// Describes the results of these rows that are `bad`.
pub fn describe_bad_rows<'a>(
    rows: impl IntoIterator<Item = &'a AtlasRow>,
    bad: impl Fn(&AtlasRow, Processor, &SolverSide) -> bool,
) -> impl Iterator<Item = String> {
    let all = rows
        .into_iter()
        .flat_map(|row| outcome::solver_sides(row).map(move |(processor, side)| (row, processor, side)));
    all.filter(move |(row, processor, side)| bad(row, *processor, side))
        .map(|(row, processor, side)| describe_side(row, processor, side))
}

/// Describes one solver's result in a line.
fn describe_side(row: &AtlasRow, processor: Processor, side: &SolverSide) -> String {
    let result = match (&side.message, side.error) {
        (Some(message), _) => message.clone(),
        (None, Some(error)) => format!("{error:.3e}"),
        (None, None) => "no answer".into(),
    };
    let solver = processor.json_name();
    format!("{} {} {} {solver}: {result}", row.case, row.value, row.method)
}
