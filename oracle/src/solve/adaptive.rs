//! Adaptive solves to a requested error: the scene is solved hierarchically in steps, each to half the error
//! of the step before and on texels half as large where that matters, until two successive solutions differ
//! by less than the request. If no texels are requested, they are halved where interpolation between
//! them errs most, until it errs by about the request.
//!
//! By rays the steps are others: see `ray_steps`.
//!
//! The difference d of the last two solutions is the estimate of the finer one's error. It equals the error
//! of the coarser less that of the finer; where a step halves the error the two are equal. Where a step
//! reduces the error less, d is too small. So the first step is already solved to the requested error and the
//! result to half of it, and where differences fall more slowly than by halves, the remaining error is
//! extrapolated from their ratio (see [`ErrorHistory::remaining_error`]).

use super::adjacency::refine_neighbours;
use super::error_estimate::ErrorHistory;
use super::error_estimate::StepChange;
use super::interpolation_error::{interpolation_errors, reduce_interpolation_error};
use super::interrupt::is_interrupted;
use super::progress::ProgressMonitor;
use super::regather::estimate::descending_order;
use super::resolution::{RequestedTexels, choose_first, choose_second, count_texels, first_texel_width, halve_largest};
use super::solver::ErrorTarget;
use super::step::SolveStep;
use common::mesh::{MAX_TEXELS, Mesh};
use common::scene::{Face, Scene};
use common::solution::{Warning, WarningCode};
use common::texel::first_texels;
use common::{Error, Result};
use cpu::hierarchy::linker::LinkMethod;
use cpu::hierarchy::sky::receive_sky;
use cpu::hierarchy::solver::{ErrorBudget, solve_with_links};
use glam::{DVec3, Vec3};
use std::ops::ControlFlow;

/// Largest number of steps.
const MAX_STEPS: u32 = 6;
/// Smallest goal of a step, as a share of the requested error. Remaining differences are then due to the
/// texels' size.
const MIN_GOAL_SHARE: f64 = 0.25;
/// Largest number of texels of a step; in a large scene twice the number of the step before.
const MAX_STEP_TEXELS: u64 = 1 << 20;
/// Number of faces from which on a scene is solved by rays.
const MIN_RAY_FACES: f64 = 200.0;
/// The same number times the requested error: links grow with its inverse, rays faster.
const RAY_FACES_PER_INVERSE_ERROR: f64 = 2.0;
/// Least texels per side of a lamp in the second step by links: its parts are sources where it is half hidden. One texel
/// has at most 64 samples of visibility.
const MIN_LAMP_TEXELS: u32 = 8;
/// Largest number of texels of all lamps for which each has [`MIN_LAMP_TEXELS`].
const MAX_LAMP_TEXELS: u64 = 1 << 14;
/// Number of texels up to which the second step of many small faces halves them.
const MAX_HALVED_TEXELS: u64 = 1 << 16;
/// Share of the squared error that may come from faces whose texels are not halved.
const UNREFINED_SHARE: f64 = 0.25;

/// A scene to be solved in steps.
pub(super) struct AdaptiveSolve<'a> {
    scene: &'a Scene,
    /// Requested texels per side of each face.
    requested_texels: Option<u32>,
    /// Requested error.
    error: f64,
    /// Method that finds links.
    pub(super) method: LinkMethod<'a>,
    /// Largest number of steps.
    max_steps: u32,
    pub(super) progress: &'a ProgressMonitor<'a>,
    observer: Option<StepObserver<'a>>,
}

/// Is called with each step by links and the error to which it was solved.
pub type StepObserver<'a> = &'a dyn Fn(&SolveStep, f64);

impl<'a> AdaptiveSolve<'a> {
    /// Makes the solve of `scene` to `target`.
    pub(super) fn new(
        scene: &'a Scene,
        target: ErrorTarget,
        method: LinkMethod<'a>,
        progress: &'a ProgressMonitor<'a>,
    ) -> Self {
        Self {
            scene,
            requested_texels: target.texels,
            error: target.error,
            method,
            max_steps: MAX_STEPS,
            progress,
            observer: None,
        }
    }

    /// Returns the solve with an `observer` of its steps.
    pub(super) fn with_observer(self, observer: StepObserver<'a>) -> Self {
        Self {
            observer: Some(observer),
            ..self
        }
    }

