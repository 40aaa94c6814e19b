//! The solve pipeline: mesh → engine → run → error estimate → warnings → stored solution. The commands
//! `solve`, `relight`, `compare`, the studies and `plan` all use it.

pub mod adaptive;
mod adjacency;
pub mod dense;
pub mod error_estimate;
pub mod forecast;
pub mod gpu_linker;
mod interpolation_error;
pub mod interrupt;
mod lamp_gather;
pub mod plausibility;
pub mod progress;
mod ray_steps;
pub mod refinement;
pub mod regather;
pub mod residual;
pub mod resolution;
mod shadow_steps;
pub mod solve_to_error;
pub mod solved;
pub mod solver;
pub mod step;
mod step_forecast;
pub mod task;
pub mod warnings;

use common::Result;
use common::scene::Scene;
use common::settings::Settings;
use common::solution::{PhaseSeconds, Solution, Warning};
use plausibility::check_finite;
use progress::ProgressMonitor;
use regather::ErrorEstimate;
use solved::{DenseReport, Solved};
use solver::SolverChoice;
use task::SolveTask;

/// A solve to be done.
#[derive(Clone, Copy)]
pub struct SolveRequest<'a> {
    /// The scene or relight to solve.
    pub task: &'a dyn SolveTask,
    /// The options in force.
    pub settings: &'a Settings,
    /// The solver to use.
    pub solver: SolverChoice<'a>,
}

/// A finished solve with its error estimate and warnings.
pub struct SolveAnswer {
    /// The solve, on the requested texels.
    pub solved: Solved,
    /// Reasons for which the result may be more than 2 % off.
    pub warnings: Vec<Warning>,
    /// Estimate of the error; `None` if it was not estimated.
    pub estimate: Option<ErrorEstimate>,
    /// Choices and their reasons, one line each.
    pub notes: Vec<String>,
}

impl SolveAnswer {
    /// Estimated error of each texel, W/m², where it is known.
    pub fn error_map(&self, scene: &Scene) -> Option<Vec<f32>> {
        let history = self.solved.history.as_ref()?;
        history.error_map(&scene.faces, &self.solved.mesh)
    }

    /// Converts the answer to the form in which it is stored.
    pub fn to_solution<'a>(
        &'a self,
        request: &SolveRequest<'a>,
        notes: &'a [String],
        seconds: PhaseSeconds,
    ) -> Solution<'a> {
        Solution {
            scene: request.task.scene(),
            mesh: &self.solved.mesh,
            solver: request.solver.name(),
            adapter: request.solver.adapter_name(),
            settings: &self.solved.settings,
            run: &self.solved.run,
            open: self.solved.open.as_deref(),
            certificate: self.estimate.as_ref().map(ErrorEstimate::to_json),
            texel_error: self.error_map(request.task.scene()),
            warnings: &self.warnings,
            notes,
            matrix: self.solved.dense.as_ref().map(DenseReport::to_json),
            relit: None,
            error: request.solver.error_target().map(|target| target.error),
            seconds,
        }
    }
}

/// Solves a task and estimates the error of the result. After an interruption the answer holds the part that
/// was done.
///
/// Errors: those of the task and its solver; [`common::Error::Usage`] of settings with which it would not end.
pub fn solve_request(request: &SolveRequest, progress: &ProgressMonitor) -> Result<SolveAnswer> {
    let SolveRequest { task, settings, solver } = *request;
    solver.check_settings(settings)?;
    let solved = task.solve_once(settings, solver, progress)?;
    let mut estimate = progress.time_phase("check", || task.estimate_error(&solved))?;
    check_finite(task.scene(), &solved.run)?;
    let mut notes = Vec::new();
    if let Some(dark) = task.explain_darkness(&solved) {
        estimate = None;
        notes.push(dark);
    } else if let (Some(target), Some(history)) = (solver.error_target(), &solved.history) {
        notes.extend(history.describe_unmet_target(target.error, estimate.as_ref()));
        notes.extend(history.describe_interpolation(target.error));
        let worst = estimate
            .as_ref()
            .and_then(|estimate| estimate.describe_worst_faces(task.scene()));
        notes.extend(worst);
    }
    if progress.is_stopped() {
        notes.push(if solved.run.converged {
            "interrupted: the last whole solve was kept".into()
        } else {
            "interrupted: the result holds what had been shot by then".into()
        });
    }
    let warnings = task.collect_warnings(&solved, estimate.as_ref());
    Ok(SolveAnswer {
        solved,
        warnings,
        estimate,
        notes,
    })
}
