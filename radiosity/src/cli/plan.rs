//! `--dry-run` of `solve` and `shoot`, and the earlier command `plan`.

use super::Outcome;
use super::console::{message, print_json, print_line};
use super::options::{CommonOptions, general_settings, parse_error, scene_settings, visibility_in_force};
use super::progress::{Progress, read_with_progress};
use super::scene::{DarkOption, MaterialOptions};
use super::solver::{SolverOption, choose_solver_for_error};
use crate::plan::SceneCounts;
use crate::plan::forecast::{forecast_solve, format_duration};
use crate::plan::memory::SolveMemory;
use crate::plan::memory_limit::{MemoryLimit, check_dense_memory, check_memory, check_texels, format_bytes};
use crate::plan::passes::ExpectedPasses;
use crate::report::format::format_count;
use clap::Args;
use common::form_factor::FormFactor;
use common::scene::Scene;
use common::settings::{Iteration, Settings, Visibility};
use common::{Error, Result};
use cpu::dense::memory;
use gpu::Gpu;
use oracle::solve::progress::ProgressMonitor;
use oracle::solve::solver::{ErrorTarget, SolverChoice};
use oracle::solve::task::SolveTask;
use serde_json::{Value, json};
use std::fmt;
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::time::Instant;

/// Error of the trial solve from which the time of a solve to a lower error is extrapolated.
const TRIAL_ERROR: f64 = 0.1;
/// Exponent of 1/error in the time: five scenes of 17 to 10 133 faces took 7 to 16 times as long for a tenth of
/// the error.
const TIME_EXPONENT: f64 = 1.0;
/// Largest factor, either way, between time and extrapolation for 2 %.
const TIME_UNCERTAINTY: f64 = 3.0;

/// Seconds after which the trial solve is stopped.
const MAX_TRIAL_SECONDS: f64 = 20.0;

/// Arguments of `plan`.
#[derive(Args)]
pub struct PlanArguments {
    /// An .obj (with its .mtl), a .gltf or a .glb
    scene: PathBuf,
    /// Only this solver [default: the CPU, and the GPU where there is an adapter]
    #[arg(long, value_enum)]
    solver: Option<SolverOption>,
    /// Plan a solve to this error, 0.2 to 10 % [default: 1, unless an option of shooting is given]
    #[arg(long, value_name = "P%", value_parser = parse_error, allow_negative_numbers = true)]
    error: Option<f64>,
    /// Print the plan as one line of JSON, times in seconds and memory in bytes
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    materials: MaterialOptions,
    #[command(flatten)]
    dark: DarkOption,
    #[command(flatten)]
    common: CommonOptions,
}

/// Output of a plan: lines for people as they are found, or JSON at the end.
struct PlanOutput {
    json: bool,
}

impl PlanOutput {
    /// Prints a line unless the output is JSON.
    fn print_line(&self, line: fmt::Arguments) -> Result<()> {
        if self.json { Ok(()) } else { print_line(line) }
    }
}

/// Estimates the cost of a solve and prints it.
pub fn run(arguments: &PlanArguments) -> Result<Outcome> {
    let common = &arguments.common;
    message!("note: `radiosity plan` is `radiosity solve --dry-run` now, or `radiosity shoot --dry-run`");
    if arguments.error.is_some() {
        choose_solver_for_error(arguments.solver, common)?;
        common.refuse_shooting_options()?;
    } else if arguments.solver == Some(SolverOption::Cpu) {
        common.refuse_gpu_options()?;
    }
    if arguments.solver != Some(SolverOption::Dense) {
        let visibility = visibility_in_force(common, arguments.solver != Some(SolverOption::Cpu));
        common.refuse_item_buffer_options(visibility)?;
    }
    let (materials, path) = (&arguments.materials, &arguments.scene);
    let scene = read_with_progress(path, common.quiet, || {
        materials.load_scene_unless_dark(&arguments.dark, path, common.import_options())
    })?;
    let error = arguments.error.or(common.quality_error());
    print_plan(&scene, arguments.solver, error, common, arguments.json)
}

/// Estimates the cost of a solve to `error`, or of shooting, and prints it; without a solver, of all that there are.
pub fn print_plan(
    scene: &Scene,
    solver: Option<SolverOption>,
    error: Option<f64>,
    common: &CommonOptions,
    json: bool,
) -> Result<Outcome> {
    let output = PlanOutput { json };
    let plans = plan_solvers(scene, solver, error, common, &output)?;
    if json {
        let name = &scene.name;
        print_json(&json!({ "scene": name, "faces": scene.faces.len(), "plans": plans }))?;
    }
    Ok(Outcome::Done)
}

