//! Adaptive solves to a requested error: the scene is solved hierarchically in steps, each to half the error
//! of the step before and on texels half as large where that matters, until two successive solutions differ
//! by less than the request. If no texels are requested, they are halved until the radiosity varies within each
//! by no more than a few times the error.
//!
//! The difference d of the last two solutions is the estimate of the finer one's error. It equals the error
//! of the coarser less that of the finer; where a step halves the error the two are equal. Where a step
//! reduces the error less, d is too small. So the first step is already solved to the requested error and the
//! result to half of it, and where differences fall more slowly than by halves, the remaining error is
//! extrapolated from their ratio (see [`ErrorHistory::remaining_error`]).

use super::adjacency::refine_neighbours;
use super::error_estimate::ErrorHistory;
use super::error_estimate::StepChange;
use super::interrupt::is_interrupted;
use super::progress::ProgressMonitor;
use super::resolution::{
    MAX_TEXELS_PER_SIDE, choose_first, choose_second, count_texels, first_texel_width, halve_largest, resample_face,
    square_resolutions,
};
use super::solved::Solved;
use super::solver::ErrorTarget;
use super::step::{SolveStep, narrow_to_f32, resample_step};
use common::cover::sample_covers;
use common::mesh::{MAX_TEXELS, Mesh};
use common::scene::Scene;
use common::settings::Settings;
use common::solution::{Warning, WarningCode};
use common::texel::first_texels;
use common::{Error, Result};
use cpu::hierarchy::linker::LinkMethod;
use cpu::hierarchy::shot_log;
use cpu::hierarchy::solver::{ErrorBudget, HierarchicalSolution, solve_with_links};
use glam::{DVec3, Vec3};
use std::ops::ControlFlow;

/// Largest variation within a texel, in multiples of the error, where texels follow from the light.
const MAX_VARIATION_PER_ERROR: f64 = 4.0;
/// Largest number of texels that follow from the light.
const MAX_RESULT_TEXELS: u64 = 1 << 17;
/// Sample points per face for the escaping share of its light.
pub const ESCAPE_POINTS: u32 = 16;
/// Largest number of steps.
const MAX_STEPS: u32 = 6;
/// Smallest goal of a step, as a share of the requested error. Remaining differences are then due to the
/// texels' size.
const MIN_GOAL_SHARE: f64 = 0.25;
/// Largest number of texels of a step; in a large scene twice the number of the step before.
const MAX_STEP_TEXELS: u64 = 1 << 20;
/// Share of the squared error that may come from faces whose texels are not halved.
const UNREFINED_SHARE: f64 = 0.25;

/// A scene to be solved in steps.
struct AdaptiveSolve<'a> {
    scene: &'a Scene,
    /// Requested texels per side of each face.
    requested_texels: Option<u32>,
    /// Method that finds links.
    method: LinkMethod<'a>,
    progress: &'a ProgressMonitor<'a>,
}

/// Solves `scene` with links found by `method`, until two successive solutions differ by less than the
/// error of `target`. After an interruption it returns the last complete step.
///
/// Errors: [`common::Error::Interrupted`] before the first step is done.
pub fn solve_adaptively(
    scene: &Scene,
    settings: &Settings,
    target: ErrorTarget,
    method: LinkMethod,
    progress: &ProgressMonitor,
) -> Result<Solved> {
    let problem = AdaptiveSolve {
        scene,
        requested_texels: target.texels,
        method,
        progress,
    };
    let (step, history) = refine_until_converged(&problem, target.error)?;
    let mut solved = resample_result(scene, settings, target, step, history)?;
    solved.run.field.origin = format!("hierarchy by {}", method.name());
    Ok(solved)
}

impl AdaptiveProblem for AdaptiveSolve<'_> {
    type StepResult = SolveStep;

    fn scene(&self) -> &Scene {
        self.scene
    }

    fn solve_step(&self, sides: Vec<u32>, goal: f64, last: Option<&SolveStep>) -> Result<SolveStep> {
        let mesh = self
            .progress
            .time_phase("prepare", || Mesh::new(self.scene, &square_resolutions(&sides), 1))?;
        let phase = format!("solving to {:.2} %", 100.0 * goal);
        let off = last.map_or(Vec::new(), |last| last.coarse_error(&self.scene.faces, &sides, goal));
        let goal = ErrorBudget::for_error(goal as f32);
        let mut callback = step_progress(self.progress, &phase);
        let outcome = self.progress.time_phase("solve", || {
            solve_with_links(self.scene, &mesh, &off, goal, self.method, &mut callback)
        })?;
        Ok(SolveStep::new(sides, mesh, outcome))
    }

    fn requested_texels(&self, _: usize) -> Option<u32> {
        self.requested_texels
    }

    fn result_resolution(&self, last: &SolveStep, change: &StepChange, error: f64) -> Option<Vec<u32>> {
        if self.requested_texels.is_some() {
            return None;
        }
        let filled = resolve_variation(self.scene, last, change, error);
        (filled != last.sides && count_texels(&filled) <= MAX_RESULT_TEXELS).then_some(filled)
    }
}

