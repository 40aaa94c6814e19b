//! What the warnings are worth: errors caught and missed, and false alarms, counted over the sides
//! of all rows (a row on one solver).

use super::methods::DEFAULT;
use super::outcome::{Outcome, beyond, outcome, sides};
use super::{LEAK, Study};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};

/// Four ways in which a warning and an error can meet.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Counts {
    /// Beyond the limit, or no answer, and the user is told.
    pub caught: usize,
    /// Beyond the limit, and nobody says so.
    pub missed: usize,
    /// Within the limit, and warned about.
    pub false_alarms: usize,
    /// Within the limit, and no warning.
    pub quiet: usize,
}

impl Counts {
    /// All of them.
    pub fn sides(&self) -> usize {
        self.caught + self.missed + self.false_alarms + self.quiet
    }

    /// False alarms over all sides.
    pub fn false_share(&self) -> f64 {
        self.false_alarms as f64 / self.sides().max(1) as f64
    }

    fn add(&mut self, outcome: Outcome) {
        *match outcome {
            Outcome::Caught => &mut self.caught,
            Outcome::Missed => &mut self.missed,
            Outcome::FalseAlarm => &mut self.false_alarms,
            Outcome::Quiet => &mut self.quiet,
        } += 1;
    }
}

/// How often a warning came, and how often for nothing.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Code {
    /// The warning's code.
    pub code: String,
    /// Sides beyond the limit on which it came.
    pub caught: usize,
    /// Sides within the limit on which it came.
    pub false_alarms: usize,
}

/// The whole count.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Score {
    /// Of what a user gets who asks for nothing.
    pub default: Counts,
    /// Of all methods.
    pub all: Counts,
    /// Of each warning, all methods.
    pub codes: Vec<Code>,
}

/// Counts.
pub fn of(studies: &[Study]) -> Score {
    let mut score = Score::default();
    let mut codes: BTreeMap<&str, [usize; 2]> = BTreeMap::new();
    for study in studies {
        let measure = study.about.measure;
        for (row, side) in study
            .rows
            .iter()
            .flat_map(|row| sides(row).map(move |(_, s)| (row, s)))
        {
            let safe = !beyond(measure, side);
            // A leak is all that is judged there: a warning may well be about the rest.
            if safe && measure == LEAK {
                continue;
            }
            score.all.add(outcome(measure, side));
            if row.method == DEFAULT {
                score.default.add(outcome(measure, side));
            }
            let told: BTreeSet<&String> = side.warnings.iter().collect();
            for code in told {
                codes.entry(code).or_default()[usize::from(safe)] += 1;
            }
        }
    }
    let codes = codes
        .into_iter()
        .map(|(code, [caught, false_alarms])| Code {
            code: code.to_owned(),
            caught,
            false_alarms,
        });
    score.codes = codes.collect();
    score
}
