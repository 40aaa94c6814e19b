//! Relights to a requested error: solves the change that the objects make in successive steps, and the room too
//! where it is a scene. The room's texels are as small as needed for the objects' shadows where these are visible.

use super::captured_room::CapturedValues;
use super::receiver_blocks::choose_block_sizes;
use super::stage::RelightStage;
use crate::solve::adaptive::{follows_rays, noise_on_texels};
use crate::solve::progress::{ProgressMonitor, step_progress};
use crate::solve::refinement::{AdaptiveProblem, RefinementSteps};
use crate::solve::resolution::{count_texels, resample_face};
use crate::solve::solve_to_error::ESCAPE_POINTS;
use crate::solve::solved::{RelightReport, Solved};
use crate::solve::solver::ErrorTarget;
use crate::solve::step::{SolveStep, narrow_to_f32, resample_step};
use common::cover::sample_covers;
use common::mesh::Mesh;
use common::relight::surface::TexelSurfaces;
use common::resample::halve_even;
use common::scene::{Face, Scene};
use common::settings::Settings;
use common::texel::{first_texels, texel_count};
use common::{Error, Result};
use cpu::hierarchy::linker::LinkMethod;
use cpu::hierarchy::relight::{RoomLight, gather_irradiance, relight};
use cpu::hierarchy::shot_log;
use cpu::hierarchy::solver::open_shares;
use cpu::hierarchy::solver::{ErrorBudget, TexelSolution, solve_with_links};
use cpu::ray_cast::relight::relight_by_rays;
use cpu::ray_cast::{MAX_BOUNCES, solve_emission_by_rays};
use glam::{DVec3, Vec3, Vec4};
use std::f64::consts::SQRT_2;

/// Goal of the capture's irradiance, as a share of the requested error: that of the second step.
const CAPTURE_GOAL_SHARE: f64 = 0.5;
/// Visible step of the change within four texels, as a share of the RMS of the reflected light.
const VISIBLE_CHANGE: f64 = 0.02;
/// Least noise of a step, as a share of the requested error.
const MIN_NOISE_SHARE: f64 = 0.7;
/// Noise of the first step, which only shows where texels are too large, as a multiple of the requested error.
const FIRST_NOISE: f64 = 4.0;
/// Standard deviations of the noise that count as no edge of a shadow.
const NOISE_DEVIATIONS: f64 = 4.0;
/// Extent of the objects over the width of the texels that show their shadows.
const TEXELS_PER_OBJECT: f64 = 50.0;
/// Largest number of texels of a face.
const MAX_FACE_TEXELS: u32 = 512 * 512;
/// Largest number of texels of the scene after refinement at shadows.
const MAX_SHADOW_TEXELS: u64 = 1 << 19;

/// The result of a step.
pub struct RelightStep {
    step: SolveStep,
    /// B₀ of each texel.
    before: Vec<Vec3>,
    /// B of each texel.
    radiosity: Vec<Vec3>,
    /// Number of texels that were recognised as emitters.
    emitters: usize,
}

impl AsRef<SolveStep> for RelightStep {
    fn as_ref(&self) -> &SolveStep {
        &self.step
    }
}

/// A relight to be solved in steps.
struct AdaptiveRelight<'a> {
    stage: &'a RelightStage,
    solve_everything: bool,
    requested_texels: Option<u32>,
    /// Requested error.
    error: f64,
    /// H₀ of the open part of each texel of a captured room.
    received: Option<Vec<Vec3>>,
    /// Method that finds links.
    method: LinkMethod<'a>,
    progress: &'a ProgressMonitor<'a>,
}

/// The captured room on the texels of a step.
struct CapturedTexels {
    values: CapturedValues,
    /// H₀, the mean over each texel's area.
    irradiance: Vec<Vec3>,
    open: Vec<f32>,
}

