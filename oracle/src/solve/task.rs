//! Tasks of the pipeline: a scene, or objects in a captured room ([`crate::relight::task`]).

use super::error_estimate::closure_error;
use super::gpu_linker::LinkerOnGpu;
use super::interrupt::is_interrupted;
use super::plausibility::explain_darkness;
use super::progress::{ProgressMonitor, step_progress};
use super::regather::ErrorEstimate;
use super::solved::Solved;
use super::solver::SolverChoice;
use super::warnings;
use super::{adaptive, dense, regather, solve_to_error};
use common::Result;
use common::cover::sampled_mesh_until;
use common::mesh::Mesh;
use common::passes::{self, Engine, ProgressCallback};
use common::scene::Scene;
use common::settings::{Iteration, Settings};
use common::shooting::SolveRun;
use common::solution::Warning;
use cpu::hierarchy::linker::LinkMethod;
use cpu::hierarchy::sky::{SKY_ERROR, receive_sky};

/// A task of the pipeline.
pub trait SolveTask {
    /// The scene with all faces.
    fn scene(&self) -> &Scene;

    /// Solves the task with these settings.
    ///
    /// Errors: those of the solver; [`common::Error::Interrupted`].
    fn solve_once(&self, settings: &Settings, solver: SolverChoice, progress: &ProgressMonitor) -> Result<Solved>;

    /// Estimates the error of the result; `None` where that is impossible.
    ///
    /// Errors: those of the estimate's own linear system.
    fn estimate_error(&self, solved: &Solved) -> Result<Option<ErrorEstimate>>;

    /// Collects the reasons for which the result may be more than 2 % off.
    fn collect_warnings(&self, solved: &Solved, estimate: Option<&ErrorEstimate>) -> Vec<Warning>;

    /// Returns the reason if everything is dark; then there is no error to estimate.
    fn explain_darkness(&self, solved: &Solved) -> Option<String>;
}

impl SolveTask for Scene {
    fn scene(&self) -> &Scene {
        self
    }

    fn solve_once(&self, settings: &Settings, solver: SolverChoice, progress: &ProgressMonitor) -> Result<Solved> {
        match solver {
            SolverChoice::Dense => return dense::solve_dense(self, settings, progress),
            SolverChoice::Hierarchy(target) => {
                return solve_to_error::solve_adaptively(self, settings, target, LinkMethod::Shafts, progress);
            }
            SolverChoice::GpuHierarchy(gpu, target) => {
                let maker = LinkerOnGpu::factory_on(gpu, &[]);
                return solve_to_error::solve_adaptively(self, settings, target, LinkMethod::Custom(&maker), progress);
            }
            SolverChoice::Cpu | SolverChoice::Gpu(_) => {}
        }
        solve_by_shooting(self, settings, solver, progress, |engine, mesh, watch| {
            passes::solve_by_schedule(engine, mesh, &settings.schedule, watch)
        })
    }

    fn estimate_error(&self, solved: &Solved) -> Result<Option<ErrorEstimate>> {
        if solved.dense.is_some() {
            return Ok(None);
        }
        if let Some(history) = &solved.history {
            let (mesh, run) = (&solved.mesh, &solved.run);
            return Ok(history.estimate_error(mesh, run, closure_error(mesh, run)));
        }
        regather::estimate_by_regathering(self, &solved.settings, &solved.mesh, &solved.run.field).map(Some)
    }

    fn collect_warnings(&self, solved: &Solved, estimate: Option<&ErrorEstimate>) -> Vec<Warning> {
        let warnings = warnings::collect_warnings(self, &solved.mesh, &solved.run, estimate);
        match solved.dense {
            Some(_) => dense::adapt_advice(warnings),
            None if solved.history.is_some() => adaptive::adapt_advice(warnings),
            None => warnings,
        }
    }

    fn explain_darkness(&self, solved: &Solved) -> Option<String> {
        explain_darkness(self, &solved.mesh, &solved.run)
    }
}

/// Makes the mesh of a solve by shooting: its texels, its patches, and the light from outside.
///
/// Errors: those of [`common::mesh::Mesh::new`] and of [`receive_sky`]; [`common::Error::Interrupted`].
pub fn prepare_mesh(scene: &Scene, settings: &Settings, progress: &ProgressMonitor) -> Result<Mesh> {
    let mesh = progress.time_phase("prepare", || {
        sampled_mesh_until(scene, &settings.meshing, &is_interrupted)
    });
    let mut mesh = mesh.inspect_err(|_| progress.mark_stopped())?;
    let mut callback = step_progress(progress, "light from outside");
    progress.time_phase("prepare", || receive_sky(scene, &mut mesh, SKY_ERROR, &mut callback))?;
    Ok(mesh)
}

/// Solves a scene by shooting: makes its mesh and its engine, and lets `run` run the engine.
///
/// Errors: those of the mesh, the engine and `run`; [`common::Error::Interrupted`].
pub fn solve_by_shooting(
    scene: &Scene,
    settings: &Settings,
    solver: SolverChoice,
    progress: &ProgressMonitor,
    run: impl FnOnce(&mut dyn Engine, &Mesh, ProgressCallback) -> Result<SolveRun>,
) -> Result<Solved> {
    let mesh = prepare_mesh(scene, settings, progress)?;
    let mut engine = progress.time_phase("prepare", || solver.create_engine(&mesh, &settings.transport))?;
    let one_by_one = settings.schedule.iteration != Iteration::Southwell && !engine.transfer_fits();
    let run = progress.time_phase("solve", || {
        let mut callback = |done| progress.report_share("shooting", done);
        run(engine.as_mut(), &mesh, &mut callback)
    })?;
    drop(engine);
    Ok(Solved {
        one_by_one,
        ..Solved::new(settings, mesh, run)
    })
}
