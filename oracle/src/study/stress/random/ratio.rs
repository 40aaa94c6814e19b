//! The estimate of the error against the error: is it as large, and how often is it far off?

use crate::study::stress::Side;
use serde::Serialize;

/// Errors up to here are the truth's own as well: nothing is asked of their estimate.
pub const FLOOR: f64 = 0.002;
/// And errors that are known no better than to this share of themselves.
pub const KNOWN: f64 = 0.25;
/// An estimate below this share of the error is far too sure.
pub const LOW: f64 = 0.5;
/// And above this it frightens for nothing.
pub const HIGH: f64 = 3.0;

/// Estimate over error, of the answers with an error above [`FLOOR`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Ratios {
    /// How many answers.
    pub answers: usize,
    /// Of them, how many were not estimated; they count as estimated 0.
    pub unknown: usize,
    /// Half of the ratios are below.
    pub median: f64,
    /// The share below [`LOW`].
    pub below: f64,
    /// The share above [`HIGH`].
    pub above: f64,
}

/// Of an answer; none where it asks nothing.
pub fn ratio(side: &Side) -> Option<f64> {
    let known = |error: &f64| *error > FLOOR && side.noise <= KNOWN * error;
    let error = side.error.filter(known)?;
    Some(side.estimate.unwrap_or(0.0) / error)
}

/// Of all answers.
pub fn of<'a>(sides: impl Iterator<Item = &'a Side>) -> Ratios {
    let judged: Vec<(&Side, f64)> = sides
        .filter_map(|side| Some((side, ratio(side)?)))
        .collect();
    let mut ratios: Vec<f64> = judged.iter().map(|(_, ratio)| *ratio).collect();
    ratios.sort_by(f64::total_cmp);
    let n = ratios.len();
    if n == 0 {
        return Ratios::default();
    }
    let share = |far: &dyn Fn(f64) -> bool| {
        ratios.iter().filter(|ratio| far(**ratio)).count() as f64 / n as f64
    };
    Ratios {
        answers: n,
        unknown: judged
            .iter()
            .filter(|(side, _)| side.estimate.is_none())
            .count(),
        median: 0.5 * (ratios[(n - 1) / 2] + ratios[n / 2]),
        below: share(&|ratio| ratio < LOW),
        above: share(&|ratio| ratio > HIGH),
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::fixture::side;
    use super::*;
    use approx::abs_diff_eq;

    fn of_pairs(pairs: &[(f64, Option<f64>)]) -> Ratios {
        let sides: Vec<Side> = pairs
            .iter()
            .map(|(error, estimate)| Side {
                estimate: *estimate,
                ..side(Some(*error), "")
            })
            .collect();
        of(sides.iter())
    }

    #[test]
    fn ratios_are_counted_where_there_is_an_error() {
        let found = of_pairs(&[
            (0.01, Some(0.004)),
            (0.01, Some(0.01)),
            (0.02, Some(0.024)),
            (0.01, Some(0.031)),
            (0.01, None),
            (0.002, Some(1.0)),
        ]);
        let expected = Ratios {
            answers: 5,
            unknown: 1,
            median: 1.0,
            below: 0.4,
            above: 0.2,
        };
        assert_eq!(found, expected);
        let even = of_pairs(&[(0.01, Some(0.01)), (0.01, Some(0.02))]);
        assert!(abs_diff_eq!(even.median, 1.5, epsilon = 1e-12));
        assert_eq!(of_pairs(&[(0.001, Some(0.0))]), Ratios::default());
    }
}