/// Relights `stage` with links found by `method`, until two successive solutions differ by less than the error
/// of `target`. With `solve_everything` the whole scene is solved instead of the change.
///
/// Errors: [`Error::Interrupted`] before the first step is done.
pub fn relight_adaptively(
    stage: &RelightStage,
    solve_everything: bool,
    settings: &Settings,
    target: ErrorTarget,
    method: LinkMethod,
    progress: &ProgressMonitor,
) -> Result<Solved> {
    let problem = AdaptiveRelight {
        received: progress.time_phase("capture", || receive_captured(stage, target.error, method, progress))?,
        stage,
        solve_everything,
        requested_texels: target.texels,
        error: target.error,
        method,
        progress,
    };
    let (relit, history) = RefinementSteps::solve_first(&problem, target.error)?.solve_rest()?;
    let solved_texels = relit.step.resolutions.clone();
    let RelightStep {
        step,
        before,
        radiosity,
        emitters,
    } = problem.resample_to_request(relit)?;
    let mut mesh = step.mesh;
    sample_covers(&mut mesh, ESCAPE_POINTS);
    shot_log::set_open_shares(&mut mesh, &step.outcome);
    let mut run = shot_log::record_run(&mesh, &step.outcome, &shot_log::measure_escape(&mesh, &step.outcome));
    // B₀ + ρΔH, not E + ρH: unchanged texels keep their bits.
    run.field.radiosity = extend_to_vec4(&radiosity);
    let report = RelightReport::new(extend_to_vec4(&before), emitters, &mesh, &run);
    Ok(Solved {
        // Means over other texels differ from these texels' own shares.
        open: (step.resolutions == solved_texels).then_some(step.outcome.open),
        history: Some(history),
        relight: Some(report),
        ..Solved::new(settings, mesh, run)
    })
}

impl AdaptiveProblem for AdaptiveRelight<'_> {
    type StepResult = RelightStep;

    fn scene(&self) -> &Scene {
        &self.stage.scene
    }

    fn solve_step(&self, texels: Vec<[u32; 2]>, goal: f64, last: Option<&RelightStep>) -> Result<RelightStep> {
        let faces = &self.stage.scene.faces;
        let off = last.map_or(Vec::new(), |last| last.step.coarse_error(faces, &texels, goal));
        let phase = format!("relighting to {:.2} %", 100.0 * goal);
        let least = if last.is_some() { MIN_NOISE_SHARE } else { FIRST_NOISE };
        let noise = noise_on_texels(
            &self.stage.scene,
            goal.max(least * self.error),
            &|f| self.requested_texels(f),
            &texels,
        ) as f32;
        let captured = self
            .progress
            .time_phase("capture", || self.capture_room(&texels, goal, noise))?;
        let goal = ErrorBudget::for_error(goal as f32);
        let by_rays = follows_rays(&self.stage.scene, self.error, self.method);
        let stage = self.stage;
        let mut mesh = Mesh::new(&stage.scene, &texels, 1)?;
        mesh.room_faces = stage.room_faces as u32;
        let room = captured.values.apply_to_mesh(&mut mesh, stage.reflectance);
        let mut irradiance = captured.irradiance;
        irradiance.resize(mesh.texels.len(), Vec3::ZERO);
        let surface = TexelSurfaces::recover_surfaces(&mesh, &room, &extend_to_vec4(&irradiance));
        for (k, texel) in mesh.texels.iter_mut().enumerate() {
            texel.reflectance = surface.reflectance[k];
            texel.emission = surface.emission[k];
        }
        let before: Vec<Vec3> = room.radiosity.iter().map(|b| b.truncate()).collect();
        let (outcome, change) = self.progress.time_phase("relight", || {
            let mut callback = step_progress(self.progress, &phase);
            if self.solve_everything {
                let outcome = match by_rays {
                    true => solve_emission_by_rays(&stage.scene, &mesh, MAX_BOUNCES, 0, noise, &mut callback)?,
                    false => solve_with_links(&stage.scene, &mesh, &off, goal, self.method, &mut callback)?,
                };
                return Ok::<_, Error>((outcome, None));
            }
            let mut share = captured.open;
            share.resize(mesh.texels.len(), 1.0);
            let open_only = |(h, open): (&Vec3, &f32)| divide_by_open(*h, *open);
            let received: Vec<Vec3> = irradiance.iter().zip(&share).map(open_only).collect();
            let open_radiosity: Vec<Vec3> = (0..mesh.texels.len())
                .map(|k| surface.emission[k] + surface.reflectance[k] * received[k])
                .collect();
            let known = RoomLight {
                radiosity: &open_radiosity,
                irradiance: &received,
                open: &share,
            };
            let found = match by_rays {
                true => {
                    let blocks = self.receiver_blocks(&mesh, last);
                    relight_by_rays(&stage.scene, &mesh, &known, blocks, noise, &mut callback)?
                }
                false => relight(&stage.scene, &mesh, &known, &off, (goal, self.method), &mut callback)?,
            };
            let whole = irradiance.iter().zip(&found.irradiance);
            let outcome = TexelSolution {
                irradiance: whole.map(|(h, change)| *h + *change).collect(),
                ..found
            };
            Ok((outcome, Some(found.irradiance)))
        })?;
        let radiosity = |(k, texel): (usize, &common::mesh::Texel)| match &change {
            Some(change) if !mesh.is_object(texel.face) => before[k] + texel.reflectance * change[k],
            _ => texel.emission + texel.reflectance * outcome.irradiance[k],
        };
        let radiosity: Vec<Vec3> = mesh.texels.iter().enumerate().map(radiosity).collect();
        Ok(RelightStep {
            before,
            emitters: surface.emitters.len(),
            step: SolveStep::new(texels, mesh, outcome).with_radiosity(&radiosity),
            radiosity,
        })
    }

    fn requested_texels(&self, face: usize) -> Option<[u32; 2]> {
        self.requested_texels.map(|_| self.stage.resolutions[face])
    }

    /// Captured faces keep their texels.
    fn fixed_texels(&self, face: usize) -> Option<[u32; 2]> {
        let captured = &self.stage.captured;
        let fixed = captured.values.is_some() && face < self.stage.room_faces;
        fixed.then(|| captured.resolutions[face])
    }

    fn least_resolution(&self, first: &RelightStep) -> Vec<[u32; 2]> {
        match self.requested_texels {
            Some(_) => Vec::new(),
            None => self.shadow_resolution(first),
        }
    }
}