/// Plans a solve for each solver selected.
fn plan_solvers(
    scene: &Scene,
    solver: Option<SolverOption>,
    error: Option<f64>,
    common: &CommonOptions,
    output: &PlanOutput,
) -> Result<Vec<Value>> {
    if solver == Some(SolverOption::Dense) {
        common.refuse_dense_conflicts()?;
        return Ok(vec![plan_dense(scene, &general_settings(common, false)?, output)?]);
    }
    let mut plans = Vec::new();
    if solver != Some(SolverOption::Gpu) {
        plans.push(plan_solver(scene, common, error, None, output)?);
    }
    if solver != Some(SolverOption::Cpu) {
        match Gpu::open(common.adapter.as_deref()) {
            Ok(gpu) => plans.push(plan_solver(scene, common, error, Some(&gpu), output)?),
            Err(Error::NoAdapter(_)) if solver.is_none() && common.adapter.is_none() && !common.require_gpu => {
                output.print_line(format_args!(""))?;
                output.print_line(format_args!("GPU: no adapter"))?;
            }
            Err(error) => return Err(error),
        }
    }
    Ok(plans)
}

/// Describes solver and adapter in JSON.
fn describe_solver(gpu: Option<&Gpu>) -> Value {
    let solver = if gpu.is_some() { "gpu" } else { "cpu" };
    json!({ "solver": solver, "adapter": gpu.map(|gpu| &gpu.line.name) })
}

/// Adds the entries of `more` to `plan`.
fn add_entries(mut plan: Value, more: Value) -> Value {
    if let (Some(plan), Value::Object(more)) = (plan.as_object_mut(), more) {
        plan.extend(more);
    }
    plan
}

/// Plans a solve to `error` from a trial solve to [`TRIAL_ERROR`].
fn plan_to_error(
    scene: &Scene,
    common: &CommonOptions,
    error: f64,
    gpu: Option<&Gpu>,
    output: &PlanOutput,
) -> Result<Value> {
    let plan = add_entries(describe_solver(gpu), json!({ "error": error, "texels": common.texels }));
    output.print_line(format_args!(""))?;
    let name = &scene.name;
    output.print_line(format_args!("{name}, {}, to {} %", solver_name(gpu), 100.0 * error))?;
    let side = common
        .texels
        .map_or("texels chosen by the solve".into(), |n| format!("{n}×{n} texels each"));
    let faces = format_count(scene.faces.len() as u64);
    output.print_line(format_args!("  size    {faces} faces, {side}"))?;
    let limit = MemoryLimit::of_this_machine();
    if let Err(error) = check_texels(scene, common.texels.unwrap_or(1), limit) {
        return refuse_plan(plan, &error, output);
    }
    let target = ErrorTarget {
        error: TRIAL_ERROR,
        texels: common.texels,
    };
    let settings = common.shot_settings(Visibility::Rays, FormFactor::Polygon)?;
    let progress = Progress::new("plan", common.quiet);
    let (seconds, links) = trial_solve(
        scene,
        &settings,
        SolverChoice::to_error(gpu, target),
        &progress,
        MAX_TRIAL_SECONDS,
    )?;
    progress.clear();
    Ok(add_entries(plan, extrapolate_time(error, seconds, links, output)?))
}

/// Solves to [`TRIAL_ERROR`]; returns seconds and links, or no links if it was stopped after `patience` seconds.
fn trial_solve(
    scene: &Scene,
    settings: &Settings,
    solver: SolverChoice,
    progress: &Progress,
    patience: f64,
) -> Result<(f64, Option<u64>)> {
    let _ = progress.show_phase("prepare", 0.0);
    let start = Instant::now();
    let show = |phase: &str, done| match start.elapsed().as_secs_f64() > patience {
        true => ControlFlow::Break(()),
        false => progress.show_phase(phase, done),
    };
    let watch = ProgressMonitor::new(&show);
    let solved = scene.solve_once(settings, solver, &watch);
    let seconds = start.elapsed().as_secs_f64();
    if watch.is_stopped() {
        return Ok((seconds, None));
    }
    let links = solved?.history.map_or(0, |moved| moved.links);
    Ok((seconds, Some(links)))
}

