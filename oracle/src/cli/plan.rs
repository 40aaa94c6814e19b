//! `radiosity plan`.

use super::Outcome;
use super::options::Common;
use super::progress::{Progress, reading};
use super::scene::{Dark, Materials};
use super::solve::{error, settings, settings_for, to_error as solve_to_error, visibility};
use super::solver::SolverOption;
use super::tell::{json, print};
use crate::plan::Counts;
use crate::plan::ahead::{ahead, long};
use crate::plan::fits::{Limit, check, check_matrix, check_texels, size};
use crate::plan::memory::Memory;
use crate::plan::passes::Expected;
use crate::show::number::count;
use crate::solve::solver::{Asked, Solver};
use crate::solve::task::Task;
use crate::solve::watch::Watch;
use clap::Args;
use common::form_factor::FormFactor;
use common::scene::Scene;
use common::settings::{Iteration, Settings, Visibility};
use common::{Error, Result};
use cpu::matrix::memory;
use gpu::Gpu;
use serde_json::{Value, json};
use std::fmt;
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::time::Instant;

/// The error of the solve that tells how long one to a lower error takes.
const LOOK: f64 = 0.1;
/// Seconds grow by this power of 1/error: five scenes of 17 to 10 133 faces took 7 to 16 times as long for
/// a tenth of it.
const STEEP: f64 = 1.0;
/// For 2 % they took so many times less or more at most.
const DOUBT: f64 = 3.0;

/// Seconds after which that is given up: a plan that takes minutes is none.
const PATIENCE: f64 = 20.0;

/// Arguments of `plan`.
#[derive(Args)]
pub struct Arguments {
    /// An .obj (with its .mtl), a .gltf or a .glb
    scene: PathBuf,
    /// Only this solver [default: the CPU, and the GPU where there is an adapter]
    #[arg(long, value_enum)]
    solver: Option<SolverOption>,
    /// A solve to this error, 0.2 to 10 % [default: 1, unless an option below asks for shooting]
    #[arg(long, value_name = "P%", value_parser = error, allow_negative_numbers = true)]
    error: Option<f64>,
    /// The same as one line of JSON on stdout, times in seconds and memory in bytes
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    materials: Materials,
    #[command(flatten)]
    dark: Dark,
    #[command(flatten)]
    common: Common,
}

/// Who reads the plan: a person, line by line as it is found, or a program, all at once.
struct Told {
    json: bool,
}

impl Told {
    /// A line for a person.
    fn line(&self, line: fmt::Arguments) -> Result<()> {
        if self.json { Ok(()) } else { print(line) }
    }
}

/// Prints what a solve will take.
pub fn run(arguments: &Arguments) -> Result<Outcome> {
    let common = &arguments.common;
    if arguments.error.is_some() {
        solve_to_error(arguments.solver, common)?;
        common.not_for_error()?;
    } else if arguments.solver == Some(SolverOption::Cpu) {
        common.not_for_cpu()?;
    }
    if arguments.solver != Some(SolverOption::Matrix) {
        let asked = visibility(common, arguments.solver != Some(SolverOption::Cpu));
        common.not_for_rays(asked)?;
    }
    let (materials, path) = (&arguments.materials, &arguments.scene);
    let scene = reading(path, common.quiet, || {
        materials.lit_unless(&arguments.dark, path, common.import())
    })?;
    let told = Told {
        json: arguments.json,
    };
    let plans = plans(arguments, &scene, &told)?;
    if arguments.json {
        let name = &scene.name;
        json(&json!({ "scene": name, "faces": scene.faces.len(), "plans": plans }))?;
    }
    Ok(Outcome::Done)
}

/// One for each solver that is asked for.
fn plans(arguments: &Arguments, scene: &Scene, told: &Told) -> Result<Vec<Value>> {
    let common = &arguments.common;
    if arguments.solver == Some(SolverOption::Matrix) {
        common.not_for_matrix()?;
        return Ok(vec![matrix(scene, &settings(common, false)?, told)?]);
    }
    let error = arguments.error.or(common.error());
    let mut plans = Vec::new();
    if arguments.solver != Some(SolverOption::Gpu) {
        plans.push(plan(scene, common, error, None, told)?);
    }
    if arguments.solver != Some(SolverOption::Cpu) {
        match Gpu::open(common.adapter.as_deref()) {
            Ok(gpu) => plans.push(plan(scene, common, error, Some(&gpu), told)?),
            Err(Error::NoAdapter(_))
                if arguments.solver.is_none()
                    && common.adapter.is_none()
                    && !common.require_gpu =>
            {
                told.line(format_args!(""))?;
                told.line(format_args!("GPU: no adapter"))?;
            }
            Err(error) => return Err(error),
        }
    }
    Ok(plans)
}

