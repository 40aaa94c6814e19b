//! Score of the warnings: caught errors, missed errors and false alarms over the results of all rows,
//! one result per row and solver.

use super::methods::DEFAULT_METHOD;
use super::outcome::{WarningOutcome, is_beyond, solver_sides, warning_outcome};
use super::{CaseStudy, LEAK_MEASURE};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};

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
    /// Returns the number of all results.
    pub fn total_sides(&self) -> usize {
        self.caught + self.missed + self.false_alarms + self.quiet
    }

    /// Returns the share of false alarms.
    pub fn false_alarm_share(&self) -> f64 {
        self.false_alarms as f64 / self.total_sides().max(1) as f64
    }

    fn count_outcome(&mut self, outcome: WarningOutcome) {
        *match outcome {
            WarningOutcome::Caught => &mut self.caught,
            WarningOutcome::Missed => &mut self.missed,
            WarningOutcome::FalseAlarm => &mut self.false_alarms,
            WarningOutcome::Quiet => &mut self.quiet,
        } += 1;
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
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct WarningScore {
    /// Counts of the default method.
    pub default: WarningCounts,
    /// Counts of all methods.
    pub all: WarningCounts,
    /// Counts of each warning code over all methods.
    pub codes: Vec<CodeCount>,
}

/// Counts the outcomes of all rows.
pub fn score_warnings(studies: &[CaseStudy]) -> WarningScore {
    let mut score = WarningScore::default();
    let mut codes: BTreeMap<&str, [usize; 2]> = BTreeMap::new();
    for study in studies {
        let measure = study.info.measure;
        for (row, side) in study
            .rows
            .iter()
            .flat_map(|row| solver_sides(row).map(move |(_, s)| (row, s)))
        {
            let safe = !is_beyond(measure, side);
            // A safe leak says nothing about the warning, which may concern the light elsewhere.
            if safe && measure == LEAK_MEASURE {
                continue;
            }
            score.all.count_outcome(warning_outcome(measure, side));
            if row.method == DEFAULT_METHOD {
                score.default.count_outcome(warning_outcome(measure, side));
            }
            let codes_of_side: BTreeSet<&String> = side.warnings.iter().collect();
            for code in codes_of_side {
                codes.entry(code).or_default()[usize::from(safe)] += 1;
            }
        }
    }
    let codes = codes.into_iter().map(|(code, [caught, false_alarms])| CodeCount {
        code: code.to_owned(),
        caught,
        false_alarms,
    });
    score.codes = codes.collect();
    score
}