    /// Returns the solve in at most `max_steps` steps.
    pub(super) fn with_max_steps(self, max_steps: u32) -> Self {
        let max_steps = max_steps.min(MAX_STEPS);
        Self { max_steps, ..self }
    }

    /// Returns whether bounces are traced by rays.
    pub(super) fn follows_rays(&self) -> bool {
        follows_rays(self.scene, self.error, self.method)
    }
}

/// Returns whether light is traced by rays: many small faces would need many links.
pub fn follows_rays(scene: &Scene, error: f64, method: LinkMethod) -> bool {
    let enough = (RAY_FACES_PER_INVERSE_ERROR / error).max(MIN_RAY_FACES);
    matches!(method, LinkMethod::Shafts) && scene.faces.len() as f64 >= enough
}

/// Returns the noise of rays on texels of these `resolutions` that is `noise` on the requested texels: a mean over
/// them reduces it.
pub fn noise_on_texels(scene: &Scene, noise: f64, requested: RequestedTexels, resolutions: &[[u32; 2]]) -> f64 {
    let (mut area, mut averaged) = (0.0, 0.0);
    for (f, (face, own)) in scene.faces.iter().zip(resolutions).enumerate() {
        let count = count_texels(&[*own]) as f64;
        let together = requested(f).map_or(1.0, |shown| count / count_texels(&[shown]) as f64);
        area += face.area();
        averaged += face.area() / together.max(1.0);
    }
    let width: f64 = if averaged > 0.0 { area / averaged } else { 1.0 };
    noise * width.sqrt()
}

