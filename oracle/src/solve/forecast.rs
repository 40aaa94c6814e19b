//! Forecasts a solve to an error from its first step, or by rays from its first two, which are solved.
//!
//! - By rays: the second step tells the texels of the last one (see `ray_steps`). The noise variance of n rays falls as
//!   n^-1.25 whatever the texels are, so that a texel's rays grow by the noise's ratio to the power 1.6.
//! - By links: the second step, as a rule the last, is solved to half the error on texels that the first step chooses. If
//!   no texels are requested, another step follows on those that light needs. Work grows less than texels and links do: most
//!   texels are interpolated, and links to nodes are shared by their parts.

use super::adaptive::{AdaptiveSolve, brightest_channel, solve_first_step};
use super::error_estimate::ErrorHistory;
use super::gpu_linker::LinkerOnGpu;
use super::interpolation_error::{interpolation_errors, reduce_interpolation_error};
use super::progress::ProgressMonitor;
use super::ray_steps::{RayForecast, forecast_by_rays};
use super::resolution::count_texels;
use super::solve_to_error::resample_result;
use super::solved::Solved;
use super::solver::{ErrorTarget, SolverChoice};
use super::step::SolveStep;
use common::Result;
use common::scene::Scene;
use common::settings::Settings;
use cpu::hierarchy::linker::LinkMethod;
use std::f64::consts::FRAC_1_SQRT_2;

/// Power of the number of texels over the error with which the work of a step by links grows on rooms of few faces.
const WORK_EXPONENT: f64 = 2.0 / 3.0;
/// Errors of the second step and of that on texels that light needs, over the requested one.
const LATER_GOALS: [f64; 2] = [0.5, FRAC_1_SQRT_2];

/// The first step of a solve, and what the whole takes.
pub struct FirstStep {
    /// The result of the steps that were solved.
    pub solved: Solved,
    /// Texels of the last step.
    pub texels: u64,
    /// Rays that it keeps; 0 by links.
    pub rays: u64,
    /// Work of the whole solve over that of the first step.
    pub work_ratio: f64,
}

/// Solves the first step of a solve of `scene` by `solver`, and forecasts the rest; none for a solver without an error.
///
/// Errors: those of the solver; [`common::Error::Interrupted`].
pub fn solve_first(
    scene: &Scene,
    settings: &Settings,
    solver: SolverChoice,
    progress: &ProgressMonitor,
) -> Result<Option<FirstStep>> {
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
) -> Result<FirstStep> {
    let problem = AdaptiveSolve::new(scene, target, method, progress);
    let (step, [texels, rays], work_ratio) = if problem.follows_rays() {
        let RayForecast { step, kept, work_ratio } = forecast_by_rays(&problem, target.error)?;
        (step, kept, work_ratio)
    } else {
        let (first, second) = solve_first_step(&problem, target.error)?;
        let last = count_result_texels(scene, target, &first, &second);
        let later = [Some(count_texels(&second)), last];
        let texels = last.unwrap_or(count_texels(&second));
        let before = step_work(first.mesh.texels.len() as u64, 1.0);
        let steps = later.into_iter().zip(LATER_GOALS);
        let after: f64 = steps.filter_map(|(texels, goal)| Some(step_work(texels?, goal))).sum();
        (first, [texels, 0], 1.0 + after / before)
    };
    Ok(FirstStep {
        solved: resample_result(scene, settings, target, step, ErrorHistory::default())?,
        texels,
        rays,
        work_ratio,
    })
}

/// Returns the work of a step on so many texels to `goal`, in a unit of its own.
fn step_work(texels: u64, goal: f64) -> f64 {
    (texels as f64 / goal).powf(WORK_EXPONENT)
}

/// Returns the texels of a step on those that light needs, after one on the `second` texels; none if there is no such step.
fn count_result_texels(scene: &Scene, target: ErrorTarget, first: &SolveStep, second: &[[u32; 2]]) -> Option<u64> {
    let (light, channel) = brightest_channel(scene, first);
    let all: f64 = light.iter().sum();
    if target.texels.is_some() || all <= 0.0 {
        return None;
    }
    let mut errors = interpolation_errors(scene, first, (channel, 1.0 / all));
    for (own, texels) in errors.iter_mut().zip(first.resolutions.iter().zip(second)) {
        let [before, after] = [texels.0, texels.1].map(|texels| count_texels(&[*texels]) as f64);
        own.square *= own.ratio.powf((after / before).log(4.0));
    }
    let finer = reduce_interpolation_error(&scene.faces, second, &errors, target.error);
    (finer != second).then(|| count_texels(&finer))
}
