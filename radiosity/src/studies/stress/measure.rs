//! Runs one method on one solver: catches panics, limits the time and computes the error.

use super::accuracy;
use super::methods::{AtlasMethod, DEFAULT_METHOD, MethodKind};
use super::trial::{MethodSuite, Trial};
use super::{NOT_COMPARABLE, SolverSide, Verdict};
use common::mesh::Mesh;
use common::shooting::RadiosityField;
use common::{Error, Result};
use glam::DVec3;
use gpu::Gpu;
use oracle::diff::reflected::ReflectedField;
use oracle::relight::stage::RelightStage;
use oracle::relight::task::RelightTask;
use oracle::solve::progress::ProgressMonitor;
use oracle::solve::solved::Solved;
use oracle::solve::solver::{DEFAULT_ERROR, ErrorTarget, REFERENCE_ERROR, SolverChoice};
use oracle::solve::{SolveAnswer, SolveRequest, solve_request};
use std::any::Any;
use std::cell::Cell;
use std::ops::ControlFlow;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::Instant;

/// Time limit of a solve, seconds: ten times the longest solve, so that load on the machine does not
/// change a verdict.
pub const MAX_SOLVE_SECONDS: f64 = 200.0;

/// Result of one attempt.
pub struct TrialResult {
    /// The solver's part of the row.
    pub side: SolverSide,
    /// The solution, if there is one.
    pub answer: Option<TrialAnswer>,
}

/// A solution, kept for the pictures.
pub struct TrialAnswer {
    /// Mesh of the solution.
    pub mesh: Mesh,
    /// Radiosity and irradiance on the mesh.
    pub field: RadiosityField,
    /// B − E of each texel in face order, W/m².
    pub values: Vec<DVec3>,
}

/// Runs a method on a trial; none if `stop` returned true.
pub fn run_method(
    trial: &Trial,
    method: &AtlasMethod,
    gpu: Option<&Gpu>,
    truth: &[DVec3],
    stop: &dyn Fn() -> bool,
) -> Option<TrialResult> {
    let start = Instant::now();
    let late = Cell::new(false);
    let progress = |_: &str, _| {
        late.set(late.get() || start.elapsed().as_secs_f64() > MAX_SOLVE_SECONDS);
        if late.get() || stop() {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    };
    let watch = ProgressMonitor::new(&progress);
    let solved = catch_panic(|| solve_trial(trial, method, gpu, &watch));
    let seconds = start.elapsed().as_secs_f64();
    if stop() {
        return None;
    }
    let mut side = SolverSide {
        error: None,
        noise: 0.0,
        bias: None,
        estimate: None,
        // `make_row` sets the verdict by the measure of the case.
        verdict: Verdict::Fails,
        warnings: Vec::new(),
        notes: Vec::new(),
        message: None,
        seconds,
    };
    let solved = match solved {
        _ if late.get() => Err(format!("took longer than {MAX_SOLVE_SECONDS} s")),
        other => other,
    };
    let answer = match solved {
        Err(message) => {
            side.message = Some(message);
            None
        }
        Ok(answer) => {
            side.warnings = answer.warnings.iter().map(|w| w.code.as_str().into()).collect();
            side.notes = answer.notes;
            side.estimate = answer.estimate.map(|estimate| estimate.error);
            let Solved { mesh, run, .. } = answer.solved;
            let values = ReflectedField::from_field(&trial.scene, &mesh, &run.field).values;
            match accuracy::error_and_noise(trial, &values, truth) {
                Ok((error, noise)) => {
                    side.error = Some(error);
                    side.noise = noise;
                    side.bias = accuracy::worst_bias(trial, &values, truth);
                }
                Err(message) => side.message = Some(format!("{NOT_COMPARABLE}: {message}")),
            }
            Some(TrialAnswer {
                mesh,
                field: run.field,
                values,
            })
        }
    };
    Some(TrialResult { side, answer })
}

/// Solves and returns a panic as an error, so that the atlas continues.
fn catch_panic(solve: impl FnOnce() -> Result<SolveAnswer>) -> std::result::Result<SolveAnswer, String> {
    match catch_unwind(AssertUnwindSafe(solve)) {
        Ok(result) => result.map_err(|error| error.to_string()),
        Err(payload) => Err(format!("panic: {}", panic_text(payload.as_ref()))),
    }
}

fn panic_text(payload: &(dyn Any + Send)) -> &str {
    let text = payload.downcast_ref::<String>().map(String::as_str);
    text.or_else(|| payload.downcast_ref::<&str>().copied())
        .unwrap_or("without a message")
}

fn solve_trial(trial: &Trial, method: &AtlasMethod, gpu: Option<&Gpu>, watch: &ProgressMonitor) -> Result<SolveAnswer> {
    let settings = method.settings_on(trial.texels, gpu.is_some());
    let question = |task, solver| SolveRequest {
        task,
        settings: &settings,
        solver,
    };
    let to = |error| {
        let texels = Some(trial.texels);
        SolverChoice::to_error(gpu, ErrorTarget { error, texels })
    };
    let name = method.name;
    match method.kind {
        MethodKind::Default => solve_request(&question(&trial.scene, to(DEFAULT_ERROR)), watch),
        MethodKind::Reference => solve_request(&question(&trial.scene, to(REFERENCE_ERROR)), watch),
        MethodKind::Matrix => solve_request(&question(&trial.scene, SolverChoice::Dense), watch),
        MethodKind::Shooting(_) => solve_request(&question(&trial.scene, SolverChoice::shooting_on(gpu)), watch),
        MethodKind::Relight(way, _) => {
            let stage = relight_stage(trial)?;
            let task = RelightTask {
                stage: &stage,
                method: way,
            };
            let solver = match name {
                DEFAULT_METHOD => to(DEFAULT_ERROR),
                _ => SolverChoice::shooting_on(gpu),
            };
            solve_request(&question(&task, solver), watch)
        }
    }
}

/// Returns the trial's room with its objects. Errors: the trial is no relight.
fn relight_stage(trial: &Trial) -> Result<RelightStage> {
    let MethodSuite::Relight(room) = trial.suite else {
        return Err(Error::Usage("there is no room to relight".into()));
    };
    Ok(RelightStage::new(&trial.scene, room, trial.texels))
}
