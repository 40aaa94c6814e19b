//! A solve by rays in steps of smaller texels.
//!
//! In each step few rays tell the error of the texels: the change of the light if they are merged two by two, on the same
//! rays, whose noise cancels. Where it is small enough, rays are added until their noise is, too; else the texels whose
//! merging causes most of the change are halved, and the next step begins.

use super::adaptive::{AdaptiveSolve, brightest_channel};
use super::adjacency::refine_neighbours;
use super::error_estimate::{ErrorHistory, StepChange};
use super::interpolation_error::{ReceivedLight, interpolation_errors, reduce_interpolation_error};
use super::lamp_gather::LampGather;
use super::progress::step_progress;
use super::refinement::{AdaptiveProblem, most_texels};
use super::regather::estimate::descending_order;
use super::resolution::{
    TexelError, choose_first, choose_second, coarser_texels, count_texels, first_texel_width, halve_by_cost,
    resample_face,
};
use super::step::SolveStep;
use super::step_forecast::{StepForecast, foretell_gathers};
use common::mesh::Mesh;
use common::passes::ProgressCallback;
use common::rays::Rays;
use common::resample::halve_even;
use common::texel::first_texels;
use common::{Error, Result};
use cpu::dense::open_points::OpenParts;
use cpu::ray_cast::{DividedLight, Halves, RaySolve, count_traced_rays, grown_rays};
use glam::{DVec3, Vec3A};

/// Noise at which [`ROUGH_TEXELS`] are judged, as a multiple of the requested error.
const ROUGH_NOISE: f64 = 2.0;
/// See [`ROUGH_NOISE`].
const ROUGH_TEXELS: f64 = 4096.0;
/// Largest error of the texels of the last step, as a share of the requested error.
const MAX_TEXEL_SHARE: f64 = 0.75;
/// Error for which the texels of the next step are chosen, as a share of the requested error.
const NEXT_TEXEL_SHARE: f64 = 0.6;
/// Largest noise of the last step, as a share of the requested error.
const MAX_NOISE_SHARE: f64 = 0.75;
/// Least noise that is aimed at, as a share of the requested error.
const MIN_NOISE_SHARE: f64 = 0.5;
/// Noise that is aimed at, as a share of what the error of the texels leaves.
const AIMED_NOISE_SHARE: f64 = 0.95;
/// Noise to which a step is solved before the lamps' light is gathered, as a share of that which is aimed at.
const SOLVE_NOISE_SHARE: f64 = 0.85;
/// Noise that is accepted over that which is aimed at.
const NOISE_TOLERANCE: f64 = 1.05;
/// Number of gathers of the lamps' light by few rays whose texels are foretold: one less than there may be, since light is
/// smoother on smaller texels than foretold.
const FORETOLD_GATHERS: u32 = 3;
/// Work of a ray of a gather, over that of a pair of rays of a solve.
const GATHER_RAY_WORK: f64 = 0.5;
/// Number of texels up to which the second step of many small faces halves them.
const MAX_HALVED_TEXELS: u64 = 1 << 16;
/// Share of the progress after which the first rays are traced, and in which the change is measured.
const FIRST_RAYS_PROGRESS: f64 = 0.4;
/// See [`FIRST_RAYS_PROGRESS`].
const CHANGE_PROGRESS: f64 = 0.1;
/// Share of the remaining progress in which rays are added once.
const ADDED_RAYS_PROGRESS: f64 = 0.9;

/// A step on given texels.
struct RayStep {
    step: SolveStep,
    change: StepChange,
    /// The step's light.
    light: DividedLight,
    /// Share of each face's texels in the squared change.
    by_cause: Vec<f64>,
}

impl RayStep {
    /// Returns the gather of the lamps' light that may follow.
    fn lamp_gather<'a>(&'a self, problem: &'a AdaptiveSolve<'a>, error: f64) -> LampGather<'a> {
        LampGather {
            problem,
            solved: &self.step,
            light: &self.light,
            change: &self.change,
            error,
        }
    }

    /// Returns the noise of the lamps' light, as [`StepChange::noise`] is that of all light.
    fn direct_noise(&self) -> f64 {
        let (mut direct, mut all) = (0.0, 0.0);
        let light = self.light.direct.iter().zip(&self.step.outcome.noise);
        for (texel, ([a, b], noise)) in self.step.mesh.texels.iter().zip(light) {
            let channel = self.change.channel;
            let square = |noise: f32| f64::from((texel.reflectance[channel] * noise).powi(2) * texel.area);
            direct += square(0.5 * (a[channel] - b[channel]));
            all += square(noise[channel]);
        }
        if all > 0.0 {
            self.change.noise * (direct / all).sqrt()
        } else {
            0.0
        }
    }
}