impl AdaptiveRelight<'_> {
    /// Resamples the result to the requested texels: means over their areas.
    fn resample_to_request(&self, relit: RelightStep) -> Result<RelightStep> {
        let (faces, step) = (&self.stage.scene.faces, &relit.step);
        let texels: Vec<[u32; 2]> = (0..faces.len())
            .map(|f| self.requested_texels(f).unwrap_or(step.resolutions[f]))
            .collect();
        if texels == step.resolutions {
            return Ok(relit);
        }
        let mean =
            |of: &dyn Fn(usize) -> Vec3| narrow_to_f32(resample_step(faces, step, &texels, &|k| of(k).as_dvec3()));
        let mut mesh = Mesh::new(&self.stage.scene, &texels, 1)?;
        mesh.room_faces = self.stage.room_faces as u32;
        let reflectance = mean(&|k| step.mesh.texels[k].reflectance);
        let emission = mean(&|k| step.mesh.texels[k].emission);
        for (k, texel) in mesh.texels.iter_mut().enumerate() {
            (texel.reflectance, texel.emission) = (reflectance[k], emission[k]);
        }
        let open = mean(&|k| Vec3::splat(step.outcome.open[k]));
        let outcome = TexelSolution {
            irradiance: mean(&|k| step.outcome.irradiance[k]),
            residual: mean(&|k| step.outcome.residual[k]),
            open: open.iter().map(|open| open.x).collect(),
            coarse_error: Vec::new(),
            removed: Vec::new(),
            direct: Vec::new(),
            noise: mean(&|k| step.outcome.noise[k]),
            ..step.outcome
        };
        Ok(RelightStep {
            before: mean(&|k| relit.before[k]),
            radiosity: mean(&|k| relit.radiosity[k]),
            emitters: relit.emitters,
            step: SolveStep::new(texels, mesh, outcome),
        })
    }

    /// Captures the room on `texels` of each face.
    fn capture_room(&self, texels: &[[u32; 2]], goal: f64, noise: f32) -> Result<CapturedTexels> {
        let scene = &self.stage.captured.scene;
        let own = &texels[..self.stage.room_faces];
        let mesh = Mesh::new(scene, own, 1)?;
        let (Some(values), Some(received)) = (&self.stage.captured.values, &self.received) else {
            let mut callback = step_progress(self.progress, "capture");
            let found = match follows_rays(scene, self.error, self.method) {
                true => solve_emission_by_rays(scene, &mesh, MAX_BOUNCES, 0, noise, &mut callback)?,
                false => {
                    let goal = ErrorBudget::for_error(goal as f32);
                    solve_with_links(scene, &mesh, &[], goal, self.method, &mut callback)?
                }
            };
            let texels = mesh.texels.iter().zip(&found.irradiance);
            return Ok(CapturedTexels {
                values: CapturedValues {
                    radiosity: texels.map(|(t, h)| t.emission + t.reflectance * *h).collect(),
                    residual: None,
                    reflectance: Some(mesh.texels.iter().map(|t| t.reflectance).collect()),
                    emission: Some(mesh.texels.iter().map(|t| t.emission).collect()),
                },
                irradiance: found.irradiance,
                open: found.open,
            });
        };
        let (faces, from) = (&scene.faces, &self.stage.captured.resolutions);
        let open = open_shares(scene, &mesh);
        let irradiance = spread_to_parts(received, faces, from, own);
        Ok(CapturedTexels {
            values: values.resample_to(faces, from, own),
            irradiance: irradiance.iter().zip(&open).map(|(h, open)| *h * *open).collect(),
            open,
        })
    }

    /// Returns the sizes of the blocks of texels that receive by the same rays: all single in the first step.
    fn receiver_blocks(&self, mesh: &Mesh, last: Option<&RelightStep>) -> Vec<[u32; 2]> {
        let Some(last) = last else {
            return vec![[1; 2]; mesh.texels.len()];
        };
        let changes = last.radiosity.iter().zip(&last.before).map(|(b, before)| *b - *before);
        let changes: Vec<Vec3> = changes.collect();
        let before = (&changes[..], &last.step.resolutions[..]);
        choose_block_sizes(&self.stage.scene.faces, mesh, before, visible_change(&last.step))
    }

    /// Texels of the room's faces for the objects' shadows: as small as [`TEXELS_PER_OBJECT`] demands
    /// where an edge of the change is visible; 0 elsewhere.
    fn shadow_resolution(&self, first: &RelightStep) -> Vec<[u32; 2]> {
        let (stage, step) = (self.stage, &first.step);
        let starts = first_texels(&step.resolutions);
        let visible = visible_change(step);
        let width = largest_extent(&stage.scene.faces[stage.room_faces..]) / TEXELS_PER_OBJECT;
        let mut texels = vec![[0; 2]; step.resolutions.len()];
        let mut all = count_texels(&step.resolutions);
        for (f, face) in stage.scene.faces.iter().enumerate().take(stage.room_faces) {
            let range = starts[f]..starts[f + 1];
            let changes: Vec<DVec3> = range
                .clone()
                .map(|k| (first.radiosity[k] - first.before[k]).as_dvec3())
                .collect();
            let mut own = step.resolutions[f];
            let wide = halve_even(own);
            let smooth = resample_face(&resample_face(&changes, face, own, wide), face, wide, own);
            let variance = step.noise[range.clone()]
                .iter()
                .map(|d| (*d * *d).max_element())
                .sum::<f64>()
                / range.len() as f64;
            let edges = changes.iter().zip(&smooth).map(|(a, b)| (*a - *b).abs().max_element());
            if edges.fold(0.0, f64::max) < visible + NOISE_DEVIATIONS * variance.sqrt() {
                continue;
            }
            let lengths = face.grid_lengths();
            // As near to that width as halving allows.
            while (0..2).any(|k| lengths[k] / f64::from(own[k]) > SQRT_2 * width) {
                let halved = face.halve_texels(own);
                let more = u64::from(texel_count(halved) - texel_count(own));
                if texel_count(halved) > MAX_FACE_TEXELS || all + more > MAX_SHADOW_TEXELS {
                    break;
                }
                all += more;
                own = halved;
            }
            texels[f] = own;
        }
        texels
    }
}

