//! Solves the methods of one scene in rounds, times them by wall clock and measures their errors.
//!
//! Each round solves every method once, so that other load on the machine affects all alike.

use super::methods::{SolveMethod, SolverKind, has_dense_truth};
use super::points::{ChartPoint, MeasuredCurve, SceneChart, fit_order};
use super::store::{Measurement, MeasurementContext, MeasurementStore, SolveFigures, hash_value};
use super::sweeps::Sweep;
use crate::plan::memory::{MemoryLimit, check_memory};
use common::energy::EnergyBalance;
use common::resample::{area_average, shared_pieces};
use common::scene::Scene;
use common::settings::Iteration;
use common::solution::{PhaseSeconds, StoredSolution, prepare_directory};
use common::texel::first_texels;
use common::{Error, Result};
use glam::DVec3;
use gpu::Gpu;
use oracle::diff::pair::GridPair;
use oracle::diff::reflected::ReflectedField;
use oracle::solve::progress::{PhaseCallback, ProgressMonitor};
use oracle::solve::solved::Solved;
use oracle::solve::solver::{ErrorTarget, MIN_ERROR, SolverChoice};
use oracle::solve::task::SolveTask;
use oracle::solve::{SolveAnswer, SolveRequest, dense};
use std::cell::Cell;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// A method that took longer is not repeated, seconds.
pub const MAX_REPEATED_SECONDS: f64 = 20.0;
/// Name of the phase that solves a truth.
const TRUTH_PHASE: &str = "truth";
/// Time between two reports of what is measured.
const REPORT_INTERVAL: Duration = Duration::from_secs(5);

/// The solution that errors are measured against.
struct ChartTruth<'a> {
    /// Description shown on the page.
    name: String,
    /// Part of each measurement's key.
    id: u64,
    /// Method that solves it; none if it was given.
    method: Option<SolveMethod>,
    /// Its values, solved when they are needed first.
    field: Option<ReflectedField<'a>>,
}

/// Scene, device, methods and store of the measurements of one scene.
pub struct ChartBench<'a> {
    scene: &'a Scene,
    gpu: Option<&'a Gpu>,
    store: &'a mut MeasurementStore,
    context: MeasurementContext,
    /// Folder of the truths.
    dir: PathBuf,
    methods: Vec<SolveMethod>,
    truths: Vec<ChartTruth<'a>>,
    /// Sweep, label and truth of each curve.
    curves: Vec<(Sweep, &'static str, usize)>,
}

impl<'a> ChartBench<'a> {
    /// Makes a bench without methods, which keeps its truths in `dir`.
    pub fn new(
        scene: &'a Scene,
        gpu: Option<&'a Gpu>,
        store: &'a mut MeasurementStore,
        context: MeasurementContext,
        dir: &Path,
    ) -> Self {
        Self {
            scene,
            gpu,
            store,
            context,
            dir: dir.to_path_buf(),
            methods: Vec::new(),
            truths: Vec::new(),
            curves: Vec::new(),
        }
    }

    /// Checks that a result of `solve` belongs to `scene`. Errors: it is of another scene.
    pub fn check_truth(scene: &Scene, stored: &StoredSolution) -> Result<()> {
        let truth = ReflectedField::from(stored);
        let own = ReflectedField { scene, ..truth.clone() };
        let Err(mismatch) = GridPair::new(&own, &truth, None) else {
            return Ok(());
        };
        let place = mismatch.face.map_or(String::new(), |k| format!("face {k}"));
        let message = format!("{} ({})", mismatch.message, scene.name);
        Err(Error::bad_input(stored.dir.join("result.json"), place, message))
    }

    /// Takes a result of `solve`, which must be of the bench's scene, as the truth of all methods that follow.
    pub fn use_given_truth(&mut self, name: &str, stored: &StoredSolution) {
        let field = ReflectedField {
            scene: self.scene,
            ..ReflectedField::from(stored)
        };
        let bits: Vec<[u64; 3]> = field.values.iter().map(|v| v.to_array().map(f64::to_bits)).collect();
        self.truths.push(ChartTruth {
            name: name.to_owned(),
            id: hash_value(&(bits, &field.resolutions)),
            method: None,
            field: Some(field),
        });
    }