/// Solves until the noise of the rays and the error of the texels together are below `error`. After an interruption it
/// returns the last complete step.
///
/// Errors: [`Error::Interrupted`] before the first step is done; those of the sky.
pub(super) fn refine_by_rays(problem: &AdaptiveSolve, error: f64) -> Result<(SolveStep, ErrorHistory)> {
    let mut history = ErrorHistory {
        of_merged_texels: true,
        ..ErrorHistory::default()
    };
    let (mut last, mut texels) = solve_first_texels(problem, error)?;
    let max_steps = problem.max_steps();
    for k in 1..max_steps {
        let may_double = 2 * count_texels(&texels) <= most_texels(last.step.mesh.texels.len() as u64);
        let finish = match may_double && k + 1 < max_steps {
            true => Finish::IfTexelsSuffice,
            false => Finish::Always,
        };
        last = match solve_on_texels(problem, texels, error, finish) {
            Err(Error::Interrupted) => {
                history.stop_reason = Some("it was interrupted".into());
                break;
            }
            next => next?,
        };
        history.changes.push(last.change.total);
        if last.change.total.hypot(last.change.noise) <= error {
            break;
        }
        if !may_double {
            history.stop_reason = Some("more texels would be too many".into());
            break;
        }
        texels = choose_next(problem, &last, error);
        if texels == last.step.resolutions {
            history.stop_reason = Some("more rays would be too many".into());
            break;
        }
    }
    history.links = last.step.outcome.links;
    history.last_change = Some(last.change);
    Ok((last.step, history))
}

/// Solves the first two steps roughly and forecasts the rest. Returns the second step, too, which tells the texels of the last
/// one. The noise variance of n rays falls as n^-1.25 whatever the texels are, so that a texel's rays grow by the noise's ratio
/// to the power 1.6.
///
/// Errors: [`Error::Interrupted`]; those of the sky.
pub(super) fn forecast_by_rays(problem: &AdaptiveSolve, error: f64) -> Result<(SolveStep, StepForecast)> {
    let (first, texels) = solve_first_texels(problem, error)?;
    let second = solve_on_texels(problem, texels, error, Finish::Forecast)?;
    let traced = |step: &RayStep| count_traced_rays(step.step.outcome.links, step.step.mesh.texels.len() as u64);
    let known = traced(&first) + traced(&second);
    let before = second.step.mesh.texels.len() as u64;
    let next = (second.change.total > MAX_TEXEL_SHARE * error).then(|| choose_next(problem, &second, error));
    let after = next.as_ref().map_or(before, |texels| count_texels(texels));
    let texel_error = second.change.total.min(NEXT_TEXEL_SHARE * error);
    let grown =
        |texels: u64, ratio: f64| grown_rays(second.step.outcome.links, [before, texels], ratio.max(1.0) as f32);
    let rays_for = |ratio: f64| grown(after, ratio);
    let aimed = aimed_noise(error, texel_error);
    let rough_noise = |texels: &[[u32; 2]]| rough_noise(error, count_texels(&compared_texels(problem, texels)));
    let judge = |texels: Vec<[u32; 2]>| {
        let ratio = rough_noise(&second.step.resolutions) / rough_noise(&texels);
        count_traced_rays(rays_for(ratio), after)
    };
    let solved = next.as_deref().unwrap_or(&second.step.resolutions);
    let direct = ReceivedLight::from_halves(&second.light.direct);
    let gathers = foretell_gathers(problem, error, (&second.step, &direct), (solved, 1.0, FORETOLD_GATHERS));
    let share = if gathers.is_empty() { 1.0 } else { SOLVE_NOISE_SHARE };
    let rays = rays_for(second.change.noise / (share * aimed));
    // The texels in which a lamp is partly hidden have most of the variance; their area falls as their width.
    let gathered = gathers.last().map_or(0, |texels| {
        let noise = second.direct_noise() * (before as f64 / count_texels(texels) as f64).powf(0.25);
        let changed = texels.iter().zip(solved).filter(|(own, solved)| own != solved);
        let changed: Vec<[u32; 2]> = changed.map(|(own, _)| *own).collect();
        grown(count_texels(&changed), noise / (aimed * (1.0 - share * share).sqrt()))
    });
    let rough = next.map_or(0, judge);
    let forecast = StepForecast {
        kept: [
            gathers.last().map_or(after, |texels| count_texels(texels)),
            rays + gathered,
        ],
        work_ratio: 1.0 + (rough as f64 + rays as f64 + GATHER_RAY_WORK * gathered as f64) / known.max(1) as f64,
    };
    Ok((second.step, forecast))
}