impl AdaptiveProblem for AdaptiveSolve<'_> {
    type StepResult = SolveStep;

    fn scene(&self) -> &Scene {
        self.scene
    }

    fn max_steps(&self) -> u32 {
        self.max_steps
    }

    fn solve_step(&self, texels: Vec<[u32; 2]>, goal: f64, last: Option<&SolveStep>) -> Result<SolveStep> {
        let mut mesh = self
            .progress
            .time_phase("prepare", || Mesh::new(self.scene, &texels, 1))?;
        let phase = format!("solving to {:.2} %", 100.0 * goal);
        let off = last.map_or(Vec::new(), |last| last.coarse_error(&self.scene.faces, &texels, goal));
        let budget = ErrorBudget::for_error(goal as f32);
        let mut callback = step_progress(self.progress, &phase);
        let outcome = self.progress.time_phase("solve", || {
            let mut outside = step_progress(self.progress, "light from outside");
            receive_sky(self.scene, &mut mesh, goal as f32, &mut outside)?;
            solve_with_links(self.scene, &mesh, &off, budget, self.method, &mut callback)
        })?;
        let step = SolveStep::new(texels, mesh, outcome);
        if let Some(observer) = self.observer {
            observer(&step, goal);
        }
        Ok(step)
    }

    fn requested_texels(&self, _: usize) -> Option<[u32; 2]> {
        self.requested_texels.map(|n| [n; 2])
    }

    fn least_resolution(&self, first: &SolveStep) -> Vec<[u32; 2]> {
        if self.follows_rays() {
            resolve_small_faces(self.scene, first, self.error, self.requested_texels.is_none())
        } else {
            divide_lamps(self.scene, first)
        }
    }

    fn result_resolution(&self, last: &SolveStep, change: &StepChange, error: f64) -> Option<Vec<[u32; 2]>> {
        if self.requested_texels.is_some() || self.follows_rays() {
            return None;
        }
        let errors = interpolation_errors(self.scene, last, (change.channel, change.scale));
        let finer = reduce_interpolation_error(&self.scene.faces, &last.resolutions, &errors, error);
        (finer != last.resolutions).then_some(finer)
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

/// Returns the texels of the `first` step, more on lamps: fewer of each where there are many.
fn divide_lamps(scene: &Scene, first: &SolveStep) -> Vec<[u32; 2]> {
    let is_lamp = |face: &&Face| face.emission != Vec3::ZERO;
    let lamps = scene.faces.iter().filter(is_lamp).count() as u64;
    let mut side = MIN_LAMP_TEXELS;
    while side > 1 && lamps * u64::from(side * side) > MAX_LAMP_TEXELS {
        side /= 2;
    }
    let texels = scene.faces.iter().zip(&first.resolutions);
    let divide = |(face, own): (&Face, &[u32; 2])| match is_lamp(&face) {
        true => own.map(|n| n.max(side)),
        false => *own,
    };
    texels.map(divide).collect()
}

/// Returns texels of the second of two steps by rays: half as wide as those of the `first` on the faces that reflect
/// most, since texels as large as their faces would be the same in both steps and their error would not show; or smaller,
/// so that light is interpolated between them to about `error`.
fn resolve_small_faces(scene: &Scene, first: &SolveStep, error: f64, follow_light: bool) -> Vec<[u32; 2]> {
    let (by_channel, channel) = brightest_channel(scene, first);
    let all: f64 = by_channel.iter().sum();
    let resolved = match follow_light && all > 0.0 {
        true => {
            let errors = interpolation_errors(scene, first, (channel, 1.0 / all));
            reduce_interpolation_error(&scene.faces, &first.resolutions, &errors, error)
        }
        false => first.resolutions.clone(),
    };
    let mut resolutions = first.resolutions.clone();
    let mut texels = count_texels(&resolutions);
    let limit = MAX_HALVED_TEXELS.max(2 * texels);
    for f in descending_order(&by_channel) {
        let halved = scene.faces[f as usize].halve_texels(first.resolutions[f as usize]);
        let finer = [0, 1].map(|k| halved[k].max(resolved[f as usize][k]));
        texels += count_texels(&[finer]) - count_texels(&[resolutions[f as usize]]);
        if texels > limit {
            break;
        }
        resolutions[f as usize] = finer;
    }
    resolutions
}

/// Returns ∫ (ρH)² dA of each face in the channel in which the scene reflects most, and that channel.
pub(super) fn brightest_channel(scene: &Scene, step: &SolveStep) -> (Vec<f64>, usize) {
    let ends = first_texels(&step.resolutions);
    let light = |(f, face): (usize, &Face)| {
        let own = &step.reflected[ends[f]..ends[f + 1]];
        own.iter().map(|b| *b * *b).sum::<DVec3>() * face.area() / own.len() as f64
    };
    let light: Vec<DVec3> = scene.faces.iter().enumerate().map(light).collect();
    let channel = light.iter().sum::<DVec3>().max_position();
    (light.iter().map(|light| light[channel]).collect(), channel)
}

/// A solve's last step as its first two foretell it.
pub(super) struct LastStep {
    /// The second step.
    pub step: SolveStep,
    /// Texels and kept rays of the last step.
    pub kept: [u64; 2],
    /// Work of the whole solve over that of the first two steps.
    pub work_ratio: f64,
}

/// A problem that can be solved in steps of increasing resolution.
pub trait AdaptiveProblem {
    /// The result of a step.
    type StepResult: AsRef<SolveStep>;

    /// The scene with all faces.
    fn scene(&self) -> &Scene;

    /// Solves to `goal` on `texels` W×H of each face; `last` is the step before.
    ///
    /// Errors: [`Error::Interrupted`].
    fn solve_step(&self, texels: Vec<[u32; 2]>, goal: f64, last: Option<&Self::StepResult>)
    -> Result<Self::StepResult>;

    /// Largest number of steps.
    fn max_steps(&self) -> u32 {
        MAX_STEPS
    }

    /// Requested texels of a face; `None`: they follow from the light.
    fn requested_texels(&self, face: usize) -> Option<[u32; 2]>;

    /// Texels of a face that keeps its texels in all steps.
    fn fixed_texels(&self, _face: usize) -> Option<[u32; 2]> {
        None
    }

    /// Least texels of each face in the second step, or nothing.
    fn least_resolution(&self, _first: &Self::StepResult) -> Vec<[u32; 2]> {
        Vec::new()
    }

    /// Texels for the final result, if they differ from those of the last step.
    fn result_resolution(&self, _last: &Self::StepResult, _change: &StepChange, _error: f64) -> Option<Vec<[u32; 2]>> {
        None
    }
}

/// Solves until two successive solutions differ by less than `error`. After an interruption it returns the
/// last complete step.
///
/// Errors: [`Error::Interrupted`] before the first step is done.
pub fn refine_until_converged<S: AdaptiveProblem>(problem: &S, error: f64) -> Result<(S::StepResult, ErrorHistory)> {
    let scene = problem.scene();
    let requested = |f: usize| problem.requested_texels(f);
    let mut history = ErrorHistory::default();
    let (mut goal, mut last_goal) = (error, error);
    let (mut last, mut texels) = solve_first_step(problem, error)?;
    for k in 1..problem.max_steps() {
        let texels_now = count_texels(&texels);
        if k > 1 && texels_now > most_texels(last.as_ref().mesh.texels.len() as u64) {
            history.stop_reason = Some(format!("{texels_now} texels would be too many"));
            break;
        }
        last_goal = goal;
        goal = next_goal(goal, error);
        let next = match problem.solve_step(texels.clone(), goal, Some(&last)) {
            Err(Error::Interrupted) => {
                history.stop_reason = Some("it was interrupted".into());
                break;
            }
            next => next?,
        };
        let change = StepChange::compare_steps(scene, last.as_ref(), next.as_ref(), &requested);
        last = next;
        history.changes.push(change.total);
        history.last_change = Some(change);
        if history.meets_target(error) {
            break;
        }
        if let Some(change) = &history.last_change {
            texels = choose_next(problem, last.as_ref(), change, error);
        }
    }
    if history.meets_target(error)
        && let Some(change) = &history.last_change
        && let Some(shown) = problem.result_resolution(&last, change, error)
    {
        // The last change is the error of the step before the last, whose goal would do if links had no other error.
        match problem.solve_step(shown, (goal * last_goal).sqrt(), Some(&last)) {
            Err(Error::Interrupted) => history.stop_reason = Some("it was interrupted".into()),
            shown => last = shown?,
        }
    }
    history.links = last.as_ref().outcome.links;
    Ok((last, history))
}

/// Returns the error to which the step after one to `goal` is solved.
pub(super) fn next_goal(goal: f64, error: f64) -> f64 {
    (0.5 * goal).max(MIN_GOAL_SHARE * error)
}

/// Returns the largest number of texels of a step after one of this number.
pub(super) fn most_texels(before: u64) -> u64 {
    MAX_STEP_TEXELS.max(2 * before).min(MAX_TEXELS)
}

/// Returns the texels of the step after `last`, in which the light changed by `change`.
pub(super) fn choose_next<S: AdaptiveProblem>(
    problem: &S,
    last: &SolveStep,
    change: &StepChange,
    error: f64,
) -> Vec<[u32; 2]> {
    let (faces, before) = (&problem.scene().faces, &last.resolutions);
    let may_refine = |f: usize| problem.fixed_texels(f).is_none();
    let unrefined = UNREFINED_SHARE * error * error;
    let mut texels = halve_largest(faces, before, &change.by_face, unrefined, may_refine);
    refine_neighbours(faces, before, &mut texels, may_refine);
    texels
}

/// Solves the first step, to `error`, and chooses the texels of the second.
///
/// Errors: [`Error::Interrupted`].
pub(super) fn solve_first_step<S: AdaptiveProblem>(problem: &S, error: f64) -> Result<(S::StepResult, Vec<[u32; 2]>)> {
    let scene = problem.scene();
    let width = first_texel_width(scene)?;
    let requested = |f: usize| problem.requested_texels(f);
    let keep_fixed = |texels: &mut [[u32; 2]]| {
        for (f, own) in texels.iter_mut().enumerate() {
            *own = problem.fixed_texels(f).unwrap_or(*own);
        }
    };
    let mut texels = choose_first(scene, &requested, width);
    keep_fixed(&mut texels);
    let first = problem.solve_step(texels, error, None)?;
    texels = choose_second(scene, &requested, width, &first.as_ref().resolutions);
    keep_fixed(&mut texels);
    for (own, least) in texels.iter_mut().zip(problem.least_resolution(&first)) {
        *own = [0, 1].map(|k| own[k].max(least[k]));
    }
    Ok((first, texels))
}

/// Returns a callback that reports a step's progress and breaks on an interruption.
pub fn step_progress<'a>(progress: &'a ProgressMonitor, phase: &'a str) -> impl FnMut(f64) -> ControlFlow<()> + 'a {
    move |done| {
        if is_interrupted() {
            progress.mark_stopped();
            return ControlFlow::Break(());
        }
        progress.report_share(phase, done)
    }
}
