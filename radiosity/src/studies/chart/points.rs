//! The measured points of a scene, their Pareto front and the curves that they lie on.

use super::methods::SolveMethod;
use super::peers::Peer;
use super::store::{Measurement, SolveFigures};
use serde::Serialize;
use std::ops::Range;

/// Errors below this are rounding of 32-bit sums over thousands of shots.
const ROUNDING_ERROR: f64 = 1e-5;

/// One method with its measurements, at least one.
#[derive(Clone, Debug)]
pub struct ChartPoint {
    /// The method.
    pub method: SolveMethod,
    /// Its runs.
    pub runs: Vec<Measurement>,
    /// True if no other point with the same truth dominates it.
    pub on_front: bool,
}

/// One curve of an option's error, coarse to fine.
#[derive(Clone, Debug, Serialize)]
pub struct MeasuredCurve {
    /// Name of the option in headings.
    pub name: &'static str,
    /// Command-line option.
    pub option: &'static str,
    /// Name in the legend.
    pub label: String,
    /// Description of the truth.
    pub truth: String,
    /// Fitted order of the whole curve.
    pub order: Option<f64>,
    /// Order of the last two points: about 0 where another parameter sets a floor.
    pub last_order: Option<f64>,
}

/// All measurements of one scene.
#[derive(Clone, Debug, Default)]
pub struct SceneChart {
    /// Name of the scene.
    pub scene: String,
    /// Number of faces.
    pub faces: usize,
    /// Texels per side on which errors are measured; none: the common ones of method and truth.
    pub texels: Option<u32>,
    /// Description of the truth; each curve has its own.
    pub truth: String,
    /// Name of the GPU.
    pub adapter: Option<String>,
    /// The measured points.
    pub points: Vec<ChartPoint>,
    /// Number of points missing after an interruption.
    pub missing: usize,
    /// Curves of the varied options; their index is in the points' methods.
    pub curves: Vec<MeasuredCurve>,
    /// Measurements of other programs.
    pub peers: Vec<Peer>,
}

impl ChartPoint {
    /// Returns the figures of its first run, which all runs share, or the first failure of a run.
    pub fn first_result(&self) -> Result<&SolveFigures, &str> {
        let failed = self.runs.iter().find(|run| run.result.is_err());
        match failed.or(self.runs.first()).map(|run| &run.result) {
            Some(Ok(figures)) => Ok(figures),
            Some(Err(reason)) => Err(reason),
            None => Err("not measured"),
        }
    }

    /// Returns median, minimum and maximum of `quantity` over the runs.
    pub fn median_and_range(&self, quantity: fn(&Measurement) -> f64) -> [f64; 3] {
        let mut all: Vec<f64> = self.runs.iter().map(quantity).collect();
        all.sort_by(f64::total_cmp);
        let n = all.len();
        if n == 0 {
            return [f64::NAN; 3];
        }
        [(all[(n - 1) / 2] + all[n / 2]) / 2.0, all[0], all[n - 1]]
    }

    /// Returns (seconds, error): the median of the total time, and the error, NaN of a failed point.
    pub fn time_and_error(&self) -> [f64; 2] {
        let error = self.first_result().map_or(f64::NAN, |figures| figures.error);
        [self.median_and_range(Measurement::total_seconds)[0], error]
    }
}

impl SceneChart {
    /// Sets `on_front` of each point, among the points with the same truth.
    pub fn mark_fronts(&mut self) {
        let places: Vec<_> = self
            .points
            .iter()
            .map(|p| (p.method.truth, p.time_and_error()))
            .collect();
        for point in &mut self.points {
            let rivals = places.iter().filter(|(truth, _)| *truth == point.method.truth);
            point.on_front = is_on_front(point.time_and_error(), rivals.map(|(_, place)| *place));
        }
    }

    /// Returns the points of a curve, coarse to fine.
    pub fn curve_points(&self, curve: usize) -> impl Iterator<Item = &ChartPoint> {
        self.points
            .iter()
            .filter(move |p| p.method.varied.is_some_and(|(k, _)| k == curve))
    }

    /// Returns the curves of each varied option.
    pub fn sweep_curves(&self) -> Vec<Range<usize>> {
        let mut start = 0;
        let sweeps = self.curves.chunk_by(|a, b| a.option == b.option).map(|curves| {
            start += curves.len();
            start - curves.len()..start
        });
        sweeps.collect()
    }
}