/// Solves roughly on the first texels, and chooses those of the second step.
///
/// Errors: [`Error::Interrupted`]; those of the sky.
fn solve_first_texels(problem: &AdaptiveSolve, error: f64) -> Result<(RayStep, Vec<[u32; 2]>)> {
    let scene = problem.scene();
    let requested = |f: usize| problem.requested_texels(f);
    let width = first_texel_width(scene)?;
    let first = solve_on_texels(problem, choose_first(scene, &requested, width), error, Finish::Never)?;
    let mut texels = choose_second(scene, &requested, width, &first.step.resolutions);
    for (own, least) in texels.iter_mut().zip(resolve_small_faces(problem, &first, error)) {
        *own = [0, 1].map(|k| own[k].max(least[k]));
    }
    Ok((first, texels))
}

/// Returns texels of the second of two steps: half as wide as those of the `first` on the faces that reflect most, since
/// texels as large as their faces would be the same in both steps and their error would not show; or smaller, so that
/// reflected light is interpolated between them to about `error`.
fn resolve_small_faces(problem: &AdaptiveSolve, first: &RayStep, error: f64) -> Vec<[u32; 2]> {
    let (scene, before) = (problem.scene(), &first.step.resolutions);
    let (by_channel, channel) = brightest_channel(scene, &first.step);
    let all: f64 = by_channel.iter().sum();
    let resolved = match problem.requested_texels(0).is_none() && all > 0.0 {
        true => {
            let reflected = ReceivedLight::from_halves(&first.light.reflected);
            let errors = interpolation_errors(scene, &first.step, &reflected, (channel, 1.0 / all));
            reduce_interpolation_error(&scene.faces, before, &errors, error)
        }
        false => before.clone(),
    };
    let mut resolutions = before.clone();
    let mut texels = count_texels(&resolutions);
    let limit = MAX_HALVED_TEXELS.max(2 * texels);
    for f in descending_order(&by_channel) {
        let f = f as usize;
        let halved = scene.faces[f].halve_texels(before[f]);
        let finer = [0, 1].map(|k| halved[k].max(resolved[f][k]));
        texels += count_texels(&[finer]) - count_texels(&[resolutions[f]]);
        if texels > limit {
            break;
        }
        resolutions[f] = finer;
    }
    resolutions
}

/// Returns the texels of the step after `last`.
fn choose_next(problem: &AdaptiveSolve, last: &RayStep, error: f64) -> Vec<[u32; 2]> {
    let (faces, before) = (&problem.scene().faces, &last.step.resolutions);
    let aimed = NEXT_TEXEL_SHARE * error;
    let remaining = (aimed / last.change.total.max(aimed)).powi(2);
    // The change falls as the width of the texels.
    let error = |square: &f64| TexelError {
        square: *square,
        ratio: 0.25,
    };
    let errors: Vec<TexelError> = last.by_cause.iter().map(error).collect();
    let mut texels = halve_by_cost(
        faces,
        before,
        &errors,
        (remaining, most_texels(last.step.mesh.texels.len() as u64)),
    );
    refine_neighbours(faces, before, &mut texels, |_| true);
    texels
}

/// Returns the noise that is aimed at beside an error of the texels.
fn aimed_noise(error: f64, texel_error: f64) -> f64 {
    let left = (error.powi(2) - texel_error.powi(2)).max(0.0).sqrt();
    (AIMED_NOISE_SHARE * left).clamp(MIN_NOISE_SHARE * error, MAX_NOISE_SHARE * error)
}

