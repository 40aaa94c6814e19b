//! Ratio of estimated to true error: its median and the shares that are far off.

use crate::studies::stress::SolverSide;
use serde::Serialize;

/// Errors up to this one are comparable with the truth's own; their estimates are not judged.
pub const MIN_JUDGED_ERROR: f64 = 0.002;
/// Largest relative standard error of a judged error.
pub const MAX_RELATIVE_NOISE: f64 = 0.25;
/// An estimate below this share of the error is far too low.
pub const LOW_RATIO: f64 = 0.5;
/// An estimate above this multiple of the error is far too high.
pub const HIGH_RATIO: f64 = 3.0;

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
pub fn estimate_ratio(side: &SolverSide) -> Option<f64> {
    let known = |error: &f64| *error > MIN_JUDGED_ERROR && side.noise <= MAX_RELATIVE_NOISE * error;
    let error = side.error.filter(known)?;
    Some(side.estimate.unwrap_or(0.0) / error)
}

/// Collects the ratios of all answers.
pub fn collect_ratios<'a>(sides: impl Iterator<Item = &'a SolverSide>) -> EstimateRatios {
    let judged: Vec<(&SolverSide, f64)> = sides.filter_map(|side| Some((side, estimate_ratio(side)?))).collect();
    let mut ratios: Vec<f64> = judged.iter().map(|(_, ratio)| *ratio).collect();
    ratios.sort_by(f64::total_cmp);
    let n = ratios.len();
    if n == 0 {
        return EstimateRatios::default();
    }
    let share = |far: &dyn Fn(f64) -> bool| ratios.iter().filter(|ratio| far(**ratio)).count() as f64 / n as f64;
    EstimateRatios {
        answers: n,
        unknown: judged.iter().filter(|(side, _)| side.estimate.is_none()).count(),
        median: 0.5 * (ratios[(n - 1) / 2] + ratios[n / 2]),
        below: share(&|ratio| ratio < LOW_RATIO),
        above: share(&|ratio| ratio > HIGH_RATIO),
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::fixture::make_side;
    use super::*;
    use approx::abs_diff_eq;

    fn of_pairs(pairs: &[(f64, Option<f64>)]) -> EstimateRatios {
        let sides: Vec<SolverSide> = pairs
            .iter()
            .map(|(error, estimate)| SolverSide {
                estimate: *estimate,
                ..make_side(Some(*error), "")
            })
            .collect();
        collect_ratios(sides.iter())
    }

    #[test]
    fn ratios_cover_only_errors_above_the_floor() {
        let found = of_pairs(&[
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
        let even = of_pairs(&[(0.01, Some(0.01)), (0.01, Some(0.02))]);
        assert!(abs_diff_eq!(even.median, 1.5, epsilon = 1e-12));
        assert_eq!(of_pairs(&[(0.001, Some(0.0))]), EstimateRatios::default());
    }
}