    /// Adds `methods`; without a given truth theirs is the dense solver's on N×N texels, or else the CPU's to the
    /// smallest error that can be requested.
    pub fn add_methods(&mut self, methods: Vec<SolveMethod>, texels: u32) {
        if self.truths.is_empty() {
            let settings = dense::dense_settings(texels);
            let method = match has_dense_truth(self.scene, texels) {
                true => SolveMethod::new(SolverKind::Dense, "the dense solver", settings),
                false => SolveMethod::to_error(SolverKind::Cpu, MIN_ERROR, settings),
            };
            self.push_truth(method);
        }
        self.methods.extend(methods);
    }

    /// Adds the curves of a sweep; without a given truth it has its own.
    pub fn add_sweep(&mut self, sweep: &Sweep) {
        let has_gpu = self.gpu.is_some();
        let truth = match self.truths.first() {
            Some(ChartTruth { method: None, .. }) => 0,
            _ => self.push_truth(sweep.truth_method(has_gpu)),
        };
        for (label, change) in sweep.curves {
            let curve = self.curves.len();
            self.methods.extend(sweep.values.iter().map(|value| SolveMethod {
                varied: Some((curve, *value)),
                truth,
                ..sweep.method_at(*change, *value, has_gpu)
            }));
            self.curves.push((*sweep, label, truth));
        }
    }

    /// Adds a truth that `method` solves; returns its index.
    fn push_truth(&mut self, method: SolveMethod) -> usize {
        self.truths.push(ChartTruth {
            name: method.options.clone(),
            id: self.context.measurement_key(&method, 0),
            method: Some(method),
            field: None,
        });
        self.truths.len() - 1
    }

    /// Returns the measurements of `method` in chronological order.
    fn runs_of(&self, method: &SolveMethod) -> &[Measurement] {
        self.store.runs_of(&self.store_key(method))
    }

    fn store_key(&self, method: &SolveMethod) -> String {
        let key = self.context.measurement_key(method, self.truths[method.truth].id);
        format!("{key:016x}")
    }

    /// Returns the number of stored measurements of all methods.
    pub fn stored_runs(&self) -> usize {
        self.methods.iter().map(|method| self.runs_of(method).len()).sum()
    }

    /// Measures every method `rounds` times, except long and failed ones. Calls `report` every few seconds with the
    /// points measured so far, which are the result if `show` asks to stop. Errors: a truth cannot be solved, or a
    /// file cannot be written.
    pub fn measure_rounds(
        &mut self,
        rounds: usize,
        show: PhaseCallback,
        report: &mut dyn FnMut(SceneChart) -> Result<()>,
    ) -> Result<SceneChart> {
        let all = self.methods.len() as f64;
        let mut reported = Instant::now();
        for round in 0..rounds {
            for (k, method) in self.methods.clone().iter().enumerate() {
                let is_settled = |m: &Measurement| m.result.is_err() || m.total_seconds() > MAX_REPEATED_SECONDS;
                let runs = self.runs_of(method);
                if runs.len() > round || runs.iter().any(is_settled) {
                    continue;
                }
                let name = format!("round {} of {rounds}", round + 1);
                let show_round = |phase: &str, share: f64| match phase {
                    TRUTH_PHASE => show(phase, share),
                    _ => show(&name, (k as f64 + share.clamp(0.0, 1.0)) / all),
                };
                if !self.measure_method(method, &show_round)? {
                    return Ok(self.collect_chart(rounds));
                }
                if reported.elapsed() > REPORT_INTERVAL {
                    report(self.collect_chart(rounds))?;
                    reported = Instant::now();
                }
            }
        }
        Ok(self.collect_chart(rounds))
    }

