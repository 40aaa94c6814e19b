//! Forecasts the other steps of a solve by links from its first two.
//!
//! The second step is often the last. Otherwise the texels of the third are known, and later ones grow as much, while the
//! change falls by half. If no texels are requested, another step follows on those that light needs. Work grows less than
//! texels and links do: most texels are interpolated, and links to nodes are shared by their parts.

use super::adaptive::{AdaptiveSolve, brightest_channel};
use super::interpolation_error::{interpolation_errors, reduce_interpolation_error};
use super::refinement::{AdaptiveProblem, RefinementSteps, most_texels, next_goal};
use super::resolution::count_texels;
use super::step::SolveStep;

/// Powers of the number of texels, and of one over the error, with which the work of a step by links grows.
const WORK_EXPONENTS: [f64; 2] = [0.65, 0.5];

/// The last step of a solve, as its first two foretell it.
pub(super) struct StepForecast {
    /// Texels and kept rays of the last step.
    pub kept: [u64; 2],
    /// Work of the whole solve over that of the first two steps.
    pub work_ratio: f64,
}

/// Forecasts the steps by links after the second.
pub(super) fn forecast_by_links(steps: &RefinementSteps<AdaptiveSolve>) -> StepForecast {
    let (problem, error, step) = (steps.problem, steps.error, &steps.last);
    let [mut last_goal, mut goal] = steps.goals;
    let [before, mut texels] = [steps.texels_before, step.mesh.texels.len() as u64];
    let done = step_work(before, last_goal) + step_work(texels, goal);
    let mut work = done;
    let mut history = steps.history.foretell();
    let last = match steps.meets_target() {
        true => &step.resolutions,
        false => &steps.texels,
    };
    let growth = count_texels(last) as f64 / texels as f64;
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
    let further = texels as f64 / count_texels(last) as f64;
    if let Some(result) = count_result_texels(problem, error, step, (last, further)) {
        texels = (result as f64 * further) as u64;
        work += step_work(texels, (goal * last_goal).sqrt());
    }
    StepForecast {
        kept: [texels, 0],
        work_ratio: work / done,
    }
}

/// Returns the work of a step by links on so many texels to `goal`, in a unit of its own.
fn step_work(texels: u64, goal: f64) -> f64 {
    let [by_texels, by_goal] = WORK_EXPONENTS;
    (texels as f64).powf(by_texels) * goal.recip().powf(by_goal)
}

/// Returns the texels of a step on those that light needs, after one on `further` times the `last` texels, over that factor; none
/// if there is no such step. It follows from the light of a `known` step.
fn count_result_texels(
    problem: &AdaptiveSolve,
    error: f64,
    known: &SolveStep,
    (last, further): (&[[u32; 2]], f64),
) -> Option<u64> {
    let scene = problem.scene();
    let (light, channel) = brightest_channel(scene, known);
    let all: f64 = light.iter().sum();
    if problem.requested_texels(0).is_some() || all <= 0.0 {
        return None;
    }
    let mut errors = interpolation_errors(scene, known, (channel, 1.0 / all));
    for (own, texels) in errors.iter_mut().zip(known.resolutions.iter().zip(last)) {
        let [before, after] = [texels.0, texels.1].map(|texels| count_texels(&[*texels]) as f64);
        own.square *= own.ratio.powf((further * after / before).log(4.0));
    }
    let finer = reduce_interpolation_error(&scene.faces, last, &errors, error);
    (finer != last).then(|| count_texels(&finer))
}
