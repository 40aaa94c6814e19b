//! Forecasts a solve from a cheaper one of the same scene: to a larger error, or on a coarser mesh, for `--dry-run`.

use super::SceneCounts;
use super::coarser_defaults::MAX_KEPT_LINKS;
use common::Result;
use common::scene::Scene;
use common::settings::{Iteration, Settings, Visibility};
use oracle::solve::progress::{PhaseCallback, ProgressMonitor};
use oracle::solve::solver::{ErrorTarget, SolverChoice};
use oracle::solve::task::SolveTask;
use std::time::Instant;

/// Error of the cheaper solve. The time of a solve goes with the inverse of its error: five scenes of 17 to 10 133 faces
/// took 7 to 16 times as long for a tenth of the error.
const TRIAL_ERROR: f64 = 0.1;
/// Largest work of the cheaper solve by shooting, in pixels: about a second.
const MAX_TRIAL_WORK: f64 = 67e6;
/// Cost of a ray in pixels of an item buffer.
const PIXELS_PER_RAY: u64 = 16;

/// Forecast of a solve.
#[derive(Clone, Debug)]
pub struct Forecast {
    /// Shots; none for a solve to an error, or if the cheaper solve was stopped.
    pub shots: Option<f64>,
    /// The cheaper solve in words.
    pub trial: String,
    /// Seconds of the cheaper solve.
    pub trial_seconds: f64,
    /// Work of the solve over work of the cheaper one.
    pub work_ratio: f64,
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
    let mut cheaper = *settings;
    let (trial_solver, trial, mut work_ratio) = match solver.error_target() {
        Some(target) => {
            let error = TRIAL_ERROR;
            let coarse = SolverChoice::to_error(solver.gpu(), ErrorTarget { error, ..target });
            (coarse, format!("to {} %", 100.0 * error), error / target.error)
        }
        None => {
            cheaper = coarsen_for_trial(scene, settings);
            let [texels, patches] = [cheaper.meshing.texels, cheaper.meshing.patches];
            let trial = format!("of {texels}×{texels} texels and {patches}×{patches} patches a face");
            (solver, trial, count_work(scene, settings) / count_work(scene, &cheaper))
        }
    };
    let watch = ProgressMonitor::new(show);
    let start = Instant::now();
    let solved = scene.solve_once(&cheaper, trial_solver, &watch);
    let trial_seconds = start.elapsed().as_secs_f64();
    let mut shots = None;
    if !watch.is_stopped() {
        let patches = |settings: &Settings| SceneCounts::new(scene, &settings.meshing).patches as f64;
        let whole = solved?.run.shooters as f64 * patches(settings) / patches(&cheaper);
        if solver.is_shooting() {
            let most = whole.min(settings.schedule.max_shots.into());
            work_ratio *= most / whole.max(1.0);
            shots = Some(most);
        }
    }
    Ok(Forecast {
        shots,
        trial,
        trial_seconds,
        work_ratio,
        stopped: watch.is_stopped(),
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