/// Replaces the warnings' advice by advice for a solve to an error.
pub fn adapt_advice(mut warnings: Vec<Warning>) -> Vec<Warning> {
    for warning in &mut warnings {
        let advice = match warning.code {
            WarningCode::Closure => ": use a lower --error",
            WarningCode::Texels => ": details near the named faces are smaller than their texels",
            WarningCode::Unshot => ": lower the reflectances",
            WarningCode::Unlit => ": use more --texels",
            _ => continue,
        };
        if let Some((said, _)) = warning.message.rsplit_once(": ") {
            warning.message = format!("{said}{advice}");
        }
    }
    warnings
}

/// Converts the last step to the requested texels.
fn resample_result(
    scene: &Scene,
    settings: &Settings,
    target: ErrorTarget,
    step: SolveStep,
    history: ErrorHistory,
) -> Result<Solved> {
    let to = |f: usize| target.texels.unwrap_or(step.sides[f]);
    let sides: Vec<u32> = (0..scene.faces.len()).map(to).collect();
    let mut mesh = Mesh::new(scene, &square_resolutions(&sides), 1)?;
    sample_covers(&mut mesh, ESCAPE_POINTS);
    // A mesh has its texels in face order because each face is one patch.
    let light = |values: &[Vec3]| narrow_to_f32(resample_step(&scene.faces, &step, &sides, &|k| values[k].as_dvec3()));
    let open = |k: usize| DVec3::splat(f64::from(step.outcome.open[k]));
    let open = narrow_to_f32(resample_step(&scene.faces, &step, &sides, &open));
    let mut irradiance = light(&step.outcome.irradiance);
    weight_by_reflectance(scene, &step, &mesh, &mut irradiance);
    let outcome = HierarchicalSolution {
        irradiance,
        residual: light(&step.outcome.residual),
        open: open.iter().map(|open| open.x).collect(),
        coarse_error: Vec::new(),
        links: step.outcome.links,
        passes: step.outcome.passes,
        converged: step.outcome.converged,
    };
    shot_log::set_open_shares(&mut mesh, &outcome);
    let run = shot_log::record_run(&mesh, &outcome);
    Ok(Solved {
        history: Some(history),
        ..Solved::new(settings, mesh, run)
    })
}

/// Weights H by ρ on requested texels within which ρ varies: then B = E + ρH, with the texel's mean ρ, is the
/// mean over the texel.
fn weight_by_reflectance(scene: &Scene, step: &SolveStep, mesh: &Mesh, irradiance: &mut [Vec3]) {
    let (mut from, mut to) = (0, 0);
    for (f, face) in scene.faces.iter().enumerate() {
        let (many, few) = (step.sides[f], mesh.faces[f].resolution[0]);
        let [first, next] = [from, to];
        from += (many as usize).pow(2);
        to += (few as usize).pow(2);
        if face.paint.is_none() || many <= few {
            continue;
        }
        let reflected = resample_face(&step.reflected[first..from], face, many, few);
        let texels = mesh.texels[next..to].iter();
        for ((h, texel), all) in irradiance[next..to].iter_mut().zip(texels).zip(reflected) {
            let rho = texel.reflectance;
            *h = Vec3::select(rho.cmpgt(Vec3::ZERO), all.as_vec3() / rho, *h);
        }
    }
}

/// Returns texels per side for which the light varies little within each texel. The squared variation within
/// a texel is taken as half of that within four texels that make up a larger one. At a shadow's edge this is
/// exact; for a linear slope it is too much.
fn resolve_variation(scene: &Scene, step: &SolveStep, change: &StepChange, error: f64) -> Vec<u32> {
    let first = first_texels(&square_resolutions(&step.sides));
    let order = step.mesh.texels_in_face_order();
    let mut within = Vec::with_capacity(scene.faces.len());
    for (f, face) in scene.faces.iter().enumerate() {
        let side = step.sides[f];
        let own = &step.reflected[first[f]..first[f + 1]];
        // On a painted face the irradiance counts, not the paint.
        let even: Vec<DVec3>;
        let own = match face.paint {
            Some(_) => {
                let rho = face.reflectance.as_dvec3();
                let texels = order[first[f]..first[f + 1]].iter();
                let light = texels.map(|k| rho * step.outcome.irradiance[*k].as_dvec3());
                even = light.collect();
                &even
            }
            None => own,
        };
        let mut sum = 0.0;
        if side.is_multiple_of(2) {
            let coarse = resample_face(own, face, side, side / 2);
            let coarse = resample_face(&coarse, face, side / 2, side);
            let off = |(a, b): (&DVec3, &DVec3)| (a - b)[change.channel].powi(2);
            sum = own.iter().zip(&coarse).map(off).sum();
        }
        within.push(0.5 * sum * change.scale * face.area() / f64::from(side).powi(2));
    }
    let unresolved = (MAX_VARIATION_PER_ERROR * error).powi(2);
    halve_largest(&step.sides, &within, unresolved, |_, side| side < MAX_TEXELS_PER_SIDE)
}

