//! Forecasts a solve to an error from its first two steps, which are solved.
//!
//! - By rays: the second step tells the texels of the last one (see `ray_steps`). The noise variance of n rays falls as
//!   n^-1.25 whatever the texels are, so that a texel's rays grow by the noise's ratio to the power 1.6.
//! - By links: the second step is often the last. Otherwise the texels of the third are known, and later ones grow as
//!   much, while the change falls by half. If no texels are requested, another step follows on those that light needs. Work
//!   grows less than texels and links do: most texels are interpolated, and links to nodes are shared by their parts.

use super::adaptive::{
    AdaptiveProblem, AdaptiveSolve, LastStep, brightest_channel, choose_next, most_texels, next_goal, solve_first_step,
};
use super::error_estimate::{ErrorHistory, StepChange};
use super::gpu_linker::LinkerOnGpu;
use super::interpolation_error::{interpolation_errors, reduce_interpolation_error};
use super::progress::ProgressMonitor;
use super::ray_steps::forecast_by_rays;
use super::resolution::count_texels;
use super::solve_to_error::resample_result;
use super::solved::Solved;
use super::solver::{ErrorTarget, SolverChoice};
use super::step::SolveStep;
use common::Result;
use common::scene::Scene;
use common::settings::Settings;
use cpu::hierarchy::linker::LinkMethod;

/// Powers of the number of texels, and of one over the error, with which the work of a step by links grows.
const WORK_EXPONENTS: [f64; 2] = [0.65, 0.5];

/// The first steps of a solve, and what the whole takes.
pub struct FirstSteps {
    /// The result of the steps that were solved.
    pub solved: Solved,
    /// Texels of the last step.
    pub texels: u64,
    /// Rays that it keeps; 0 by links.
    pub rays: u64,
    /// Work of the whole solve over that of the first two steps.
    pub work_ratio: f64,
}

/// Solves the first two steps of a solve of `scene` by `solver`, and forecasts the rest; none for a solver without an error.
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
    let LastStep {
        step,
        kept: [texels, rays],
        work_ratio,
    } = match problem.follows_rays() {
        true => forecast_by_rays(&problem, target.error)?,
        false => forecast_by_links(&problem, target)?,
    };
    Ok(FirstSteps {
        solved: resample_result(scene, settings, target, step, ErrorHistory::default())?,
        texels,
        rays,
        work_ratio,
    })
}

/// Solves the first two steps by links, and forecasts the rest.
///
/// Errors: those of the solver.
fn forecast_by_links(problem: &AdaptiveSolve, target: ErrorTarget) -> Result<LastStep> {
    let (scene, error) = (problem.scene(), target.error);
    let requested = |f: usize| problem.requested_texels(f);
    let (first, texels) = solve_first_step(problem, error)?;
    let mut goal = next_goal(error, error);
    let step = problem.solve_step(texels, goal, Some(&first))?;
    let change = StepChange::compare_steps(scene, &first, &step, &requested);
    let [before, mut texels] = [&first, &step].map(|step| step.mesh.texels.len() as u64);
    let known = step_work(before, error) + step_work(texels, goal);
    let mut history = ErrorHistory {
        changes: vec![change.total],
        ..ErrorHistory::default()
    };
    let mut work = known;
    let mut last = step.resolutions.clone();
    let mut last_goal = error;
    if !history.meets_target(error) {
        last = choose_next(problem, &step, &change, error);
    }
    let growth = count_texels(&last) as f64 / texels as f64;
    while !history.meets_target(error) && history.steps() < problem.max_steps() {
        let more = (growth * texels as f64) as u64;
        if more > most_texels(texels) {
            break;
        }
        (texels, last_goal, goal) = (more, goal, next_goal(goal, error));
        work += step_work(texels, goal);
        history
            .changes
            .extend(history.changes.last().map(|change| change / 2.0));
    }
    // Texels of the last step over those of the last one of which each face's are known.
    let further = texels as f64 / count_texels(&last) as f64;
    if let Some(result) = count_result_texels(scene, target, &step, (&last, further)) {
        texels = (result as f64 * further) as u64;
        work += step_work(texels, (goal * last_goal).sqrt());
    }
    Ok(LastStep {
        step,
        kept: [texels, 0],
        work_ratio: work / known,
    })
}

/// Returns the work of a step on so many texels to `goal`, in a unit of its own.
fn step_work(texels: u64, goal: f64) -> f64 {
    let [by_texels, by_goal] = WORK_EXPONENTS;
    (texels as f64).powf(by_texels) * goal.recip().powf(by_goal)
}

/// Returns the texels of a step on those that light needs, after one on `further` times the `last` texels, over that factor; none
/// if there is no such step. It follows from the light of a `known` step.
fn count_result_texels(
    scene: &Scene,
    target: ErrorTarget,
    known: &SolveStep,
    (last, further): (&[[u32; 2]], f64),
) -> Option<u64> {
    let (light, channel) = brightest_channel(scene, known);
    let all: f64 = light.iter().sum();
    if target.texels.is_some() || all <= 0.0 {
        return None;
    }
    let mut errors = interpolation_errors(scene, known, (channel, 1.0 / all));
    for (own, texels) in errors.iter_mut().zip(known.resolutions.iter().zip(last)) {
        let [before, after] = [texels.0, texels.1].map(|texels| count_texels(&[*texels]) as f64);
        own.square *= own.ratio.powf((further * after / before).log(4.0));
    }
    let finer = reduce_interpolation_error(&scene.faces, last, &errors, target.error);
    (finer != last).then(|| count_texels(&finer))
}
