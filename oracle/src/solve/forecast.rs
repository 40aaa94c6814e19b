//! Forecasts a solve to an error from its first steps, which are solved.

use super::adaptive::AdaptiveSolve;
use super::error_estimate::ErrorHistory;
use super::gpu_linker::LinkerOnGpu;
use super::progress::ProgressMonitor;
use super::ray_steps::forecast_by_rays;
use super::refinement::RefinementSteps;
use super::solve_to_error::resample_result;
use super::solved::Solved;
use super::solver::{ErrorTarget, SolverChoice};
use super::step_forecast::forecast_by_links;
use common::Result;
use common::scene::Scene;
use common::settings::Settings;
use cpu::hierarchy::linker::LinkMethod;

/// The first steps of a solve, and what the whole takes.
pub struct FirstSteps {
    /// The result of the steps that were solved.
    pub solved: Solved,
    /// Texels of the last step.
    pub texels: u64,
    /// Rays that it keeps; 0 by links.
    pub rays: u64,
    /// Work of the whole solve over that of the steps that are made.
    pub work_ratio: f64,
}

/// Makes the first steps of a solve of `scene` by `solver`, and forecasts the rest; none for a solver without an error.
///
/// Errors: those of the solver; [`common::Error::Interrupted`].
pub fn solve_first(
    scene: &Scene,
    settings: &Settings,
    solver: SolverChoice,
    progress: &ProgressMonitor,
) -> Result<Option<FirstSteps>> {
    match solver {
        SolverChoice::Hierarchy(target) => {
            forecast_solve(scene, settings, target, LinkMethod::Shafts, progress).map(Some)
        }
        SolverChoice::GpuHierarchy(gpu, target) => {
            let maker = LinkerOnGpu::factory_on(gpu, &[]);
            forecast_solve(scene, settings, target, LinkMethod::Custom(&maker), progress).map(Some)
        }
        _ => Ok(None),
    }
}

fn forecast_solve(
    scene: &Scene,
    settings: &Settings,
    target: ErrorTarget,
    method: LinkMethod,
    progress: &ProgressMonitor,
) -> Result<FirstSteps> {
    let problem = AdaptiveSolve::new(scene, target, method, progress);
    let (step, forecast) = match problem.follows_rays() {
        true => forecast_by_rays(&problem, target.error)?,
        false => {
            let mut steps = RefinementSteps::solve_first(&problem, target.error)?;
            steps.solve_next()?;
            let steps = steps.resolve_light(1)?;
            let forecast = forecast_by_links(&steps);
            (steps.last, forecast)
        }
    };
    let [texels, rays] = forecast.kept;
    Ok(FirstSteps {
        solved: resample_result(scene, settings, target, step, ErrorHistory::default())?,
        texels,
        rays,
        work_ratio: forecast.work_ratio,
    })
}