/// Returns the noise at which these many `texels` are judged. Their squared change is a sum over texels of products of the two
/// halves: its own noise is the squared noise over the root of their number.
fn rough_noise(error: f64, texels: u64) -> f64 {
    ROUGH_NOISE * error * (texels as f64 / ROUGH_TEXELS).max(1.0).powf(0.25)
}

/// Whether a step is solved to the noise that its texels leave of the error.
#[derive(Clone, Copy, PartialEq)]
enum Finish {
    Never,
    /// Never, but the light is smoothed, which tells the noise from which a last step would go on.
    Forecast,
    IfTexelsSuffice,
    Always,
}

/// Solves roughly on `texels`, and if it is to `finish`, to the noise that they leave of `error`.
///
/// Errors: [`Error::Interrupted`]; those of the sky.
fn solve_on_texels(problem: &AdaptiveSolve, texels: Vec<[u32; 2]>, error: f64, finish: Finish) -> Result<RayStep> {
    let (scene, progress) = (problem.scene(), problem.progress);
    let mesh = progress.time_phase("prepare", || Mesh::new(scene, &texels, 1))?;
    let (mut found, outside) = progress.time_phase("solve", || -> Result<_> {
        let rays = Rays::new(&mesh);
        let open = OpenParts::new(scene, &mesh, &rays);
        let mut traced = TracedStep {
            problem,
            texels: &texels,
            mesh: &mesh,
            solve: RaySolve::new(scene, &mesh, &rays, &open)?,
        };
        let name = format!("judging {} texels", count_texels(&texels));
        let mut watch = step_progress(progress, &name);
        let mut found = traced.measure_at_noise(f64::INFINITY, &mut |done| watch(FIRST_RAYS_PROGRESS * done))?;
        let mut later = |done| watch(FIRST_RAYS_PROGRESS + (1.0 - FIRST_RAYS_PROGRESS) * done);
        let compared = count_texels(&compared_texels(problem, &texels));
        found = traced.reduce_noise(found, rough_noise(error, compared), &mut later)?;
        let suffices = finish == Finish::IfTexelsSuffice && found.change.total <= MAX_TEXEL_SHARE * error;
        if finish == Finish::Forecast {
            traced.solve.smooth_light();
            found = traced.measure_at_noise(f64::INFINITY, &mut later)?;
        }
        if suffices || finish == Finish::Always {
            let name = format!("solving to {:.2} %", 100.0 * error);
            let may_gather = problem.requested_texels(0).is_none() && found.lamp_gather(problem, error).finds_error();
            let share = if may_gather { SOLVE_NOISE_SHARE } else { 1.0 };
            traced.solve.smooth_light();
            for _ in 0..2 {
                // With less noise the error of the texels may turn out larger.
                let noise = share * aimed_noise(error, found.change.total);
                found = traced.reduce_noise(found, noise, &mut step_progress(progress, &name))?;
                if found.change.total.hypot(found.change.noise) <= error {
                    break;
                }
            }
            let outside = traced.solve.outside_light();
            let is_last = finish == Finish::Always || found.change.total.hypot(found.change.noise) <= error;
            let gathered = match may_gather && is_last {
                true => {
                    let rough = |texels| rough_noise(error, texels);
                    let noise = aimed_noise(error, found.change.total);
                    let gather = found.lamp_gather(problem, error);
                    match gather.gather_light(&rough, noise, &outside) {
                        // The solve is complete without it.
                        Err(Error::Interrupted) => None,
                        gathered => gathered?,
                    }
                }
                false => None,
            };
            if let Some(gathered) = gathered {
                found.change = found.change.with_noise_of(scene, &gathered.step);
                found.step = gathered.step;
                return Ok((found, gathered.outside));
            }
        }
        Ok((found, traced.solve.outside_light()))
    })?;
    for (texel, outside) in found.step.mesh.texels.iter_mut().zip(outside) {
        texel.sky = outside;
    }
    Ok(found)
}

