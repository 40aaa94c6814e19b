//! The measured points of a scene, their Pareto front, the curves that they lie on, and the content of `chart.json`.

use super::methods::SolveMethod;
use super::peers::Peer;
use super::store::{Measurement, SolveFigures};
use super::sweeps::{MethodSet, Sweep};
use serde_json::{Value, json};

/// Errors below this are rounding of 32-bit sums over thousands of shots.
const ROUNDING_ERROR: f64 = 1e-5;

/// One method with its measurement.
#[derive(Clone, Debug, PartialEq)]
pub struct ChartPoint {
    /// The method.
    pub method: SolveMethod,
    /// Its time and error.
    pub measurement: Measurement,
    /// True if no other point of its set dominates it.
    pub on_front: bool,
}

impl ChartPoint {
    /// Returns (seconds, error), the error NaN of a failed point.
    pub fn time_and_error(&self) -> [f64; 2] {
        let error = self.solve_figures().map_or(f64::NAN, |figures| figures.error);
        [self.measurement.seconds, error]
    }

    /// Returns the figures; none of a failed point.
    pub fn solve_figures(&self) -> Option<&SolveFigures> {
        self.measurement.result.as_ref().ok()
    }
}

/// Points with one truth.
#[derive(Clone)]
pub struct MeasuredSet {
    /// The varied option, if there is one.
    pub sweep: Option<Sweep>,
    /// Description of the truth.
    pub truth: String,
    /// The measured points.
    pub points: Vec<ChartPoint>,
    /// Number of points missing after an interruption.
    pub missing: usize,
}

impl MeasuredSet {
    /// Makes a set of its measured points and marks those on the front.
    pub fn new(set: &MethodSet, mut points: Vec<ChartPoint>) -> Self {
        let places: Vec<[f64; 2]> = points.iter().map(ChartPoint::time_and_error).collect();
        for (point, place) in points.iter_mut().zip(&places) {
            point.on_front = is_on_front(*place, &places);
        }
        Self {
            sweep: set.sweep,
            truth: set.truth.options.clone(),
            missing: set.methods.len() - points.len(),
            points,
        }
    }

    /// Iterates over the curves of a sweep: name, points from coarse to fine.
    pub fn split_by_curve(&self) -> impl Iterator<Item = (&'static str, &[ChartPoint])> {
        let name = |point: &ChartPoint| point.method.curve.map(|(name, _)| name);
        let curves = self.points.chunk_by(move |a, b| name(a) == name(b));
        curves.filter_map(move |points| Some((name(points.first()?)?, points)))
    }

    /// Returns the fitted order of the error on a curve.
    pub fn curve_order(&self, points: &[ChartPoint]) -> Option<f64> {
        let sweep = self.sweep?;
        let step = |p: &ChartPoint| Some([sweep.step_size(p.method.curve?.1), p.time_and_error()[1]]);
        fit_order(&points.iter().filter_map(step).collect::<Vec<_>>())
    }
}

/// All measurements of one scene.
#[derive(Clone, Default)]
pub struct SceneChart {
    /// Name of the scene.
    pub scene: String,
    /// Number of faces.
    pub faces: usize,
    /// Texels per side on which errors are measured; none: the common ones of method and truth.
    pub texels: Option<u32>,
    /// Name of the GPU.
    pub adapter: Option<String>,
    /// All methods, or a set for each varied option.
    pub sets: Vec<MeasuredSet>,
    /// Measurements of other programs.
    pub peers: Vec<Peer>,
}

impl SceneChart {
    /// Iterates over the points of all sets.
    pub fn iterate_points(&self) -> impl Iterator<Item = &ChartPoint> {
        self.sets.iter().flat_map(|set| &set.points)
    }

    /// Returns the number of points that are not measured.
    pub fn count_missing(&self) -> usize {
        self.sets.iter().map(|set| set.missing).sum()
    }
}

/// Returns whether no rival is better than a (seconds, error) in both. Equal points are both on the Pareto front; a
/// point with a value that is not finite is not, and beats none.
fn is_on_front(point: [f64; 2], rivals: &[[f64; 2]]) -> bool {
    let is_finite = |p: &[f64; 2]| p.iter().all(|x| x.is_finite());
    let is_beaten_by = |q: &[f64; 2]| is_finite(q) && q[0] <= point[0] && q[1] <= point[1] && *q != point;
    is_finite(&point) && !rivals.iter().any(is_beaten_by)
}

/// Returns the order p of an error e ≈ C hᵖ, the least-squares slope of ln e over ln h, or none with fewer than two
/// (h, e) above the rounding.
fn fit_order(steps: &[[f64; 2]]) -> Option<f64> {
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

/// Returns the content of `chart.json`: all points of all scenes. A failed point has a null error and its reason.
pub fn chart_json(charts: &[SceneChart]) -> Value {
    let points = charts
        .iter()
        .flat_map(|chart| chart.iterate_points().map(|point| point_json(chart, point)));
    json!({
        "points": points.collect::<Vec<_>>(),
        "scenes": charts.iter().map(scene_json).collect::<Vec<_>>(),
    })
}

fn scene_json(chart: &SceneChart) -> Value {
    let curve = |set: &MeasuredSet, (label, points): (&str, &[ChartPoint])| {
        json!({
            "name": set.sweep.map(|sweep| sweep.name),
            "option": set.sweep.map(|sweep| sweep.option),
            "label": label,
            "truth": set.truth,
            "order": set.curve_order(points),
        })
    };
    let sets = chart.sets.iter();
    let curves = sets.flat_map(|set| set.split_by_curve().map(move |found| curve(set, found)));
    json!({
        "scene": chart.scene,
        "faces": chart.faces,
        "texels": chart.texels,
        "truth": chart.sets.first().map(|set| &set.truth),
        "adapter": chart.adapter,
        "not_measured": chart.count_missing(),
        "curves": curves.collect::<Vec<_>>(),
        "peers": chart.peers,
    })
}

fn point_json(chart: &SceneChart, point: &ChartPoint) -> Value {
    let (method, measured, figures) = (&point.method, &point.measurement, point.solve_figures());
    json!({
        "scene": chart.scene,
        "solver": method.solver,
        "options": method.options,
        "settings": method.settings,
        "target_error": method.target_error,
        "curve": method.curve.map(|(name, _)| name),
        "value": method.curve.map(|(_, value)| value),
        "seconds": measured.seconds,
        "error": figures.map(|f| f.error),
        "bias": figures.map(|f| f.bias),
        "on_front": point.on_front,
        "failure": measured.result.as_ref().err(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::abs_diff_eq;

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
            let found: Vec<bool> = points.iter().map(|p| is_on_front(*p, points)).collect();
            assert_eq!(found, expected, "{points:?}");
        }
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