/// Who solves, as JSON has it.
fn who(gpu: Option<&Gpu>) -> Value {
    let solver = if gpu.is_some() { "gpu" } else { "cpu" };
    json!({ "solver": solver, "adapter": gpu.map(|gpu| &gpu.line.name) })
}

/// `plan` with what else is known.
fn with(mut plan: Value, more: Value) -> Value {
    if let (Some(plan), Value::Object(more)) = (plan.as_object_mut(), more) {
        plan.extend(more);
    }
    plan
}

/// What a solve to an error takes, from one to [`LOOK`].
fn to_error(
    scene: &Scene,
    common: &Common,
    error: f64,
    gpu: Option<&Gpu>,
    told: &Told,
) -> Result<Value> {
    let plan = with(who(gpu), json!({ "error": error, "texels": common.texels }));
    told.line(format_args!(""))?;
    let name = &scene.name;
    told.line(format_args!(
        "{name}, {}, to {} %",
        named(gpu),
        100.0 * error
    ))?;
    let side = common
        .texels
        .map_or("as many texels as the light needs".into(), |n| {
            format!("{n}×{n} texels each")
        });
    let faces = count(scene.faces.len() as u64);
    told.line(format_args!("  size    {faces} faces, {side}"))?;
    let limit = Limit::of_this_machine();
    if let Err(error) = check_texels(scene, common.texels.unwrap_or(1), limit) {
        return refused(plan, &error, told);
    }
    let asked = Asked {
        error: LOOK,
        texels: common.texels,
    };
    let settings = common.settings(Visibility::Rays, FormFactor::Polygon)?;
    let progress = Progress::new("plan", common.quiet);
    let (seconds, links) = look(
        scene,
        &settings,
        Solver::to_error(gpu, asked),
        &progress,
        PATIENCE,
    )?;
    progress.clear();
    Ok(with(plan, from_a_look(error, seconds, links, told)?))
}

/// A solve to [`LOOK`]: its seconds and links; no links where it was given up after `patience` seconds.
fn look(
    scene: &Scene,
    settings: &Settings,
    solver: Solver,
    progress: &Progress,
    patience: f64,
) -> Result<(f64, Option<u64>)> {
    let _ = progress.show("prepare", 0.0);
    let start = Instant::now();
    let show = |phase: &str, done| match start.elapsed().as_secs_f64() > patience {
        true => ControlFlow::Break(()),
        false => progress.show(phase, done),
    };
    let watch = Watch::new(&show);
    let solved = scene.once(settings, solver, &watch);
    let seconds = start.elapsed().as_secs_f64();
    if watch.stopped() {
        return Ok((seconds, None));
    }
    let links = solved?.moved.map_or(0, |moved| moved.links);
    Ok((seconds, Some(links)))
}

/// How long a solve to `error` takes where one to [`LOOK`] took so long.
fn from_a_look(error: f64, seconds: f64, links: Option<u64>, told: &Told) -> Result<Value> {
    let expected = seconds * (LOOK / error).powf(STEEP);
    let Some(links) = links else {
        let (least, spent) = (long(expected), long(seconds));
        told.line(format_args!(
            "  time    more than {least} (not done to {} % in {spent})",
            100.0 * LOOK
        ))?;
        return Ok(json!({ "seconds": { "least": expected } }));
    };
    let [least, most] = [expected / DOUBT, expected * DOUBT];
    told.line(format_args!(
        "  time    about {}, between {} and {} ({} links to {} % took {})",
        long(expected),
        long(least),
        long(most),
        count(links),
        100.0 * LOOK,
        long(seconds)
    ))?;
    Ok(json!({ "seconds": span(expected, least, most) }))
}

/// A time as a program reads it.
fn span(expected: f64, least: f64, most: f64) -> Value {
    json!({ "expected": expected, "least": least, "most": most })
}

/// A plan that cannot be carried out, and why.
fn refused(plan: Value, why: &Error, told: &Told) -> Result<Value> {
    told.line(format_args!("  refused {why}"))?;
    Ok(with(plan, json!({ "refused": why.to_string() })))
}

fn named(gpu: Option<&Gpu>) -> String {
    gpu.map_or("CPU".into(), |gpu| format!("GPU, {}", gpu.line.name))
}

