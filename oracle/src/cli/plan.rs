//! `radiosity plan`.

use super::Outcome;
use super::options::Common;
use super::scene::{Dark, Materials};
use super::solve::{error, settings, settings_for, to_error as solve_to_error, visibility};
use super::solver::SolverOption;
use super::tell::result;
use crate::plan::Counts;
use crate::plan::ahead::ahead;
use crate::plan::fits::{Limit, check, check_matrix, check_texels, size};
use crate::plan::memory::Memory;
use crate::plan::passes::Expected;
use crate::plan::trial::two;
use crate::show::number::count;
use crate::solve::solver::{Asked, Solver};
use crate::solve::task::Task;
use crate::solve::watch::unwatched;
use clap::Args;
use common::form_factor::FormFactor;
use common::scene::Scene;
use common::settings::{Iteration, Settings, Visibility};
use common::{Error, Result};
use cpu::matrix::memory;
use gpu::Gpu;
use std::path::PathBuf;
use std::time::Instant;

/// The error of the solve that tells how long one to a lower error takes.
const LOOK: f64 = 0.1;
/// Seconds grow by this power of 1/error: five scenes of 17 to 10 133 faces took 7 to 16 times as long for
/// a tenth of it.
const STEEP: f64 = 1.0;
/// For 2 % they took so many times less or more at most.
const DOUBT: f64 = 3.0;

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
    #[command(flatten)]
    materials: Materials,
    #[command(flatten)]
    dark: Dark,
    #[command(flatten)]
    common: Common,
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
    let scene = materials.lit_unless(&arguments.dark, path, common.import())?;
    if arguments.solver == Some(SolverOption::Matrix) {
        common.not_for_matrix()?;
        return matrix(&scene, &settings(common, false)?);
    }
    let error = arguments.error.or(common.error());
    if arguments.solver != Some(SolverOption::Gpu) {
        plan(&scene, common, error, None)?;
    }
    if arguments.solver != Some(SolverOption::Cpu) {
        match Gpu::open(common.adapter.as_deref()) {
            Ok(gpu) => plan(&scene, common, error, Some(&gpu))?,
            Err(Error::NoAdapter(_))
                if arguments.solver.is_none()
                    && common.adapter.is_none()
                    && !common.require_gpu =>
            {
                result!("")?;
                result!("GPU: no adapter")?;
            }
            Err(error) => return Err(error),
        }
    }
    Ok(Outcome::Done)
}

/// What a solve to an error takes, from one to [`LOOK`].
fn to_error(scene: &Scene, common: &Common, error: f64, gpu: Option<&Gpu>) -> Result<()> {
    result!("")?;
    result!("{}, {}, to {} %", scene.name, named(gpu), 100.0 * error)?;
    let side = common
        .texels
        .map_or("as many texels as the light needs".into(), |n| {
            format!("{n}×{n} texels each")
        });
    result!(
        "  size    {} faces, {side}",
        count(scene.faces.len() as u64)
    )?;
    let limit = Limit::of_this_machine();
    if let Err(error) = check_texels(scene, common.texels.unwrap_or(1), limit) {
        result!("  refused {error}")?;
        return Ok(());
    }
    let asked = Asked {
        error: LOOK,
        texels: common.texels,
    };
    let settings = common.settings(Visibility::Rays, FormFactor::Polygon)?;
    let start = Instant::now();
    let solved = scene.once(&settings, Solver::to_error(gpu, asked), &unwatched())?;
    let seconds = start.elapsed().as_secs_f64();
    let links = solved.moved.map_or(0, |moved| moved.links);
    let times = (LOOK / error).powf(STEEP);
    result!(
        "  time    about {} s, between {} and {} s ({} links to {} % took {} s)",
        two(seconds * times),
        two(seconds * times / DOUBT),
        two(seconds * times * DOUBT),
        count(links),
        100.0 * LOOK,
        two(seconds)
    )
}

fn named(gpu: Option<&Gpu>) -> String {
    gpu.map_or("CPU".into(), |gpu| format!("GPU, {}", gpu.line.name))
}

fn plan(scene: &Scene, common: &Common, error: Option<f64>, gpu: Option<&Gpu>) -> Result<()> {
    if let Some(error) = error {
        return to_error(scene, common, error, gpu);
    }
    let (settings, changed) = settings_for(common, scene, gpu.is_some())?;
    let settings = &settings;
    let counts = Counts::new(scene, &settings.meshing);
    result!("")?;
    result!("{}, {}", scene.name, named(gpu))?;
    result!(
        "  size    {} faces, {} texels, {} cells; {} links of {} samples",
        count(counts.faces),
        count(counts.texels),
        count(counts.cells),
        count(counts.links()),
        settings.meshing.samples
    )?;
    if let Some(changed) = changed {
        result!("  note    {changed}")?;
    }
    let memory = match gpu {
        None => Memory::cpu(&counts, settings),
        Some(gpu) => Memory::gpu(gpu, &counts, settings),
    };
    let limit = Limit::of_this_machine();
    result!(
        "  memory  {}: scene {}, mesh {}, state {}, links {} at most, afterwards {} ({} {})",
        size(memory.bytes()),
        size(memory.scene),
        size(memory.mesh),
        size(memory.state),
        size(memory.links),
        size(memory.look),
        size(limit.bytes),
        limit.source
    )?;
    if let Err(error) = check(scene, settings, gpu, limit) {
        result!("  refused {error}")?;
        return Ok(());
    }
    seconds(scene, settings, gpu)
}

/// Passes and time, from a short trial.
fn seconds(scene: &Scene, settings: &Settings, gpu: Option<&Gpu>) -> Result<()> {
    let ahead = ahead(scene, settings, Solver::on(gpu))?;
    result!("  passes  {}", passes(settings, &ahead.expected))?;
    let (prepare, time) = (ahead.prepare, &ahead.time);
    result!(
        "  time    about {} s, between {} and {} s: prepare {}, links {}, passes {} s ({} cells tried)",
        two(ahead.seconds()),
        two(prepare + time.seconds() / time.factor),
        two(prepare + time.seconds() * time.factor),
        two(prepare),
        two(time.links),
        two(time.passes + time.gather),
        time.tried
    )
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

fn matrix(scene: &Scene, settings: &Settings) -> Result<Outcome> {
    let counts = Counts::new(scene, &settings.meshing);
    result!("")?;
    result!("{}, matrix", scene.name)?;
    result!(
        "  size    {} faces, {} texels, {} pairs",
        count(counts.faces),
        count(counts.texels),
        count(counts.texels.saturating_mul(counts.texels))
    )?;
    result!(
        "  memory  {} ({} are allowed)",
        size(memory::bytes(counts.texels)),
        size(memory::MEMORY)
    )?;
    if let Err(error) = check_matrix(scene, settings.meshing.texels) {
        result!("  refused {error}")?;
    }
    Ok(Outcome::Done)
}