    /// Returns what is measured, with at most `max_runs` runs of each method.
    fn collect_chart(&self, max_runs: usize) -> SceneChart {
        let points = self.methods.iter().filter_map(|method| {
            let runs = self.runs_of(method);
            let runs = runs[..runs.len().min(max_runs)].to_vec();
            (!runs.is_empty()).then(|| ChartPoint {
                method: method.clone(),
                runs,
                on_front: false,
            })
        });
        let adapter = self.gpu.map(|gpu| match gpu.line.software {
            true => format!("{} (software: its times say nothing about a GPU)", gpu.line.name),
            false => gpu.line.name.clone(),
        });
        let mut chart = SceneChart {
            scene: self.scene.name.clone(),
            faces: self.scene.faces.len(),
            texels: self.context.texels,
            truth: self.truths[0].name.clone(),
            adapter,
            points: points.collect(),
            ..SceneChart::default()
        };
        chart.missing = self.methods.len() - chart.points.len();
        chart.mark_fronts();
        for (k, (sweep, label, truth)) in self.curves.iter().enumerate() {
            let step = |p: &ChartPoint| Some([sweep.step_size(p.method.varied?.1), p.time_and_error()[1]]);
            let steps: Vec<[f64; 2]> = chart.curve_points(k).filter_map(step).collect();
            chart.curves.push(MeasuredCurve {
                name: sweep.name,
                option: sweep.option,
                label: (*label).to_owned(),
                truth: self.truths[*truth].name.clone(),
                order: fit_order(&steps),
                last_order: fit_order(&steps[steps.len().saturating_sub(2)..]),
            });
        }
        chart
    }

    /// Measures a method once and stores its figures or its failure; false if `show` asked to stop.
    /// Errors: the truth cannot be solved, or a file cannot be written.
    fn measure_method(&mut self, method: &SolveMethod, show: PhaseCallback) -> Result<bool> {
        if !self.solve_truth(method.truth, show)? {
            return Ok(false);
        }
        let Some(truth) = &self.truths[method.truth].field else {
            return Ok(false);
        };
        let (asked, late) = (Cell::new(false), Cell::new(false));
        let start = Instant::now();
        let progress = |phase: &str, done: f64| {
            late.set(late.get() || start.elapsed().as_secs_f64() > self.context.time_limit);
            asked.set(asked.get() || show(phase, done).is_break());
            match asked.get() || late.get() {
                true => ControlFlow::Break(()),
                false => ControlFlow::Continue(()),
            }
        };
        let monitor = ProgressMonitor::new(&progress);
        let solved = self.solve_method(method, &monitor);
        let seconds = start.elapsed().as_secs_f64();
        let result = match solved {
            _ if asked.get() => return Ok(false),
            _ if late.get() => Err(format!("took longer than {} s", self.context.time_limit)),
            Err(Error::Interrupted) => return Ok(false),
            Err(error) => Err(error.to_string()),
            Ok(solved) => self.compute_figures(method, &solved, truth),
        };
        let prepare = monitor.phase_seconds(&["prepare"]);
        let measurement = Measurement {
            prepare,
            solve: seconds - prepare,
            result,
        };
        let about = format!("{} {} {}", self.scene.name, method.solver.name(), method.options);
        self.store.append_run(self.store_key(method), about, measurement)?;
        Ok(true)
    }

    /// Solves a truth that has no values yet, or reads it if it was solved before; false if `show` asked to stop.
    /// Errors: it cannot be solved or stored.
    fn solve_truth(&mut self, k: usize, show: PhaseCallback) -> Result<bool> {
        let (ChartTruth { id, field: None, .. }, Some(method)) = (&self.truths[k], &self.truths[k].method) else {
            return Ok(true);
        };
        let dir = self.dir.join(format!("truth-{id:016x}"));
        if StoredSolution::read(&dir).is_err() {
            let progress = |_: &str, done| show(TRUTH_PHASE, done);
            let monitor = ProgressMonitor::new(&progress);
            let solved = match self.solve_method(method, &monitor) {
                Err(Error::Interrupted) => return Ok(false),
                _ if monitor.is_stopped() => return Ok(false),
                solved => solved?,
            };
            prepare_directory(&dir)?;
            let request = SolveRequest {
                task: self.scene,
                settings: &method.settings,
                solver: self.choose_solver(method)?,
            };
            let answer = SolveAnswer {
                solved,
                warnings: Vec::new(),
                estimate: None,
                notes: Vec::new(),
            };
            answer.to_solution(&request, &[], PhaseSeconds::default()).write(&dir)?;
        }
        let stored = StoredSolution::read(&dir)?;
        self.truths[k].field = Some(ReflectedField {
            scene: self.scene,
            ..ReflectedField::from(&stored)
        });
        Ok(true)
    }