fn plan(
    scene: &Scene,
    common: &Common,
    error: Option<f64>,
    gpu: Option<&Gpu>,
    told: &Told,
) -> Result<Value> {
    if let Some(error) = error {
        return to_error(scene, common, error, gpu, told);
    }
    let (settings, changed) = settings_for(common, scene, gpu.is_some())?;
    let settings = &settings;
    let counts = Counts::new(scene, &settings.meshing);
    told.line(format_args!(""))?;
    told.line(format_args!("{}, {}", scene.name, named(gpu)))?;
    told.line(format_args!(
        "  size    {} faces, {} texels, {} cells; {} links of {} samples",
        count(counts.faces),
        count(counts.texels),
        count(counts.cells),
        count(counts.links()),
        settings.meshing.samples
    ))?;
    if let Some(changed) = &changed {
        told.line(format_args!("  note    {changed}"))?;
    }
    let memory = match gpu {
        None => Memory::cpu(&counts, settings),
        Some(gpu) => Memory::gpu(gpu, &counts, settings),
    };
    let limit = Limit::of_this_machine();
    told.line(format_args!(
        "  memory  {}: scene {}, mesh {}, state {}, links {} at most, afterwards {} ({} {})",
        size(memory.bytes()),
        size(memory.scene),
        size(memory.mesh),
        size(memory.state),
        size(memory.links),
        size(memory.look),
        size(limit.bytes),
        limit.source
    ))?;
    let found = json!({
        "texels": counts.texels, "cells": counts.cells, "links": counts.links(),
        "samples": settings.meshing.samples, "note": changed, "bytes": memory.bytes(),
    });
    let plan = with(who(gpu), found);
    if let Err(error) = check(scene, settings, gpu, limit) {
        return refused(plan, &error, told);
    }
    Ok(with(plan, seconds(scene, settings, gpu, told)?))
}

/// Passes and time, from a short trial.
fn seconds(scene: &Scene, settings: &Settings, gpu: Option<&Gpu>, told: &Told) -> Result<Value> {
    let ahead = ahead(scene, settings, Solver::on(gpu))?;
    told.line(format_args!(
        "  passes  {}",
        passes(settings, &ahead.expected)
    ))?;
    let (prepare, time) = (ahead.prepare, &ahead.time);
    let expected = ahead.seconds();
    let least = prepare + time.seconds() / time.factor;
    let most = prepare + time.seconds() * time.factor;
    told.line(format_args!(
        "  time    about {}, between {} and {}: prepare {}, links {}, passes {} ({} cells tried)",
        long(expected),
        long(least),
        long(most),
        long(prepare),
        long(time.links),
        long(time.passes + time.gather),
        time.tried
    ))?;
    let (passes, shots) = (ahead.expected.passes, ahead.expected.shots);
    Ok(json!({ "passes": passes, "shots": shots, "seconds": span(expected, least, most) }))
}

fn passes(settings: &Settings, expected: &Expected) -> String {
    let (passes, shots) = (
        count(expected.passes.round() as u64),
        count(expected.shots.round() as u64),
    );
    let name = format!("{:?}", settings.schedule.iteration).to_lowercase();
    let what = match settings.schedule.iteration {
        Iteration::Southwell => format!("{shots} shots"),
        _ => format!("{passes} passes, {shots} shots"),
    };
    match expected.from {
        Some(side) => format!("about {what} by {name} (a solve on {side}×{side} texels a face)"),
        None => format!("at most {what} by {name} (a bound of the largest reflectance)"),
    }
}

fn matrix(scene: &Scene, settings: &Settings, told: &Told) -> Result<Value> {
    let counts = Counts::new(scene, &settings.meshing);
    told.line(format_args!(""))?;
    told.line(format_args!("{}, matrix", scene.name))?;
    told.line(format_args!(
        "  size    {} faces, {} texels, {} pairs",
        count(counts.faces),
        count(counts.texels),
        count(counts.texels.saturating_mul(counts.texels))
    ))?;
    let bytes = memory::bytes(counts.texels);
    told.line(format_args!(
        "  memory  {} ({} are allowed)",
        size(bytes),
        size(memory::MEMORY)
    ))?;
    let plan = json!({ "solver": "matrix", "texels": counts.texels, "bytes": bytes });
    match check_matrix(scene, settings.meshing.texels) {
        Err(error) => refused(plan, &error, told),
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
        let asked = Asked {
            error: LOOK,
            texels: None,
        };
        let look = |patience| {
            let (settings, progress) = (Settings::default(), Progress::new("plan", true));
            let solver = Solver::to_error(None, asked);
            look(&scene, &settings, solver, &progress, patience).unwrap()
        };
        let told = Told { json: true };
        let (seconds, links) = look(f64::INFINITY);
        assert!(links.is_some_and(|links| links > 0), "{links:?}");
        let told_of = |seconds, links| from_a_look(LOOK / 10.0, seconds, links, &told).unwrap();
        let plan = told_of(seconds, links);
        assert_eq!(plan["seconds"]["expected"], 10.0 * seconds);
        assert!(plan["seconds"]["least"].as_f64() < Some(10.0 * seconds));
        let (seconds, links) = look(0.0);
        assert_eq!(links, None);
        let plan = told_of(seconds, links);
        assert_eq!(plan["seconds"], json!({ "least": 10.0 * seconds }));
    }
}
