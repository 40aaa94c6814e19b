//! Solves the points of a sweep and measures their errors against its truth. Points that are in the
//! store are not solved again.

use super::order::{self, CurveEvidence, ROUNDING_ERROR, explain_curve};
use super::sweeps::{PARAMETER_REFINEMENTS, Sweep, SweepCurve, SweepTruth};
use super::{MeasuredCurve, MeasuredSweep, SweepPoint};
use crate::studies::chart::measure::{compare_fields, solve_figures};
use crate::studies::chart::store::{MeasurementContext, MeasurementStore, hash_value};
use crate::studies::chart::truth::ChartTruth;
use crate::studies::chart::{Measurement, SolveFigures, SolverKind};
use common::scene::Scene;
use common::settings::Settings;
use common::{Error, Result};
use gpu::Gpu;
use oracle::diff::reflected::ReflectedField;
use oracle::solve::progress::ProgressMonitor;
use oracle::solve::solved::Solved;
use oracle::solve::solver::SolverChoice;
use oracle::solve::task::SolveTask;
use std::time::Instant;

/// A refinement that reduces the error below this share explains a stalled curve.
const EXPLAINED_SHARE: f64 = 0.5;

/// Scene, GPU, truth and store of the sweeps.
pub struct SweepSetup<'a> {
    scene: &'a Scene,
    gpu: Option<&'a Gpu>,
    given_truth: Option<&'a ChartTruth>,
    store: &'a mut MeasurementStore,
    context: MeasurementContext,
}

/// The truth of some points.
struct PointTruth<'a> {
    /// Settings of its solve, unless it is given.
    settings: Settings,
    /// Context of the points' keys.
    context: MeasurementContext,
    /// Its values; a truth that is not given is solved when the first point needs it.
    field: Option<ReflectedField<'a>>,
}

impl<'a> SweepSetup<'a> {
    /// Prepares the sweeps of `scene`. `gpu` draws item buffers; without one the CPU's twin does.
    /// Without `given_truth` each sweep has its own truth.
    pub fn new(
        scene: &'a Scene,
        gpu: Option<&'a Gpu>,
        given_truth: Option<&'a ChartTruth>,
        store: &'a mut MeasurementStore,
    ) -> Self {
        Self {
            scene,
            gpu,
            given_truth,
            store,
            context: MeasurementContext::new(scene, gpu, (0, f64::INFINITY)),
        }
    }

    /// Measures one sweep. After `watch` asked to stop, the sweep holds the points measured so far, or
    /// is none without any. Errors: a solve fails, the truth is of another scene, or the store cannot
    /// be written.
    pub fn measure_sweep(&mut self, sweep: &Sweep, watch: &ProgressMonitor) -> Result<Option<MeasuredSweep>> {
        let mut truth = self.sweep_truth(sweep.truth_settings());
        let mut measured = MeasuredSweep {
            name: sweep.name,
            option: sweep.option,
            truth: match (self.given_truth, sweep.truth) {
                (Some(given), _) => given.name.clone(),
                (None, SweepTruth::Finer(value)) => format!("{} {value}", sweep.option),
                (None, SweepTruth::Limit { name, .. }) => name.to_owned(),
            },
            base: serde_json::to_value(sweep.settings_at(&sweep.curves[0], sweep.values[0])).unwrap_or_default(),
            curves: Vec::new(),
        };
        for curve in sweep.curves {
            let points = self.measure_points(sweep, curve, &mut truth, watch)?;
            let complete = points.len() == sweep.values.len();
            if !points.is_empty() {
                let curve = self.analyse_curve(sweep, curve, points, &mut truth, watch)?;
                measured.curves.push(curve);
            }
            if !complete {
                break;
            }
        }
        Ok((!measured.curves.is_empty()).then_some(measured))
    }