/// Returns whether no rival is better than a (seconds, error) in both. Equal points are both on the Pareto front; a
/// point with a value that is not finite is not, and beats none.
pub fn is_on_front(point: [f64; 2], rivals: impl IntoIterator<Item = [f64; 2]>) -> bool {
    let is_finite = |p: &[f64; 2]| p.iter().all(|x| x.is_finite());
    let is_beaten_by = |q: [f64; 2]| q[0] <= point[0] && q[1] <= point[1] && q != point;
    is_finite(&point) && !rivals.into_iter().filter(is_finite).any(is_beaten_by)
}

/// Returns the order p of an error e ≈ C hᵖ, the least-squares slope of ln e over ln h, or none with fewer than two
/// (h, e) above the rounding.
pub fn fit_order(steps: &[[f64; 2]]) -> Option<f64> {
    let usable = steps
        .iter()
        .filter(|[h, e]| *h > 0.0 && *e > ROUNDING_ERROR && e.is_finite());
    let logarithms: Vec<[f64; 2]> = usable.map(|step| step.map(f64::ln)).collect();
    let n = logarithms.len() as f64;
    let [x, y] = [0, 1].map(|k| logarithms.iter().map(|p| p[k]).sum::<f64>() / n);
    let square: f64 = logarithms.iter().map(|p| (p[0] - x).powi(2)).sum();
    let product: f64 = logarithms.iter().map(|p| (p[0] - x) * (p[1] - y)).sum();
    (logarithms.len() >= 2 && square > 0.0).then(|| product / square)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::studies::chart::methods::SolverKind;
    use approx::abs_diff_eq;
    use common::settings::Settings;

    #[test]
    fn front_has_the_points_that_no_other_beats() {
        let (nan, infinite) = (f64::NAN, f64::INFINITY);
        let cases: [(&[[f64; 2]], &[bool]); 3] = [
            (
                &[[1.0, 0.5], [2.0, 0.5], [1.0, 0.6], [2.0, 0.4], [3.0, 0.1]],
                &[true, false, false, true, true],
            ),
            (&[[1.0, 0.5], [1.0, 0.5], [0.5, 0.5]], &[false, false, true]),
            (
                &[
                    [nan, 0.1],
                    [1.0, nan],
                    [-infinite, 0.0],
                    [0.5, infinite],
                    [2.0, 0.2],
                    [2.0, 0.2],
                ],
                &[false, false, false, false, true, true],
            ),
        ];
        for (points, expected) in cases {
            let found: Vec<bool> = points.iter().map(|p| is_on_front(*p, points.iter().copied())).collect();
            assert_eq!(found, expected, "{points:?}");
        }
    }

    #[test]
    fn points_are_rivals_of_those_with_the_same_truth() {
        let point = |truth: usize, seconds: f64| ChartPoint {
            method: SolveMethod {
                truth,
                ..SolveMethod::new(SolverKind::Cpu, "", Settings::default())
            },
            runs: vec![Measurement {
                prepare: 0.0,
                solve: seconds,
                result: Ok(SolveFigures {
                    error: 0.5,
                    bias: 0.0,
                    imbalance: 0.0,
                    shots: 1,
                    passes: 1,
                }),
            }],
            on_front: false,
        };
        let mut chart = SceneChart {
            points: vec![point(0, 2.0), point(1, 3.0), point(0, 1.0)],
            ..SceneChart::default()
        };
        chart.mark_fronts();
        let front: Vec<bool> = chart.points.iter().map(|p| p.on_front).collect();
        assert_eq!(front, [false, true, true]);
    }

    #[test]
    fn order_of_a_power_law_is_recovered() {
        for p in [0.5, 1.0, 2.0] {
            let steps = [0.25, 0.125, 0.0625].map(|h: f64| [h, 7.0 * h.powf(p)]);
            assert!(abs_diff_eq!(fit_order(&steps).unwrap(), p, epsilon = 1e-12));
        }
        for steps in [
            &[][..],
            &[[0.5, 1.0]],
            &[[0.5, 1.0], [0.25, 0.0]],
            &[[0.5, 1.0], [0.25, f64::NAN]],
        ] {
            assert_eq!(fit_order(steps), None);
        }
    }
}
