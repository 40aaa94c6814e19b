//! Solves the points of a sweep and measures them against its truth.

use super::finding::{Evidence, ROUNDING, finding};
use super::sweeps::{Curve, REFINEMENTS, Sweep, Truth};
use super::{MeasuredCurve, MeasuredSweep, Point, fit};
use crate::judge::diff::pair::Pair;
use crate::judge::diff::reflected::Reflected;
use crate::solve::solved::Solved;
use crate::solve::solver::Solver;
use crate::solve::task::Task;
use crate::solve::watch::Watch;
use common::scene::Scene;
use common::settings::Settings;
use common::solution::Stored;
use common::{Error, Result};
use gpu::Gpu;
use std::time::Instant;

/// A refinement that leaves less than this share of the error explains it.
const ENOUGH: f64 = 0.5;

/// What is swept, and by what means.
pub struct Bench<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// Who draws item buffers; without, the scalar twin.
    pub gpu: Option<&'a Gpu>,
    /// A truth from elsewhere.
    pub truth: Option<&'a Stored>,
}

/// A solve of the bench's scene.
struct Answer<'a> {
    reflected: Reflected<'a>,
    seconds: f64,
    shots: usize,
}

impl<'a> Bench<'a> {
    /// Measures one sweep; none when `watch` broke before its first point, and what there is
    /// when it broke later.
    pub fn sweep(&self, sweep: &Sweep, watch: &Watch) -> Result<Option<MeasuredSweep>> {
        let truth = match self.truth {
            Some(stored) => Some(Reflected::from(stored)),
            None => self
                .solve(&sweep.truth_settings(), "truth", watch)?
                .map(|solved| solved.reflected),
        };
        let Some(truth) = truth else { return Ok(None) };
        let mut measured = MeasuredSweep {
            name: sweep.name,
            option: sweep.option,
            truth: self.truth_name(sweep),
            base: serde_json::to_value(sweep.settings(&sweep.curves[0], sweep.values[0]))
                .unwrap_or_default(),
            curves: Vec::new(),
        };
        for curve in sweep.curves {
            let points = self.points(sweep, curve, &truth, watch)?;
            let complete = points.len() == sweep.values.len();
            if !points.is_empty() {
                let curve = self.curve(sweep, curve, points, &truth, watch)?;
                measured.curves.push(curve);
            }
            if !complete {
                break;
            }
        }
        Ok((!measured.curves.is_empty()).then_some(measured))
    }

    fn truth_name(&self, sweep: &Sweep) -> String {
        match (self.truth, sweep.truth) {
            (Some(stored), _) => stored.dir.display().to_string(),
            (None, Truth::Finer(value)) => format!("{} {value}", sweep.option),
            (None, Truth::Limit { name, .. }) => name.to_owned(),
        }
    }

    fn points(
        &self,
        sweep: &Sweep,
        curve: &Curve,
        truth: &Reflected,
        watch: &Watch,
    ) -> Result<Vec<Point>> {
        let mut points = Vec::new();
        for &value in sweep.values {
            let name = format!("{} {value}, {}", sweep.option, curve.label);
            let Some(point) = self.point(&sweep.settings(curve, value), truth, &name, watch)?
            else {
                break;
            };
            points.push(Point { value, ..point });
        }
        Ok(points)
    }

    /// A point without its value.
    fn point(
        &self,
        settings: &Settings,
        truth: &Reflected,
        name: &str,
        watch: &Watch,
    ) -> Result<Option<Point>> {
        let Some(solved) = self.solve(settings, name, watch)? else {
            return Ok(None);
        };
        let (error, bias) = self.error(&solved.reflected, truth)?;
        Ok(Some(Point {
            value: f64::NAN,
            error,
            bias,
            seconds: solved.seconds,
            shots: solved.shots,
        }))
    }

    /// Order and finding of the points.
    fn curve(
        &self,
        sweep: &Sweep,
        curve: &Curve,
        points: Vec<Point>,
        truth: &Reflected,
        watch: &Watch,
    ) -> Result<MeasuredCurve> {
        let steps: Vec<(f64, f64)> = points
            .iter()
            .map(|p| (sweep.step(p.value), p.error))
            .collect();
        let above: Vec<(f64, f64)> = steps.iter().copied().filter(|s| s.1 > ROUNDING).collect();
        // Only the first curve is the truth's.
        let first = std::ptr::eq(curve, &raw const sweep.curves[0]);
        let order_beside = match (self.truth, sweep.truth) {
            (None, Truth::Finer(value)) if first => fit::order_beside(&above, sweep.step(value)),
            _ => None,
        };
        let order = fit::slope(&above);
        let last_error = points.last().map_or(0.0, |p| p.error);
        let mut evidence = Evidence {
            points: &points,
            order,
            last: fit::last_slope(&steps),
            refined: Vec::new(),
        };
        if evidence.stalled() && points.len() == sweep.values.len() {
            evidence.refined = self.refined((sweep, curve), last_error, truth, watch)?;
        }
        let (converges, finding) = finding(&evidence);
        Ok(MeasuredCurve {
            label: curve.label.to_owned(),
            order,
            order_beside,
            finding,
            converges,
            points,
        })
    }

    /// The error of the last point with each other parameter made finer, until one takes most of
    /// it away. A truth of our own is made finer, too: it stands for the limit of one parameter.
    fn refined(
        &self,
        (sweep, curve): (&Sweep, &Curve),
        last_error: f64,
        truth: &Reflected,
        watch: &Watch,
    ) -> Result<Vec<(String, f64)>> {
        let mut refined = Vec::new();
        let Some(&last) = sweep.values.last() else {
            return Ok(refined);
        };
        let settings = sweep.settings(curve, last);
        for refinement in REFINEMENTS.iter().filter(|r| r.option != sweep.option) {
            let Some((finer, text)) = (refinement.finer)(&settings) else {
                continue;
            };
            let limit = sweep.truth_settings();
            let own = match (self.truth, (refinement.finer)(&limit)) {
                (None, Some((limit, _))) => match self.solve(&limit, "truth", watch)? {
                    Some(solved) => Some(solved.reflected),
                    None => break,
                },
                _ => None,
            };
            let truth = own.as_ref().unwrap_or(truth);
            let Some(point) = self.point(&finer, truth, &text, watch)? else {
                break;
            };
            refined.push((text, point.error));
            if point.error < ENOUGH * last_error {
                break;
            }
        }
        Ok(refined)
    }

    /// Relative RMS and bias on common texels, the worst channel of each.
    fn error(&self, a: &Reflected, truth: &Reflected) -> Result<(f64, f64)> {
        let pair = Pair::new(a, truth, None).map_err(|mismatch| {
            let place = mismatch.face.map_or(String::new(), |k| format!("face {k}"));
            Error::input(&self.scene.name, place, mismatch.message)
        })?;
        Ok(pair.worst())
    }

    /// None when `watch` broke.
    fn solve(&self, settings: &Settings, name: &str, watch: &Watch) -> Result<Option<Answer<'a>>> {
        if watch.begin(name).is_err() {
            return Ok(None);
        }
        let told = |_: &str, done| watch.tell(name, done);
        let (start, own) = (Instant::now(), Watch::new(&told));
        let solver = Solver::drawing(self.gpu, &settings.transport);
        let Solved { mesh, run, .. } = self.scene.once(settings, solver, &own)?;
        Ok((!own.stopped()).then(|| Answer {
            reflected: Reflected::of(self.scene, &mesh, &run.field),
            seconds: start.elapsed().as_secs_f64(),
            shots: run.shots.len(),
        }))
    }
}