/// The rays of a step.
struct TracedStep<'a> {
    problem: &'a AdaptiveSolve<'a>,
    texels: &'a [[u32; 2]],
    mesh: &'a Mesh,
    solve: RaySolve<'a>,
}

impl TracedStep<'_> {
    /// Adds rays until the noise of B on the requested texels is about `noise`, or no more are kept.
    fn reduce_noise(&mut self, mut found: RayStep, noise: f64, watch: ProgressCallback) -> Result<RayStep> {
        let mut before = 0.0;
        while found.change.noise > noise * NOISE_TOLERANCE {
            // That of means over requested texels falls about as that of the texels.
            let of_texels = f64::from(self.solve.relative_noise()) * noise / found.change.noise;
            let (rays, before_noise) = (found.step.outcome.links, found.change.noise);
            let span = (1.0 - before) * ADDED_RAYS_PROGRESS;
            found = self.measure_at_noise(of_texels, &mut |done| watch(before + span * done))?;
            before += span;
            if found.step.outcome.links == rays && found.change.noise >= before_noise {
                break;
            }
        }
        Ok(found)
    }

    /// Solves to a noise of the texels, and measures by how much the light changes if they are merged.
    fn measure_at_noise(&mut self, noise: f64, watch: ProgressCallback) -> Result<RayStep> {
        let solved = 1.0 - CHANGE_PROGRESS;
        let outcome = self
            .solve
            .solve_to_noise(noise as f32, &mut |done| watch(solved * done))?;
        let merged = self
            .solve
            .change_if_merged(&mut |done| watch(solved + CHANGE_PROGRESS * done))?;
        let step = SolveStep::new(self.texels.to_vec(), self.mesh.clone(), outcome);
        let faces = &self.problem.scene().faces;
        let order = self.mesh.texels_in_face_order();
        let first = first_texels(self.texels);
        let compared = compared_texels(self.problem, self.texels);
        let mean = |f: usize, half: usize| {
            let own = order[first[f]..first[f + 1]].iter();
            let values: Vec<DVec3> = own.map(|k| merged.reflected[*k][half].as_dvec3()).collect();
            resample_face(&values, &faces[f], self.texels[f], compared[f])
        };
        let changes: Vec<[Vec<DVec3>; 2]> = (0..faces.len()).map(|f| [mean(f, 0), mean(f, 1)]).collect();
        let requested = |f: usize| self.problem.requested_texels(f);
        let change = StepChange::from_halves(self.problem.scene(), &step, (&changes, &compared), &requested);
        let weights = self.weigh_receivers(&change, (&changes, &compared));
        Ok(RayStep {
            by_cause: self.solve.attribute_change(&merged.sent, &weights),
            light: self.solve.divided_light(),
            step,
            change,
        })
    }

    /// Returns by how much ∫ change² grows with H of each texel: Aρ times the change there, in the channel of the largest.
    fn weigh_receivers(
        &self,
        change: &StepChange,
        (changes, compared): (&[[Vec<DVec3>; 2]], &[[u32; 2]]),
    ) -> Vec<Halves> {
        let order = self.mesh.texels_in_face_order();
        let first = first_texels(self.texels);
        let mut weights = vec![[Vec3A::ZERO; 2]; order.len()];
        for (f, face) in self.problem.scene().faces.iter().enumerate() {
            let halves = [0, 1].map(|half| resample_face(&changes[f][half], face, compared[f], self.texels[f]));
            for (n, k) in order[first[f]..first[f + 1]].iter().enumerate() {
                let texel = &self.mesh.texels[*k];
                let weight = texel.reflectance[change.channel] * texel.area;
                for (weighted, changes) in weights[*k].iter_mut().zip(&halves) {
                    weighted[change.channel] = weight * changes[n][change.channel] as f32;
                }
            }
        }
        weights
    }
}

/// Returns the texels of each face on which a change is measured: the merged ones, or the requested ones if those are larger.
fn compared_texels(problem: &AdaptiveSolve, texels: &[[u32; 2]]) -> Vec<[u32; 2]> {
    let merged = texels.iter().map(|texels| halve_even(*texels)).enumerate();
    let compared = merged.map(|(f, merged)| match problem.requested_texels(f) {
        Some(requested) => coarser_texels(merged, requested),
        None => merged,
    });
    compared.collect()
}
