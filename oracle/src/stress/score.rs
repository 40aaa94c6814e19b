//! How well the program knows its own limits, and where these are.

use super::outcome::{Outcome, beyond, outcome, sides};
use super::{DEGRADED, Row, SAFE, Side};
use serde::Serialize;

/// The method that users get who say nothing.
pub const DEFAULT: &str = "default";

/// How the warnings did, over sides (row × solver).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Score {
    /// Beyond [`SAFE`], and warned about or refused.
    pub caught: u32,
    /// Beyond [`SAFE`], and nobody said so.
    pub missed: u32,
    /// Warned about, and safe.
    pub false_alarms: u32,
    /// Safe and quiet.
    pub quiet: u32,
}

impl Score {
    /// Of these rows.
    pub fn of<'a>(rows: impl IntoIterator<Item = &'a Row>) -> Self {
        let mut score = Self::default();
        for (_, side) in rows.into_iter().flat_map(sides) {
            let count = match outcome(side) {
                Outcome::Caught => &mut score.caught,
                Outcome::Missed => &mut score.missed,
                Outcome::FalseAlarm => &mut score.false_alarms,
                Outcome::Quiet => &mut score.quiet,
            };
            *count += 1;
        }
        score
    }
}

/// Up to where a method holds, along a case's values.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Break {
    /// The last value up to which every error is at most [`SAFE`].
    pub safe_to: Option<f64>,
    /// The first value beyond [`SAFE`].
    pub breaks_at: Option<f64>,
    /// The first value beyond [`DEGRADED`].
    pub fails_at: Option<f64>,
}

impl Break {
    /// Of one method's rows of a case, in order of severity; rows without that side do not count.
    pub fn of<'a>(
        rows: impl IntoIterator<Item = &'a Row>,
        side: impl Fn(&'a Row) -> Option<&'a Side>,
    ) -> Self {
        let mut found = Self {
            safe_to: None,
            breaks_at: None,
            fails_at: None,
        };
        for row in rows {
            let Some(side) = side(row) else { continue };
            if beyond(side, SAFE) {
                found.breaks_at.get_or_insert(row.value);
            }
            if beyond(side, DEGRADED) {
                found.fails_at.get_or_insert(row.value);
            }
            if found.breaks_at.is_none() {
                found.safe_to = Some(row.value);
            }
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::super::fixture::{row, side};
    use super::*;

    #[test]
    fn every_side_counts_once() {
        let rows = [
            row(1.0, side(Some(0.001), ""), Some(side(Some(0.001), "thin"))),
            row(2.0, side(Some(0.03), "thin"), Some(side(Some(0.03), ""))),
            row(3.0, side(None, ""), None),
            row(4.0, side(Some(f64::NAN), ""), None),
        ];
        let score = Score::of(&rows);
        let expected = Score {
            caught: 2,
            missed: 2,
            false_alarms: 1,
            quiet: 1,
        };
        assert_eq!(score, expected);
    }

    #[test]
    fn a_method_holds_up_to_its_first_error() {
        let errors = [Some(0.02), Some(0.05), Some(0.01), None];
        let rows: Vec<Row> = (1..)
            .zip(errors)
            .map(|(k, error)| row(f64::from(k), side(error, ""), None))
            .collect();
        let found = Break::of(&rows, |row| Some(&row.cpu));
        let expected = Break {
            safe_to: Some(1.0),
            breaks_at: Some(2.0),
            fails_at: Some(4.0),
        };
        assert_eq!(found, expected);
        let nothing = Break::of(&rows, |row| row.gpu.as_ref());
        assert_eq!([nothing.safe_to, nothing.breaks_at], [None, None]);
        let safe = Break::of(&rows[..1], |row| Some(&row.cpu));
        assert_eq!((safe.safe_to, safe.breaks_at), (Some(1.0), None));
    }
}