/// Extrapolates the time of a solve to `error` from one to [`TRIAL_ERROR`] that took `seconds`.
fn extrapolate_time(error: f64, seconds: f64, links: Option<u64>, output: &PlanOutput) -> Result<Value> {
    let expected = seconds * (TRIAL_ERROR / error).powf(TIME_EXPONENT);
    let Some(links) = links else {
        let (least, spent) = (format_duration(expected), format_duration(seconds));
        output.print_line(format_args!(
            "  time    more than {least} (not done to {} % in {spent})",
            100.0 * TRIAL_ERROR
        ))?;
        return Ok(json!({ "seconds": { "least": expected } }));
    };
    let [least, most] = [expected / TIME_UNCERTAINTY, expected * TIME_UNCERTAINTY];
    output.print_line(format_args!(
        "  time    about {}, between {} and {} ({} links to {} % took {})",
        format_duration(expected),
        format_duration(least),
        format_duration(most),
        format_count(links),
        100.0 * TRIAL_ERROR,
        format_duration(seconds)
    ))?;
    Ok(json!({ "seconds": describe_time(expected, least, most) }))
}

/// Describes a time with its bounds in JSON.
fn describe_time(expected: f64, least: f64, most: f64) -> Value {
    json!({ "expected": expected, "least": least, "most": most })
}

/// Completes a plan that does not fit, with the reason.
fn refuse_plan(plan: Value, why: &Error, output: &PlanOutput) -> Result<Value> {
    output.print_line(format_args!("  refused {why}"))?;
    Ok(add_entries(plan, json!({ "refused": why.to_string() })))
}

/// Names the solver for people.
fn solver_name(gpu: Option<&Gpu>) -> String {
    gpu.map_or("CPU".into(), |gpu| format!("GPU, {}", gpu.line.name))
}

/// Plans a solve by one solver: to `error`, or by shooting.
fn plan_solver(
    scene: &Scene,
    common: &CommonOptions,
    error: Option<f64>,
    gpu: Option<&Gpu>,
    output: &PlanOutput,
) -> Result<Value> {
    if let Some(error) = error {
        return plan_to_error(scene, common, error, gpu, output);
    }
    let (settings, changed) = scene_settings(common, scene, gpu.is_some())?;
    let settings = &settings;
    let counts = SceneCounts::new(scene, &settings.meshing);
    output.print_line(format_args!(""))?;
    output.print_line(format_args!("{}, {}", scene.name, solver_name(gpu)))?;
    output.print_line(format_args!(
        "  size    {} faces, {} texels, {} patches; {} links of {} samples",
        format_count(counts.faces),
        format_count(counts.texels),
        format_count(counts.patches),
        format_count(counts.link_count()),
        settings.meshing.samples
    ))?;
    if let Some(changed) = &changed {
        output.print_line(format_args!("  note    {changed}"))?;
    }
    let memory = match gpu {
        None => SolveMemory::on_cpu(&counts, settings),
        Some(gpu) => SolveMemory::on_gpu(gpu, &counts, settings),
    };
    let limit = MemoryLimit::of_this_machine();
    output.print_line(format_args!(
        "  memory  {}: scene {}, mesh {}, state {}, links {} at most, afterwards {} ({} {})",
        format_bytes(memory.peak_bytes()),
        format_bytes(memory.scene),
        format_bytes(memory.mesh),
        format_bytes(memory.state),
        format_bytes(memory.links),
        format_bytes(memory.estimate),
        format_bytes(limit.bytes),
        limit.source
    ))?;
    let found = json!({
        "texels": counts.texels, "cells": counts.patches, "links": counts.link_count(),
        "samples": settings.meshing.samples, "note": changed, "bytes": memory.peak_bytes(),
    });
    let plan = add_entries(describe_solver(gpu), found);
    if let Err(error) = check_memory(scene, settings, gpu, limit) {
        return refuse_plan(plan, &error, output);
    }
    Ok(add_entries(plan, estimate_time(scene, settings, gpu, output)?))
}