/// Returns the change of B from texel to texel that is visible in a picture of `step`, W/m².
fn visible_change(step: &SolveStep) -> f64 {
    let (mut square, mut area) = (0.0, 0.0);
    for (texel, light) in step.mesh.texels.iter().zip(&step.reflected) {
        square += f64::from(texel.area) * light.max_element().powi(2);
        area += f64::from(texel.area);
    }
    VISIBLE_CHANGE * (square / area).sqrt()
}

/// Returns H₀ of the open part of each texel of a captured room.
fn receive_captured(
    stage: &RelightStage,
    error: f64,
    method: LinkMethod,
    progress: &ProgressMonitor,
) -> Result<Option<Vec<Vec3>>> {
    let captured = &stage.captured;
    let Some(values) = &captured.values else {
        return Ok(None);
    };
    let mut mesh = Mesh::new(&captured.scene, &captured.resolutions, 1)?;
    let received = match (&values.reflectance, &values.emission, stage.reflectance) {
        (Some(rho), Some(emission), None) => {
            let received = |k: usize| {
                let reflected = values.radiosity[k] - emission[k];
                Vec3::select(rho[k].cmpgt(Vec3::ZERO), reflected / rho[k], Vec3::ZERO)
            };
            (0..rho.len()).map(received).collect()
        }
        _ => {
            let mut callback = step_progress(progress, "capture");
            let goal = (CAPTURE_GOAL_SHARE * error) as f32;
            if follows_rays(&captured.scene, error, method) {
                for (texel, radiosity) in mesh.texels.iter_mut().zip(&values.radiosity) {
                    (texel.emission, texel.reflectance) = (*radiosity, Vec3::ONE);
                }
                solve_emission_by_rays(&captured.scene, &mesh, 0, 0, goal, &mut callback)?.irradiance
            } else {
                let budget = ErrorBudget::for_error(goal);
                gather_irradiance(
                    &captured.scene,
                    &mesh,
                    &values.radiosity,
                    (budget, method),
                    &mut callback,
                )?
            }
        }
    };
    let open = open_shares(&captured.scene, &mesh);
    Ok(Some(
        received
            .iter()
            .zip(open)
            .map(|(h, open)| divide_by_open(*h, open))
            .collect(),
    ))
}

