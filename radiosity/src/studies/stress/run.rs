//! Runs a case for `radiosity stress`: every value, every method, CPU and GPU.

use super::cases::Case;
use super::methods::{AtlasMethod, MethodSolver};
use super::trial::{Trial, TruthCache};
use super::{AtlasRow, CaseStudy, NOT_COMPARABLE, SolverSide, Specimen};
use crate::studies::limited::solve_limited;
use common::Result;
use glam::DVec3;
use gpu::Gpu;
use oracle::diff::reflected::ReflectedField;
use oracle::relight::stage::RelightStage;
use oracle::relight::task::RelightTask;
use oracle::solve::progress::ProgressMonitor;
use oracle::solve::solved::Solved;
use oracle::solve::solver::{ErrorTarget, SolverChoice};
use oracle::solve::task::SolveTask;
use oracle::solve::{SolveAnswer, SolveRequest, solve_request};
use std::ops::ControlFlow;

/// Time limit of a solve, seconds: ten times the longest solve, so that load on the machine does not
/// change a verdict.
pub const MAX_SOLVE_SECONDS: f64 = 200.0;

/// GPU and limits of a run.
pub struct AtlasRun<'a> {
    /// The GPU, if there is one.
    pub gpu: Option<&'a Gpu>,
    /// Returns true when the run is to stop.
    pub stop: &'a dyn Fn() -> bool,
    /// Time limit of a solve, seconds.
    pub max_seconds: f64,
    /// True if errors of answers by shooting are estimated and warned about, too, in ten times the solve's time.
    pub estimates_shooting: bool,
}

impl Default for AtlasRun<'_> {
    /// The CPU alone, without limits.
    fn default() -> Self {
        Self {
            gpu: None,
            stop: &|| false,
            max_seconds: f64::INFINITY,
            estimates_shooting: true,
        }
    }
}

impl AtlasRun<'_> {
    /// Runs a case. After a stop, rows of later values are missing. Errors: a scene or a truth fails.
    pub fn run_case(&self, case: &Case, watch: &ProgressMonitor) -> Result<CaseStudy> {
        self.run_values(case, case.values, case.build, 1, watch)
    }

    /// Runs a case at these values of scenes from `build`, and keeps the solutions of `max_specimens` scenes: of a case
    /// the easiest, of random scenes those with the largest errors.
    pub fn run_values(
        &self,
        case: &Case,
        values: &[f64],
        build: impl Fn(f64) -> Result<Trial>,
        max_specimens: usize,
        watch: &ProgressMonitor,
    ) -> Result<CaseStudy> {
        let (mut rows, mut specimens) = (Vec::new(), Vec::new());
        let mut truths = TruthCache::default();
        for (done, value) in values.iter().enumerate() {
            // The methods poll `stop` themselves.
            let _ = watch.report_count(case.parameter, done as u64, values.len() as u64);
            if (self.stop)() {
                break;
            }
            let trial = build(*value)?;
            let truth = truths.truth_of(&trial)?;
            let Some((found, solved)) = self.run_methods(case, *value, &trial, &truth) else {
                break;
            };
            let error = found.first().and_then(|row| row.error).unwrap_or(0.0);
            specimens.extend(solved.map(|solved| Specimen {
                value: *value,
                error,
                scene: trial.scene,
                mesh: solved.mesh,
                field: solved.run.field,
            }));
            if case.is_random() {
                specimens.sort_by(|a, b| b.error.total_cmp(&a.error));
            }
            specimens.truncate(max_specimens);
            rows.extend(found);
        }
        Ok(CaseStudy {
            case: *case,
            rows,
            specimens,
        })
    }

    /// Runs all methods on one trial and returns rows and the first solution; none after a stop.
    fn run_methods(
        &self,
        case: &Case,
        value: f64,
        trial: &Trial,
        truth: &[DVec3],
    ) -> Option<(Vec<AtlasRow>, Option<Solved>)> {
        let (mut rows, mut first) = (Vec::new(), None);
        for method in case.methods {
            let (cpu, solved) = self.run_method(trial, method, None, truth)?;
            first = first.or(solved);
            let gpu = match self.gpu.filter(|_| method.solver != MethodSolver::Dense) {
                None => None,
                gpu => Some(self.run_method(trial, method, gpu, truth)?.0),
            };
            rows.push(AtlasRow {
                scene: trial.description.clone(),
                requested_error: trial.requested_error,
                ..AtlasRow::new(case, value, method.name, cpu, gpu)
            });
        }
        Some((rows, first))
    }

    /// Runs a method on a trial and returns its part of the row, unjudged, with the solution, if there is one;
    /// none if `stop` returned true. A solve that took too long has no solution.
    pub fn run_method(
        &self,
        trial: &Trial,
        method: &AtlasMethod,
        gpu: Option<&Gpu>,
        truth: &[DVec3],
    ) -> Option<(SolverSide, Option<Solved>)> {
        let show = |_: &str, _| match (self.stop)() {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        };
        let solve = |watch: &ProgressMonitor| self.solve_trial(trial, method, gpu, watch);
        let (answer, seconds) = solve_limited(self.max_seconds, &show, solve)?;
        if (self.stop)() {
            return None;
        }
        let mut side = SolverSide {
            seconds,
            ..SolverSide::default()
        };
        let answer = match answer {
            Ok(answer) => answer,
            Err(message) => {
                side.message = Some(message);
                return Some((side, None));
            }
        };
        side.warnings = answer.warnings.iter().map(|w| w.code.as_str().into()).collect();
        side.notes = answer.notes;
        side.estimate = answer.estimate.map(|estimate| estimate.error);
        let solved = answer.solved;
        let reflected = ReflectedField::from_field(&trial.scene, &solved.mesh, &solved.run.field);
        match trial.error_and_noise(&reflected.values, truth) {
            Ok((error, noise)) => (side.error, side.noise) = (Some(error), noise),
            Err(message) => side.message = Some(format!("{NOT_COMPARABLE}: {message}")),
        }
        Some((side, Some(solved)))
    }

    fn solve_trial(
        &self,
        trial: &Trial,
        method: &AtlasMethod,
        gpu: Option<&Gpu>,
        watch: &ProgressMonitor,
    ) -> Result<SolveAnswer> {
        let settings = &method.settings_on(trial.texels, gpu.is_some());
        let texels = Some(trial.texels);
        let solver = match method.solver {
            MethodSolver::ToError(error) => {
                let error = trial.requested_error.unwrap_or(error);
                SolverChoice::to_error(gpu, ErrorTarget { error, texels })
            }
            MethodSolver::Shooting => SolverChoice::shooting_on(gpu),
            MethodSolver::Dense => SolverChoice::Dense,
        };
        let solve = |task: &dyn SolveTask| {
            if method.solver == MethodSolver::Shooting && !self.estimates_shooting {
                return Ok(SolveAnswer {
                    solved: task.solve_once(settings, solver, watch)?,
                    warnings: Vec::new(),
                    estimate: None,
                    notes: Vec::new(),
                });
            }
            solve_request(&SolveRequest { task, settings, solver }, watch)
        };
        if trial.room == 0 {
            return solve(&trial.scene);
        }
        let stage = &RelightStage::new(&trial.scene, trial.room, trial.texels);
        let method = method.relighting;
        solve(&RelightTask {
            stage,
            method,
            trace: None,
        })
    }
}
