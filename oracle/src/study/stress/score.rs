//! What the warnings are worth: errors caught and missed, and false alarms, counted over the sides
//! of all rows (a row on one solver).

use super::methods::DEFAULT;
use super::outcome::beyond;
use super::{LEAK, Side, Study};
use serde::Serialize;

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

    fn add(&mut self, safe: bool, warned: bool) {
        *match (safe, warned) {
            (false, true) => &mut self.caught,
            (false, false) => &mut self.missed,
            (true, true) => &mut self.false_alarms,
            (true, false) => &mut self.quiet,
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
    for study in studies {
        for row in &study.rows {
            for side in std::iter::once(&row.cpu).chain(&row.gpu) {
                let safe = !beyond(study.about.measure, side);
                // A leak is all that is judged there: a warning may well be about the rest.
                if safe && study.about.measure == LEAK {
                    continue;
                }
                score.all.add(safe, side.warned());
                if row.method == DEFAULT {
                    score.default.add(safe, side.warned());
                }
                score.note(side, safe);
            }
        }
    }
    score.codes.sort_by(|a, b| a.code.cmp(&b.code));
    score
}

impl Score {
    fn note(&mut self, side: &Side, safe: bool) {
        for (k, code) in side.warnings.iter().enumerate() {
            if side.warnings[..k].contains(code) {
                continue;
            }
            let place = self.codes.iter().position(|c| c.code == *code);
            let place = place.unwrap_or_else(|| {
                self.codes.push(Code {
                    code: code.clone(),
                    caught: 0,
                    false_alarms: 0,
                });
                self.codes.len() - 1
            });
            let counts = &mut self.codes[place];
            *if safe {
                &mut counts.false_alarms
            } else {
                &mut counts.caught
            } += 1;
        }
    }
}