/// Returns the mean over a texel's open part of what has the mean `h` over its area.
fn divide_by_open(h: Vec3, open: f32) -> Vec3 {
    if open > 0.0 { h / open } else { Vec3::ZERO }
}

/// Resamples values to other texels, which are parts of these.
fn spread_to_parts(values: &[Vec3], faces: &[Face], from: &[[u32; 2]], to: &[[u32; 2]]) -> Vec<Vec3> {
    let starts = first_texels(from);
    let each = faces.iter().enumerate().flat_map(|(f, face)| {
        let own = &values[starts[f]..starts[f + 1]];
        let wide: Vec<_> = own.iter().map(|v| v.as_dvec3()).collect();
        resample_face(&wide, face, from[f], to[f])
    });
    each.map(|v| v.as_vec3()).collect()
}

impl CapturedValues {
    /// Resamples the values to other texels, which are parts of these.
    fn resample_to(&self, faces: &[Face], from: &[[u32; 2]], to: &[[u32; 2]]) -> Self {
        let spread = |values: &Vec<Vec3>| spread_to_parts(values, faces, from, to);
        Self {
            radiosity: spread(&self.radiosity),
            residual: None,
            reflectance: self.reflectance.as_ref().map(spread),
            emission: self.emission.as_ref().map(spread),
        }
    }
}

/// Longest side of the box around faces.
fn largest_extent(faces: &[Face]) -> f64 {
    let corners = || faces.iter().flat_map(Face::outline);
    let high = corners().fold(DVec3::NEG_INFINITY, |high, c| high.max(*c));
    let low = corners().fold(DVec3::INFINITY, |low, c| low.min(*c));
    (high - low).max_element()
}

fn extend_to_vec4(values: &[Vec3]) -> Vec<Vec4> {
    values.iter().map(|v| v.extend(0.0)).collect()
}