    /// Returns the given truth, or one with `settings`, which is not solved yet.
    fn sweep_truth(&self, settings: Settings) -> PointTruth<'a> {
        let mut context = self.context.clone();
        context.truth = match self.given_truth {
            Some(truth) => truth.id,
            None => hash_value(&self.measurement_key(&context, &settings)),
        };
        let field = self.given_truth.map(|truth| (&truth.stored).into());
        PointTruth {
            settings,
            context,
            field,
        }
    }

    fn measurement_key(&self, context: &MeasurementContext, settings: &Settings) -> String {
        let drawn = self.gpu.is_some() && settings.transport.visibility.item_buffer().is_some();
        let solver = if drawn { SolverKind::Gpu } else { SolverKind::Cpu };
        context.measurement_key(solver, settings, None)
    }

    fn measure_points(
        &mut self,
        sweep: &Sweep,
        curve: &SweepCurve,
        truth: &mut PointTruth<'a>,
        watch: &ProgressMonitor,
    ) -> Result<Vec<SweepPoint>> {
        let mut points = Vec::new();
        for &value in sweep.values {
            let name = format!("{} {value}, {}", sweep.option, curve.label);
            let settings = sweep.settings_at(curve, value);
            match self.measure_point((&settings, value), truth, &name, watch)? {
                Some(point) => points.push(point),
                None => break,
            }
        }
        Ok(points)
    }

    /// Returns the point of `settings`, from the store if it is there; none if `watch` asked to stop.
    fn measure_point(
        &mut self,
        (settings, value): (&Settings, f64),
        truth: &mut PointTruth<'a>,
        name: &str,
        watch: &ProgressMonitor,
    ) -> Result<Option<SweepPoint>> {
        let key = self.measurement_key(&truth.context, settings);
        let measurement = match self.store.runs_of(&key).first() {
            Some(stored) => stored.clone(),
            None => {
                if truth.field.is_none() {
                    let solved = self.solve_once(&truth.settings, "truth", watch)?;
                    truth.field = solved.map(|(solved, _)| self.reflected_field(&solved));
                }
                let Some(field) = &truth.field else {
                    return Ok(None);
                };
                let Some((solved, seconds)) = self.solve_once(settings, name, watch)? else {
                    return Ok(None);
                };
                let measurement = self.measure_solve(&solved, seconds, field)?;
                let description = format!("{} {name}", self.scene.name);
                if measurement.is_sound() {
                    self.store.append_run(&key, &description, measurement.clone())?;
                }
                measurement
            }
        };
        let seconds = measurement.total_seconds();
        let figures = measurement.result.map_err(Error::Fault)?;
        Ok(Some(SweepPoint {
            value,
            error: figures.error,
            bias: figures.bias,
            seconds,
            shots: figures.shots,
        }))
    }

    /// Measures the error of a solve, on common texels.
    fn measure_solve(&self, solved: &Solved, seconds: [f64; 2], truth: &ReflectedField) -> Result<Measurement> {
        let compared = compare_fields(&self.reflected_field(solved), truth);
        let (error, bias) = compared.map_err(|mismatch| {
            let place = mismatch.face.map_or(String::new(), |k| format!("face {k}"));
            Error::bad_input(&self.scene.name, place, mismatch.message)
        })?;
        Ok(Measurement {
            prepare: seconds[0],
            solve: seconds[1],
            result: Ok(SolveFigures {
                shots: solved.run.shots.len() as u64,
                ..solve_figures(solved, error, error, bias)
            }),
        })
    }

    /// Fits the order of measured points and explains their course.
    fn analyse_curve(
        &mut self,
        sweep: &Sweep,
        curve: &SweepCurve,
        points: Vec<SweepPoint>,
        truth: &mut PointTruth<'a>,
        watch: &ProgressMonitor,
    ) -> Result<MeasuredCurve> {
        let steps: Vec<(f64, f64)> = points.iter().map(|p| (sweep.step_size(p.value), p.error)).collect();
        let above: Vec<(f64, f64)> = steps.iter().copied().filter(|s| s.1 > ROUNDING_ERROR).collect();
        // Only the first curve has the truth's settings.
        let first = std::ptr::eq(curve, &raw const sweep.curves[0]);
        let order_beside = match (self.given_truth, sweep.truth) {
            (None, SweepTruth::Finer(value)) if first => order::fit_order_beside_truth(&above, sweep.step_size(value)),
            _ => None,
        };
        let order = order::fit_slope(&above);
        let mut evidence = CurveEvidence {
            ends: [steps[0].1, steps[steps.len() - 1].1],
            order,
            last: order::last_slope(&steps),
            refined: Vec::new(),
        };
        if evidence.is_stalled() && points.len() == sweep.values.len() {
            evidence.refined = self.refine_parameters((sweep, curve), &points, truth, watch)?;
        }
        let (converges, finding) = explain_curve(&evidence);
        Ok(MeasuredCurve {
            label: curve.label.to_owned(),
            order,
            order_beside,
            finding,
            converges,
            points,
        })
    }

    /// Measures the last point's error with each other parameter refined, until one removes most of it.
    /// The sweep's own truth is refined too, since it is the limit of the swept parameter only.
    fn refine_parameters(
        &mut self,
        (sweep, curve): (&Sweep, &SweepCurve),
        points: &[SweepPoint],
        truth: &mut PointTruth<'a>,
        watch: &ProgressMonitor,
    ) -> Result<Vec<(String, f64)>> {
        let mut refined = Vec::new();
        let Some(last) = points.last() else {
            return Ok(refined);
        };
        let settings = sweep.settings_at(curve, last.value);
        for refinement in PARAMETER_REFINEMENTS.iter().filter(|r| r.option != sweep.option) {
            let Some((finer, text)) = refinement.refine(&settings) else {
                continue;
            };
            let mut refined_truth = match (self.given_truth, refinement.refine(&truth.settings)) {
                (None, Some((limit, _))) => Some(self.sweep_truth(limit)),
                _ => None,
            };
            let truth = refined_truth.as_mut().unwrap_or(truth);
            let point = (&finer, last.value);
            let Some(point) = self.measure_point(point, truth, &text, watch)? else {
                break;
            };
            refined.push((text, point.error));
            if point.error < EXPLAINED_SHARE * last.error {
                break;
            }
        }
        Ok(refined)
    }

    fn reflected_field(&self, solved: &Solved) -> ReflectedField<'a> {
        ReflectedField::from_field(self.scene, &solved.mesh, &solved.run.field)
    }

    /// Solves once and returns the seconds of preparation and solve; none if `watch` asked to stop.
    fn solve_once(
        &self,
        settings: &Settings,
        name: &str,
        watch: &ProgressMonitor,
    ) -> Result<Option<(Solved, [f64; 2])>> {
        if watch.begin_phase(name).is_err() {
            return Ok(None);
        }
        let progress = |_: &str, done| watch.report_share(name, done);
        let (start, inner_watch) = (Instant::now(), ProgressMonitor::new(&progress));
        let solver = SolverChoice::for_transport(self.gpu, &settings.transport);
        let solved = self.scene.solve_once(settings, solver, &inner_watch)?;
        let (seconds, prepare) = (start.elapsed().as_secs_f64(), inner_watch.phase_seconds(&["prepare"]));
        Ok((!inner_watch.is_stopped()).then_some((solved, [prepare, seconds - prepare])))
    }
}
