//! An adaptive solve of a scene to a requested error: what its steps by links ask of the scene, and whether rays or links
//! carry the light.

use super::error_estimate::StepChange;
use super::progress::{ProgressMonitor, step_progress};
use super::refinement::{AdaptiveProblem, MAX_STEPS};
use super::resolution::{RequestedTexels, count_texels};
use super::shadow_steps::ShadowSteps;
use super::solver::ErrorTarget;
use super::step::SolveStep;
use common::Result;
use common::mesh::Mesh;
use common::scene::{Face, Scene};
use common::solution::{Warning, WarningCode};
use common::texel::first_texels;
use cpu::hierarchy::linker::LinkMethod;
use cpu::hierarchy::sky::receive_sky;
use cpu::hierarchy::solver::{ErrorBudget, solve_with_links};
use glam::{DVec3, Vec3};

/// Number of faces from which on a scene is solved by rays.
const MIN_RAY_FACES: f64 = 200.0;
/// The same number times the requested error: links grow with its inverse, rays faster.
const RAY_FACES_PER_INVERSE_ERROR: f64 = 2.0;
/// Least texels per side of a lamp in the second step by links: its parts are sources where it is half hidden. One texel
/// has at most 64 samples of visibility.
const MIN_LAMP_TEXELS: u32 = 8;
/// Largest number of texels of all lamps for which each has [`MIN_LAMP_TEXELS`].
const MAX_LAMP_TEXELS: u64 = 1 << 14;

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

    /// Returns whether light is traced by rays.
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
        divide_lamps(self.scene, first)
    }

    fn resolve_light(&self, last: SolveStep, change: &StepChange, (goal, most): (f64, u32)) -> Result<SolveStep> {
        match self.requested_texels.is_some() || self.follows_rays() {
            true => Ok(last),
            false => {
                let steps = ShadowSteps {
                    scene: self.scene,
                    error: self.error,
                    method: self.method,
                    goal,
                    most,
                    progress: self.progress,
                };
                steps.resolve_light(last, change)
            }
        }
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