/// Estimates passes and time from a short trial.
fn estimate_time(scene: &Scene, settings: &Settings, gpu: Option<&Gpu>, output: &PlanOutput) -> Result<Value> {
    let ahead = forecast_solve(scene, settings, SolverChoice::shooting_on(gpu))?;
    output.print_line(format_args!("  passes  {}", describe_passes(settings, &ahead.expected)))?;
    let (prepare, time) = (ahead.prepare, &ahead.time);
    let expected = ahead.total_seconds();
    let least = prepare + time.total_seconds() / time.factor;
    let most = prepare + time.total_seconds() * time.factor;
    output.print_line(format_args!(
        "  time    about {}, between {} and {}: prepare {}, links {}, passes {} ({} patches tried)",
        format_duration(expected),
        format_duration(least),
        format_duration(most),
        format_duration(prepare),
        format_duration(time.links),
        format_duration(time.passes + time.gather),
        time.tried
    ))?;
    let (passes, shots) = (ahead.expected.passes, ahead.expected.shots);
    Ok(json!({ "passes": passes, "shots": shots, "seconds": describe_time(expected, least, most) }))
}

/// Describes passes and shots for people.
fn describe_passes(settings: &Settings, expected: &ExpectedPasses) -> String {
    let (passes, shots) = (
        format_count(expected.passes.round() as u64),
        format_count(expected.shots.round() as u64),
    );
    let name = format!("{:?}", settings.schedule.iteration).to_lowercase();
    let what = match settings.schedule.iteration {
        Iteration::Southwell => format!("{shots} shots"),
        _ => format!("{passes} passes, {shots} shots"),
    };
    match expected.small_side {
        Some(side) => format!("about {what} by {name} (a solve on {side}×{side} texels a face)"),
        None => format!("at most {what} by {name} (a bound of the largest reflectance)"),
    }
}

/// Plans a solve by the dense solver.
fn plan_dense(scene: &Scene, settings: &Settings, output: &PlanOutput) -> Result<Value> {
    let counts = SceneCounts::new(scene, &settings.meshing);
    output.print_line(format_args!(""))?;
    output.print_line(format_args!("{}, dense system", scene.name))?;
    output.print_line(format_args!(
        "  size    {} faces, {} texels, {} pairs",
        format_count(counts.faces),
        format_count(counts.texels),
        format_count(counts.texels.saturating_mul(counts.texels))
    ))?;
    let bytes = memory::matrix_bytes(counts.texels);
    output.print_line(format_args!(
        "  memory  {} ({} are allowed)",
        format_bytes(bytes),
        format_bytes(memory::MAX_MATRIX_BYTES)
    ))?;
    let plan = json!({ "solver": "dense", "texels": counts.texels, "bytes": bytes });
    match check_dense_memory(scene, settings.meshing.texels) {
        Err(error) => refuse_plan(plan, &error, output),
        Ok(()) => Ok(plan),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DVec3, Vec3};

    #[test]
    fn a_look_is_given_up_and_tells_at_least_how_long() {
        let plate = |y: f64, emission: f32| {
            let corners = [[0.0, 0.0], [0.0, 1.0], [1.0, 1.0], [1.0, 0.0]];
            let mut corners = corners.map(|[x, z]| DVec3::new(x, y, z));
            if y > 0.0 {
                corners.reverse();
            }
            let emission = Vec3::splat(emission);
            common::scene::Face::quad("plate", corners, emission, Vec3::splat(0.5))
        };
        let scene = Scene {
            name: "plates".into(),
            faces: vec![plate(0.0, 0.0), plate(1.0, 1.0)],
            notes: Vec::new(),
        };
        let target = ErrorTarget {
            error: TRIAL_ERROR,
            texels: None,
        };
        let look = |patience| {
            let (settings, progress) = (Settings::default(), Progress::new("plan", true));
            let solver = SolverChoice::to_error(None, target);
            trial_solve(&scene, &settings, solver, &progress, patience).unwrap()
        };
        let output = PlanOutput { json: true };
        let (seconds, links) = look(f64::INFINITY);
        assert!(links.is_some_and(|links| links > 0), "{links:?}");
        let extrapolate = |seconds, links| extrapolate_time(TRIAL_ERROR / 10.0, seconds, links, &output).unwrap();
        let plan = extrapolate(seconds, links);
        assert_eq!(plan["seconds"]["expected"], 10.0 * seconds);
        assert!(plan["seconds"]["least"].as_f64() < Some(10.0 * seconds));
        let (seconds, links) = look(0.0);
        assert_eq!(links, None);
        let plan = extrapolate(seconds, links);
        assert_eq!(plan["seconds"], json!({ "least": 10.0 * seconds }));
    }
}
