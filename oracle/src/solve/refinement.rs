//! Steps of increasing resolution until two successive solutions differ by less than the requested error.
//!
//! Each step is solved to half the error of the step before, and on texels half as large where that matters. If no texels are
//! requested, they are halved in the end where interpolation between them errs most.
//!
//! The difference d of the last two solutions bounds the finer one's error. It is at least the error of the coarser less
//! that of the finer; where a step halves the error the two are equal. Where a step reduces the error less, d is too small.
//! So the first step is already solved to the requested error and the result to half of it, and where differences fall more
//! slowly than by halves, the remaining error is extrapolated from their ratio (see [`ErrorHistory::remaining_bound`]).

use super::adjacency::refine_neighbours;
use super::error_estimate::{ErrorHistory, StepChange};
use super::resolution::{choose_first, choose_second, count_texels, first_texel_width, halve_largest};
use super::step::SolveStep;
use common::mesh::MAX_TEXELS;
use common::scene::Scene;
use common::{Error, Result};

/// Largest number of steps.
pub(super) const MAX_STEPS: u32 = 6;
/// Largest number of steps that only gather light. Each makes 16 times as many texels on a face at most.
const MAX_GATHER_STEPS: u32 = 4;
/// Smallest goal of a step, as a share of the requested error. Remaining differences are then due to the
/// texels' size.
const MIN_GOAL_SHARE: f64 = 0.25;
/// Largest number of texels of a step; in a large scene twice the number of the step before.
const MAX_STEP_TEXELS: u64 = 1 << 20;
/// Share of the squared error that may come from faces whose texels are not halved.
const UNREFINED_SHARE: f64 = 0.25;

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

    /// Gathers light on texels between which it is interpolated to the requested error, if those of the `last` step, which
    /// changed the light by `change`, are too large: to an error, in at most so many steps. After an interruption it returns
    /// the last complete step.
    ///
    /// Errors: those of a step.
    fn resolve_light(
        &self,
        last: Self::StepResult,
        _change: &StepChange,
        _goal_and_most: (f64, u32),
    ) -> Result<Self::StepResult> {
        Ok(last)
    }
}

/// A problem in the course of being solved in steps.
pub struct RefinementSteps<'a, S: AdaptiveProblem> {
    pub(super) problem: &'a S,
    /// Requested error.
    pub(super) error: f64,
    /// The last complete step.
    pub(super) last: S::StepResult,
    /// Errors to which the last two steps were solved.
    pub(super) goals: [f64; 2],
    pub(super) history: ErrorHistory,
    /// Texels of the next step.
    pub(super) texels: Vec<[u32; 2]>,
    /// Number of texels of each step.
    pub(super) counts: Vec<u64>,
}

impl<'a, S: AdaptiveProblem> RefinementSteps<'a, S> {
    /// Solves the first step, to `error`, and chooses the texels of the second.
    ///
    /// Errors: [`Error::Interrupted`].
    pub fn solve_first(problem: &'a S, error: f64) -> Result<Self> {
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
        let count = first.as_ref().mesh.texels.len() as u64;
        Ok(Self {
            problem,
            error,
            last: first,
            goals: [error; 2],
            history: ErrorHistory::default(),
            texels,
            counts: vec![count],
        })
    }

    /// Solves another step, and chooses the texels of the next. Returns false if the error is met or no step may follow.
    ///
    /// Errors: those of the step, but for an interruption, which ends the steps.
    pub fn solve_next(&mut self) -> Result<bool> {
        let Self { problem, error, .. } = *self;
        let texels = count_texels(&self.texels);
        let before = self.last.as_ref().mesh.texels.len() as u64;
        if self.history.stop_reason.is_some() || self.meets_target() || self.history.steps() >= problem.max_steps() {
            return Ok(false);
        }
        if self.history.steps() > 1 && texels > most_texels(before) {
            self.history.stop_reason = Some(format!("{texels} texels would be too many"));
            return Ok(false);
        }
        let goal = next_goal(self.goals[1], error);
        let next = match problem.solve_step(self.texels.clone(), goal, Some(&self.last)) {
            Err(Error::Interrupted) => {
                self.mark_interrupted();
                return Ok(false);
            }
            next => next?,
        };
        self.goals = [self.goals[1], goal];
        self.counts.push(texels);
        let requested = |f: usize| problem.requested_texels(f);
        let change = StepChange::compare_steps(problem.scene(), self.last.as_ref(), next.as_ref(), &requested);
        self.last = next;
        self.history.changes.push(change.total);
        if !self.history.meets_target(error) {
            self.texels = self.choose_next(&change);
        }
        self.history.last_change = Some(change);
        Ok(true)
    }

    /// Returns whether the remaining error is known to be at most the requested one.
    pub fn meets_target(&self) -> bool {
        self.history.meets_target(self.error)
    }

    /// Ends the steps.
    pub fn mark_interrupted(&mut self) {
        self.history.stop_reason = Some("it was interrupted".into());
    }

    /// Solves the other steps until two successive solutions differ by less than the error. After an interruption it returns
    /// the last complete step.
    ///
    /// Errors: those of a step.
    pub fn solve_rest(mut self) -> Result<(S::StepResult, ErrorHistory)> {
        while self.solve_next()? {}
        let Self { last, mut history, .. } = self.resolve_light(MAX_GATHER_STEPS)?;
        history.links = last.as_ref().outcome.links;
        Ok((last, history))
    }

    /// Gathers light on smaller texels in at most `most` steps, if the error is met.
    ///
    /// Errors: those of a step.
    pub fn resolve_light(mut self, most: u32) -> Result<Self> {
        if self.meets_target()
            && let Some(change) = &self.history.last_change
        {
            // The last change is the error of the step before the last, whose goal would do if links had no other error.
            let goal = (self.goals[0] * self.goals[1]).sqrt();
            self.last = self.problem.resolve_light(self.last, change, (goal, most))?;
        }
        Ok(self)
    }

    /// Returns the texels of the step after the last, in which the light changed by `change`.
    fn choose_next(&self, change: &StepChange) -> Vec<[u32; 2]> {
        let (faces, before) = (&self.problem.scene().faces, &self.last.as_ref().resolutions);
        let may_refine = |f: usize| self.problem.fixed_texels(f).is_none();
        let unrefined = UNREFINED_SHARE * self.error * self.error;
        let mut texels = halve_largest(faces, before, &change.by_face, unrefined, may_refine);
        refine_neighbours(faces, before, &mut texels, may_refine);
        texels
    }
}

/// Returns the error to which the step after one to `goal` is solved.
pub(super) fn next_goal(goal: f64, error: f64) -> f64 {
    (0.5 * goal).max(MIN_GOAL_SHARE * error)
}

/// Returns the largest number of texels of a step after one of this number.
pub(super) fn most_texels(before: u64) -> u64 {
    MAX_STEP_TEXELS.max(2 * before).min(MAX_TEXELS)
}
