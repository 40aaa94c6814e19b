//! Solves the methods of one scene, times them by wall clock and measures their errors.

use super::methods::SolveMethod;
use super::points::{ChartPoint, MeasuredSet};
use super::store::{Measurement, MeasurementStore, SolveFigures, hash_scene};
use super::sweeps::MethodSet;
use crate::plan::memory::{check_memory, memory_limit};
use crate::studies::hashes::hash_value;
use crate::studies::limited::solve_limited;
use common::scene::Scene;
use common::settings::Iteration;
use common::solution::{PhaseSeconds, StoredSolution};
use common::{Error, Result};
use glam::DVec3;
use gpu::Gpu;
use oracle::diff::pair::GridPair;
use oracle::diff::reflected::ReflectedField;
use oracle::solve::progress::{PhaseCallback, ProgressMonitor};
use oracle::solve::solved::Solved;
use oracle::solve::solver::{ErrorTarget, SolverChoice, SolverKind};
use oracle::solve::task::SolveTask;
use oracle::solve::{SolveAnswer, SolveRequest};
use std::path::Path;

/// A method that took longer is not repeated, seconds.
pub const MAX_REPEATED_SECONDS: f64 = 20.0;

/// Scene, device and conditions of measurements.
#[derive(Clone, Copy)]
pub struct ChartBench<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The GPU, if there is one.
    pub gpu: Option<&'a Gpu>,
    /// Folder of the truths.
    pub dir: &'a Path,
    /// Hash of the program.
    pub program: u64,
    /// Texels per side of a face on which errors are measured; none: the common ones of method and truth.
    pub texels: Option<u32>,
    /// Time limit of a solve, seconds.
    pub time_limit: f64,
    /// Solves of each method; the time of the fastest counts.
    pub repeats: u32,
}

impl ChartBench<'_> {
    /// Returns the key of the measurements of `method` against the truth with this key.
    pub fn measurement_key(&self, method: &SolveMethod, truth: &str) -> String {
        let gpu = self.gpu.filter(|_| method.solver == SolverKind::Gpu);
        let key = hash_value(&format!(
            "{} {} {:?} {} {} {:?} {truth} {:?} {:?} {:?}",
            hash_scene(self.scene),
            self.program,
            self.texels,
            self.time_limit,
            self.repeats,
            gpu.map(|gpu| &gpu.line.name),
            method.solver,
            method.settings,
            method.target_error
        ));
        format!("{key:016x}")
    }

    /// Returns the number of methods that are in the store.
    pub fn count_stored(&self, set: &MethodSet, store: &MeasurementStore) -> usize {
        let truth = self.measurement_key(&set.truth, "");
        let keys = set.methods.iter().map(|method| self.measurement_key(method, &truth));
        keys.filter(|key| store.find_measurement(key).is_some()).count()
    }

    /// Measures the methods that are not in the store, until `show` asks to stop, and returns all that are. Errors: the
    /// truth cannot be solved, or a file cannot be written.
    pub fn measure_set(
        &self,
        set: &MethodSet,
        store: &mut MeasurementStore,
        show: PhaseCallback,
    ) -> Result<MeasuredSet> {
        let truth_key = self.measurement_key(&set.truth, "");
        let mut truth = None;
        for (k, method) in set.methods.iter().enumerate() {
            let key = self.measurement_key(method, &truth_key);
            if store.find_measurement(&key).is_some() {
                continue;
            }
            if truth.is_none() {
                truth = self.solve_truth(&set.truth, &truth_key, show)?;
            }
            let Some(truth) = &truth else { break };
            let share = |done: f64| (k as f64 + done.clamp(0.0, 1.0)) / set.methods.len() as f64;
            let show = |_: &str, done| show("methods", share(done));
            let Some(measurement) = self.measure_method(method, truth, &show) else {
                break;
            };
            store.add_measurement(key, measurement)?;
        }
        let found = |method: &SolveMethod| {
            let measurement = store.find_measurement(&self.measurement_key(method, &truth_key))?;
            Some(ChartPoint {
                method: method.clone(),
                measurement: measurement.clone(),
                on_front: false,
            })
        };
        let points: Vec<ChartPoint> = set.methods.iter().filter_map(found).collect();
        Ok(MeasuredSet::new(set, points))
    }

    /// Measures a method; of its solves the fastest counts. None if `show` asked to stop.
    fn measure_method(&self, method: &SolveMethod, truth: &ReflectedField, show: PhaseCallback) -> Option<Measurement> {
        let mut fastest: Option<Measurement> = None;
        for _ in 0..self.repeats {
            let (answer, seconds) = solve_limited(self.time_limit, show, |monitor| self.solve_method(method, monitor))?;
            let found = Measurement {
                seconds,
                result: answer.and_then(|solved| self.compute_figures(method, &solved, truth)),
            };
            let is_settled = found.result.is_err() || found.seconds > MAX_REPEATED_SECONDS;
            if fastest.as_ref().is_none_or(|known| found.seconds < known.seconds) {
                fastest = Some(found);
            }
            if is_settled {
                break;
            }
        }
        fastest
    }

    /// Solves a truth, or reads it if it was solved before; none if `show` asked to stop. Errors: it cannot be solved
    /// or stored.
    fn solve_truth(&self, method: &SolveMethod, key: &str, show: PhaseCallback) -> Result<Option<ReflectedField<'_>>> {
        let dir = self.dir.join(format!("truth-{key}"));
        if StoredSolution::read(&dir).is_err() {
            let progress = |_: &str, done| show("truth", done);
            let monitor = ProgressMonitor::new(&progress);
            let solved = match self.solve_method(method, &monitor) {
                Err(Error::Interrupted) => return Ok(None),
                _ if monitor.is_stopped() => return Ok(None),
                solved => solved?,
            };
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
        Ok(Some(ReflectedField {
            scene: self.scene,
            ..ReflectedField::from(&stored)
        }))
    }

    fn choose_solver(&self, method: &SolveMethod) -> Result<SolverChoice<'_>> {
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
            check_memory(self.scene, &method.settings, solver, memory_limit(solver))?;
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
        if is_equal && method.curve.is_none() {
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
        // At least N×N texels: a coarse texel's value is constant over it.
        let finer = |size: &[u32; 2]| size.map(|side| side.max(self.texels.unwrap_or(0)));
        let resampled = reflected.average_onto(reflected.resolutions.iter().map(finer).collect());
        let pair = GridPair::new(&resampled, truth, None).map_err(|mismatch| mismatch.message)?;
        let (error, bias) = pair.worst_channel();
        if !(error.is_finite() && bias.is_finite()) {
            return Err("the truth is black in a channel in which the solution is not".into());
        }
        Ok(SolveFigures { error, bias })
    }
}
