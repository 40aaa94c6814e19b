//! Forecasts the other steps of a solve by links from its first two.
//!
//! The second step is often the last. Otherwise the texels of the third are known, and later ones grow as much, while the
//! change falls by half. If no texels are requested, light is gathered on those that it needs in the end; where the second step
//! is accurate enough, the first of these steps is made, too. Work grows less than texels and links do: most texels are
//! interpolated, and links to nodes are shared by their parts.

use super::adaptive::{AdaptiveSolve, brightest_channel};
use super::interpolation_error::{ReceivedLight, interpolation_errors, reduce_interpolation_error};
use super::refinement::{AdaptiveProblem, RefinementSteps, most_texels, next_goal};
use super::resolution::{TexelError, count_texels};
use super::step::SolveStep;

/// Powers of the number of texels, and of one over the error, with which the work of a step by links grows.
const WORK_EXPONENTS: [f64; 2] = [0.65, 0.5];
/// Work of a step that only gathers light, over that of a solve.
const GATHER_WORK: f64 = 0.7;
/// Number of steps that only gather light, of which the texels are foretold.
const FORETOLD_GATHERS: u32 = 2;

/// The last step of a solve, as its first two foretell it.
pub(super) struct StepForecast {
    /// Texels and kept rays of the last step.
    pub kept: [u64; 2],
    /// Work of the whole solve over that of the steps that are made.
    pub work_ratio: f64,
}

/// Forecasts the steps by links after the second, or after the first that only gathers light.
pub(super) fn forecast_by_links(steps: &RefinementSteps<AdaptiveSolve>) -> StepForecast {
    let (problem, error, step) = (steps.problem, steps.error, &steps.last);
    let [mut last_goal, mut goal] = steps.goals;
    let mut texels = step.mesh.texels.len() as u64;
    let solved = steps.counts.iter().zip(steps.goals);
    let mut done: f64 = solved.map(|(count, goal)| step_work(*count, goal)).sum();
    let mut gathers = FORETOLD_GATHERS;
    if steps.counts.last() != Some(&texels) {
        done += GATHER_WORK * step_work(texels, (goal * last_goal).sqrt());
        gathers -= 1;
    }
    let mut work = done;
    let mut history = steps.history.copy_changes();
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
    let light = ReceivedLight::without_noise(step.outcome.irradiance.clone());
    for gathered in foretell_gathers(problem, error, (step, &light), (last, further, gathers)) {
        texels = (count_texels(&gathered) as f64 * further) as u64;
        work += GATHER_WORK * step_work(texels, (goal * last_goal).sqrt());
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

/// Returns the texels of each face in each of at most `most` steps that only gather light, after one on `further` times the
/// `last` texels, over that factor. They follow from the `light` of a `known` step.
pub(super) fn foretell_gathers(
    problem: &AdaptiveSolve,
    error: f64,
    (known, light): (&SolveStep, &ReceivedLight),
    (last, further, most): (&[[u32; 2]], f64, u32),
) -> Vec<Vec<[u32; 2]>> {
    let faces = &problem.scene().faces;
    let (by_channel, channel) = brightest_channel(problem.scene(), known);
    let all: f64 = by_channel.iter().sum();
    if problem.requested_texels(0).is_some() || all <= 0.0 {
        return Vec::new();
    }
    let scale = (channel, 1.0 / all);
    let errors = interpolation_errors(problem.scene(), known, light, scale);
    let mut texels = last.to_vec();
    let mut gathers = Vec::new();
    for _ in 0..most {
        let foretell = |((own, before), after): ((&TexelError, &[u32; 2]), &[u32; 2])| {
            let [before, after] = [before, after].map(|texels| count_texels(&[*texels]) as f64);
            TexelError {
                square: own.square * own.ratio.powf((further * after / before).log(4.0)),
                ..*own
            }
        };
        let of_faces = errors.iter().zip(&known.resolutions).zip(&texels);
        let foretold: Vec<TexelError> = of_faces.map(foretell).collect();
        let finer = reduce_interpolation_error(faces, &texels, &foretold, error);
        if finer == texels {
            break;
        }
        gathers.push(finer.clone());
        texels = finer;
    }
    gathers
}
