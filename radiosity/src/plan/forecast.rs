//! Forecasts a solve from a cheaper one of the same scene: to a larger error, or on a coarser mesh, for `--dry-run`.

use super::SceneCounts;
use super::coarser_defaults::MAX_KEPT_LINKS;
use crate::report::solution_view::RenderedView;
use common::scene::Scene;
use common::settings::{Iteration, Settings, Visibility};
use common::solution::PhaseSeconds;
use common::{Error, Result};
use oracle::solve::forecast::{FirstSteps, solve_first};
use oracle::solve::progress::{PhaseCallback, ProgressMonitor};
use oracle::solve::solver::SolverChoice;
use oracle::solve::task::SolveTask;
use oracle::solve::{SolveAnswer, SolveRequest};
use std::cell::Cell;
use std::time::Instant;

/// Largest work of the cheaper solve by shooting, in pixels: about a second.
const MAX_TRIAL_WORK: f64 = 67e6;
/// Cost of a ray in pixels of an item buffer.
const PIXELS_PER_RAY: u64 = 16;

/// Forecast of a solve.
#[derive(Clone, Debug)]
pub struct Forecast {
    /// Shots; none for a solve to an error, or if the cheaper solve was stopped.
    pub shots: Option<f64>,
    /// Texels and rays that are kept at a time, of a solve to an error.
    pub kept: Option<[u64; 2]>,
    /// The cheaper solve in words.
    pub trial: String,
    /// Seconds of the cheaper solve.
    pub trial_seconds: f64,
    /// Work of the solve over work of the cheaper one.
    pub work_ratio: f64,
    /// Seconds of the solve; the least if the cheaper one was stopped.
    pub seconds: f64,
    /// True if the cheaper solve was stopped: then the solve takes longer.
    pub stopped: bool,
}

/// Forecasts a solve of `scene`; `show` may stop the cheaper solve.
///
/// Errors: those of the cheaper solve.
pub fn forecast_solve(
    scene: &Scene,
    settings: &Settings,
    solver: SolverChoice,
    show: PhaseCallback,
) -> Result<Forecast> {
    if solver.error_target().is_some() {
        return forecast_from_first_steps(scene, settings, solver, show);
    }
    let cheaper = coarsen_for_trial(scene, settings);
    let [texels, patches] = [cheaper.meshing.texels, cheaper.meshing.patches];
    let mut work_ratio = count_work(scene, settings) / count_work(scene, &cheaper);
    let watch = ProgressMonitor::new(show);
    let start = Instant::now();
    let solved = scene.solve_once(&cheaper, solver, &watch);
    let trial_seconds = start.elapsed().as_secs_f64();
    let mut shots = None;
    if !watch.is_stopped() {
        let patches = |settings: &Settings| SceneCounts::new(scene, &settings.meshing).patches as f64;
        let whole = solved?.run.shooters as f64 * patches(settings) / patches(&cheaper);
        let most = whole.min(settings.schedule.max_shots.into());
        work_ratio *= most / whole.max(1.0);
        shots = Some(most);
    }
    Ok(Forecast {
        shots,
        kept: None,
        trial: format!("a solve of {texels}×{texels} texels and {patches}×{patches} patches a face"),
        trial_seconds,
        work_ratio,
        seconds: trial_seconds * work_ratio,
        stopped: watch.is_stopped(),
    })
}

/// Forecasts a solve to an error from its first steps, of which it also makes the views.
fn forecast_from_first_steps(
    scene: &Scene,
    settings: &Settings,
    solver: SolverChoice,
    show: PhaseCallback,
) -> Result<Forecast> {
    let start = Instant::now();
    // When the solving was first and last reported: before and between is what each step prepares.
    let reported: Cell<[Option<f64>; 2]> = Cell::default();
    let timed = |phase: &str, done: f64| {
        let now = Some(start.elapsed().as_secs_f64());
        reported.set([reported.get()[0].or(now), now]);
        show(phase, done)
    };
    let watch = ProgressMonitor::new(&timed);
    let mut forecast = Forecast {
        shots: None,
        kept: None,
        trial: "its first steps".into(),
        trial_seconds: 0.0,
        work_ratio: 1.0,
        seconds: 0.0,
        stopped: false,
    };
    let first = solve_first(scene, settings, solver, &watch);
    forecast.trial_seconds = start.elapsed().as_secs_f64();
    forecast.seconds = forecast.trial_seconds;
    let first = match first {
        Err(Error::Interrupted) => None,
        first => first?,
    };
    let Some(FirstSteps {
        solved,
        texels,
        rays,
        work_ratio,
    }) = first
    else {
        return Ok(Forecast {
            stopped: true,
            ..forecast
        });
    };
    let request = SolveRequest {
        task: scene,
        settings,
        solver,
    };
    let answer = SolveAnswer {
        solved,
        warnings: Vec::new(),
        estimate: None,
        notes: Vec::new(),
    };
    RenderedView::new(&answer.to_solution(&request, &[], PhaseSeconds::default()), None)?;
    let [prepared, done] = reported.get().map(Option::unwrap_or_default);
    Ok(Forecast {
        kept: Some([texels, rays]),
        seconds: start.elapsed().as_secs_f64() + prepared + (work_ratio - 1.0) * (done - prepared),
        work_ratio,
        ..forecast
    })
}

/// Halves texels and patches until the work is small enough.
fn coarsen_for_trial(scene: &Scene, settings: &Settings) -> Settings {
    let mut trial = *settings;
    // An engine that cannot keep the links shoots one patch after the other.
    if SceneCounts::new(scene, &settings.meshing).link_count() > MAX_KEPT_LINKS {
        trial.schedule.iteration = Iteration::Southwell;
    }
    while count_work(scene, &trial) > MAX_TRIAL_WORK && trial.meshing.texels.max(trial.meshing.patches) > 1 {
        trial.meshing.texels = (trial.meshing.texels / 2).max(1);
        trial.meshing.patches = (trial.meshing.patches / 2).max(1);
    }
    trial
}

/// Returns the work of all patches that shoot once, in pixels.
fn count_work(scene: &Scene, settings: &Settings) -> f64 {
    let counts = SceneCounts::new(scene, &settings.meshing);
    let pixels = match settings.transport.visibility {
        Visibility::Rays => PIXELS_PER_RAY * counts.texels,
        Visibility::ItemBuffer(drawing) => counts.texels + drawing.pixel_count(),
    };
    (counts.patches * counts.samples) as f64 * pixels as f64
}