/// A problem that can be solved in steps of increasing resolution.
pub trait AdaptiveProblem {
    /// The result of a step.
    type StepResult: AsRef<SolveStep>;

    /// The scene with all faces.
    fn scene(&self) -> &Scene;

    /// Solves to `goal` on `sides` texels per side of each face; `last` is the step before.
    ///
    /// Errors: [`Error::Interrupted`].
    fn solve_step(&self, sides: Vec<u32>, goal: f64, last: Option<&SolveStep>) -> Result<Self::StepResult>;

    /// Requested texels per side of a face; `None`: they follow from the light.
    fn requested_texels(&self, face: usize) -> Option<u32>;

    /// Texels per side of a face that keeps its texels in all steps.
    fn fixed_texels(&self, _face: usize) -> Option<u32> {
        None
    }

    /// Least texels per side of each face in the second step, or nothing.
    fn least_resolution(&self, _first: &Self::StepResult) -> Vec<u32> {
        Vec::new()
    }

    /// Texels per side for the final result, if they differ from those of the last step.
    fn result_resolution(&self, _last: &Self::StepResult, _change: &StepChange, _error: f64) -> Option<Vec<u32>> {
        None
    }
}

/// Solves until two successive solutions differ by less than `error`. After an interruption it returns the
/// last complete step.
///
/// Errors: [`Error::Interrupted`] before the first step is done.
pub fn refine_until_converged<S: AdaptiveProblem>(problem: &S, error: f64) -> Result<(S::StepResult, ErrorHistory)> {
    let scene = problem.scene();
    let width = first_texel_width(scene)?;
    let requested = |f: usize| problem.requested_texels(f);
    let keep_fixed = |sides: &mut [u32]| {
        for (f, side) in sides.iter_mut().enumerate() {
            *side = problem.fixed_texels(f).unwrap_or(*side);
        }
    };
    let mut history = ErrorHistory::default();
    let mut goal = error;
    let mut sides = choose_first(scene, &requested, width);
    keep_fixed(&mut sides);
    let mut last = problem.solve_step(sides, goal, None)?;
    sides = choose_second(scene, &requested, width, &last.as_ref().sides);
    keep_fixed(&mut sides);
    for (side, least) in sides.iter_mut().zip(problem.least_resolution(&last)) {
        *side = (*side).max(least);
    }
    let may_refine = |f: usize| problem.fixed_texels(f).is_none();
    for k in 1..MAX_STEPS {
        let texels_now = count_texels(&sides);
        let limit = MAX_STEP_TEXELS.max(2 * last.as_ref().mesh.texels.len() as u64);
        if k > 1 && texels_now > limit.min(MAX_TEXELS) {
            history.stop_reason = Some(format!("{texels_now} texels would be too many"));
            break;
        }
        goal = (0.5 * goal).max(MIN_GOAL_SHARE * error);
        let next = match problem.solve_step(sides.clone(), goal, Some(last.as_ref())) {
            Err(Error::Interrupted) => {
                history.stop_reason = Some("it was interrupted".into());
                break;
            }
            next => next?,
        };
        let change = StepChange::new(scene, last.as_ref(), next.as_ref(), &requested);
        last = next;
        history.changes.push(change.total);
        let converged = history.remaining_error().is_some_and(|remaining| remaining <= error);
        let unrefined = UNREFINED_SHARE * error * error;
        let before = &last.as_ref().sides;
        sides = halve_largest(before, &change.by_face, unrefined, |f, _| may_refine(f));
        refine_neighbours(&scene.faces, before, &mut sides, may_refine);
        if converged && let Some(shown) = problem.result_resolution(&last, &change, error) {
            last = problem.solve_step(shown, goal, Some(last.as_ref()))?;
        }
        history.last_change = Some(change);
        if converged {
            break;
        }
    }
    history.links = last.as_ref().outcome.links;
    Ok((last, history))
}

/// Returns a callback that reports a step's progress and breaks on an interruption.
pub fn step_progress<'a>(progress: &'a ProgressMonitor, phase: &'a str) -> impl FnMut(f64) -> ControlFlow<()> + 'a {
    move |done| {
        if is_interrupted() {
            progress.stop();
            return ControlFlow::Break(());
        }
        progress.report_share(phase, done)
    }
}