    fn choose_solver(&self, method: &SolveMethod) -> Result<SolverChoice<'a>> {
        let gpu = match method.solver {
            SolverKind::Gpu => Some(self.gpu.ok_or_else(|| Error::Device("no adapter".into()))?),
            SolverKind::Cpu | SolverKind::Dense => None,
        };
        let texels = Some(method.settings.meshing.texels);
        Ok(match (method.target_error, method.solver) {
            (Some(error), _) => SolverChoice::to_error(gpu, ErrorTarget { error, texels }),
            (None, SolverKind::Dense) => SolverChoice::Dense,
            (None, _) => SolverChoice::shooting_on(gpu),
        })
    }

    fn solve_method(&self, method: &SolveMethod, monitor: &ProgressMonitor) -> Result<Solved> {
        let solver = self.choose_solver(method)?;
        if solver.is_shooting() {
            check_memory(self.scene, &method.settings, solver, MemoryLimit::of_this_machine())?;
        }
        self.scene.solve_once(&method.settings, solver, monitor)
    }

    /// Computes a solution's figures, or returns the reason that it cannot be compared with the truth.
    fn compute_figures(
        &self,
        method: &SolveMethod,
        solved: &Solved,
        truth: &ReflectedField,
    ) -> std::result::Result<SolveFigures, String> {
        let run = &solved.run;
        let reflected = ReflectedField::from_field(self.scene, &solved.mesh, &run.field);
        if !reflected.values.iter().all(|v| v.is_finite()) {
            return Err("some texels are not finite numbers".into());
        }
        let is_equal = truth.resolutions == reflected.resolutions && truth.values == reflected.values;
        if is_equal && method.varied.is_none() {
            return Err("equals the truth bit for bit, so there is nothing to compare".into());
        }
        let is_lit = |field: &ReflectedField| field.values.iter().any(|v| *v != DVec3::ZERO);
        if is_lit(truth) && !is_lit(&reflected) {
            return Err("reflects no light".into());
        }
        if !run.converged {
            let unshot = 100.0 * run.unshot_fraction();
            return Err(format!(
                "has not converged: {unshot:.2} % unshot after {} shots",
                run.shooters
            ));
        }
        if solved.one_by_one && method.settings.schedule.iteration == Iteration::Chebyshev {
            return Err("this engine shoots patch by patch, so this would repeat the base".into());
        }
        let resampled = resample_finer(&reflected, self.context.texels.unwrap_or(0));
        let pair = GridPair::new(&resampled, truth, None).map_err(|mismatch| mismatch.message)?;
        let (error, bias) = pair.worst_channel();
        if !error.is_finite() {
            return Err("the truth is black in a channel in which the solution is not".into());
        }
        Ok(SolveFigures {
            error,
            bias,
            imbalance: EnergyBalance::new(&solved.mesh, &run.field, &run.shots).imbalance,
            shots: run.shooters,
            passes: run.passes,
        })
    }
}

/// Resamples to at least N×N texels per face; a coarse texel's value is constant over it.
fn resample_finer<'a>(field: &ReflectedField<'a>, texels: u32) -> ReflectedField<'a> {
    let resolutions: Vec<[u32; 2]> = field
        .resolutions
        .iter()
        .map(|r| r.map(|side| side.max(texels)))
        .collect();
    if resolutions == field.resolutions {
        return field.clone();
    }
    let first = first_texels(&field.resolutions);
    let mut values = Vec::new();
    for (k, face) in field.scene.faces.iter().enumerate() {
        let shared = shared_pieces(face, field.resolutions[k], resolutions[k]);
        values.extend(area_average(
            &field.values[first[k]..first[k + 1]],
            &shared,
            resolutions[k],
        ));
    }
    ReflectedField {
        scene: field.scene,
        resolutions,
        values,
    }
}
