//! A solve to a requested error, by rays where faces are many and small and by links elsewhere, on the requested texels.

use super::adaptive::{AdaptiveSolve, StepObserver};
use super::error_estimate::ErrorHistory;
use super::interpolation_error::measure_interpolation;
use super::progress::ProgressMonitor;
use super::ray_steps::refine_by_rays;
use super::refinement::{AdaptiveProblem, RefinementSteps};
use super::resolution::resample_face;
use super::solved::Solved;
use super::solver::ErrorTarget;
use super::step::{SolveStep, narrow_to_f32, resample_step};
use common::Result;
use common::cover::sample_covers;
use common::mesh::Mesh;
use common::scene::Scene;
use common::settings::Settings;
use common::texel::texel_count;
use cpu::hierarchy::linker::LinkMethod;
use cpu::hierarchy::shot_log;
use cpu::hierarchy::solver::TexelSolution;
use glam::{DVec3, Vec3};

/// Sample points per face for the escaping share of its light.
pub const ESCAPE_POINTS: u32 = 16;

/// Solves `scene` to the error of `target`: by rays, or with links found by `method`. After an interruption it returns the
/// last complete step.
///
/// Errors: [`common::Error::Interrupted`] before the first step is done.
pub fn solve_adaptively(
    scene: &Scene,
    settings: &Settings,
    target: ErrorTarget,
    method: LinkMethod,
    progress: &ProgressMonitor,
) -> Result<Solved> {
    solve_in_steps(&AdaptiveSolve::new(scene, target, method, progress), settings, target)
}

/// Solves as [`solve_adaptively`] does, in at most `max_steps` steps.
///
/// Errors: [`common::Error::Interrupted`] before the first step is done.
pub fn solve_adaptively_within(
    scene: &Scene,
    settings: &Settings,
    target: ErrorTarget,
    (method, max_steps): (LinkMethod, u32),
    progress: &ProgressMonitor,
) -> Result<Solved> {
    let problem = AdaptiveSolve::new(scene, target, method, progress).with_max_steps(max_steps);
    solve_in_steps(&problem, settings, target)
}

/// Solves as [`solve_adaptively`] does, and calls `observer` with each step by links.
///
/// Errors: [`common::Error::Interrupted`] before the first step is done.
pub fn solve_with_observer(
    scene: &Scene,
    settings: &Settings,
    target: ErrorTarget,
    (method, observer): (LinkMethod, StepObserver),
    progress: &ProgressMonitor,
) -> Result<Solved> {
    let problem = AdaptiveSolve::new(scene, target, method, progress).with_observer(observer);
    solve_in_steps(&problem, settings, target)
}

fn solve_in_steps(problem: &AdaptiveSolve, settings: &Settings, target: ErrorTarget) -> Result<Solved> {
    let (step, mut history) = match problem.follows_rays() {
        true => refine_by_rays(problem, target.error)?,
        false => RefinementSteps::solve_first(problem, target.error)?.solve_rest()?,
    };
    if let (None, Some(change)) = (target.texels, &history.last_change) {
        history.interpolation = measure_interpolation(problem.scene(), &step, (change.channel, change.scale));
    }
    let mut solved = resample_result(problem.scene(), settings, target, step, history)?;
    solved.run.field.origin = match problem.follows_rays() {
        true => "rays".into(),
        false => format!("hierarchy by {}", problem.method.name()),
    };
    Ok(solved)
}

/// Converts the last step to the requested texels.
pub(super) fn resample_result(
    scene: &Scene,
    settings: &Settings,
    target: ErrorTarget,
    step: SolveStep,
    history: ErrorHistory,
) -> Result<Solved> {
    let to = |own: &[u32; 2]| target.texels.map_or(*own, |n| [n; 2]);
    let texels: Vec<[u32; 2]> = step.resolutions.iter().map(to).collect();
    let mut mesh = Mesh::new(scene, &texels, 1)?;
    sample_covers(&mut mesh, ESCAPE_POINTS);
    // A mesh has its texels in face order because each face is one patch.
    let light = |values: &[Vec3]| narrow_to_f32(resample_step(&scene.faces, &step, &texels, &|k| values[k].as_dvec3()));
    let open = |k: usize| DVec3::splat(f64::from(step.outcome.open[k]));
    let open = narrow_to_f32(resample_step(&scene.faces, &step, &texels, &open));
    if scene.sky.is_some() {
        let outside: Vec<Vec3> = step.mesh.texels.iter().map(|texel| texel.sky).collect();
        for (texel, sky) in mesh.texels.iter_mut().zip(light(&outside)) {
            texel.sky = sky;
        }
    }
    let mut irradiance = light(&step.outcome.irradiance);
    weight_by_reflectance(scene, &step, &mesh, &mut irradiance);
    let outcome = TexelSolution {
        irradiance,
        residual: light(&step.outcome.residual),
        open: open.iter().map(|open| open.x).collect(),
        links: step.outcome.links,
        passes: step.outcome.passes,
        converged: step.outcome.converged,
        ..TexelSolution::default()
    };
    shot_log::set_open_shares(&mut mesh, &outcome);
    let run = shot_log::record_run(&mesh, &outcome, &shot_log::measure_escape(&step.mesh, &step.outcome));
    Ok(Solved {
        // Means over other texels differ from these texels' own shares.
        open: (texels == step.resolutions).then_some(outcome.open),
        history: Some(history),
        ..Solved::new(settings, mesh, run)
    })
}

/// Weights H by ρ on requested texels within which ρ varies: then B = E + ρH, with the texel's mean ρ, is the
/// mean over the texel.
fn weight_by_reflectance(scene: &Scene, step: &SolveStep, mesh: &Mesh, irradiance: &mut [Vec3]) {
    let (mut from, mut to) = (0, 0);
    for (f, face) in scene.faces.iter().enumerate() {
        let (many, few) = (step.resolutions[f], mesh.faces[f].resolution);
        let [first, next] = [from, to];
        from += texel_count(many) as usize;
        to += texel_count(few) as usize;
        if face.paint.is_none() || (0..2).all(|k| many[k] <= few[k]) {
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
