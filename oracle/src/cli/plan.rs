//! `radiosity plan`.

use super::Outcome;
use super::options::Common;
use super::solve::{settings, settings_for, visibility};
use super::solver::SolverOption;
use super::tell::result;
use crate::plan::Counts;
use crate::plan::ahead::ahead;
use crate::plan::fits::{Limit, check, check_matrix, size};
use crate::plan::memory::Memory;
use crate::plan::passes::Expected;
use crate::plan::trial::two;
use crate::show::number::count;
use crate::solve::Given;
use crate::solve::mend::{BUDGET, MEND, Size, cost, steps};
use crate::solve::solver::Solver;
use clap::Args;
use common::import::load;
use common::scene::{Face, Scene, Shape};
use common::settings::{Iteration, Quality, Settings};
use common::{Error, Result};
use cpu::matrix::memory;
use gpu::Gpu;
use std::path::PathBuf;

/// Arguments of `plan`.
#[derive(Args)]
pub struct Arguments {
    /// An .obj (with its .mtl), a .gltf or a .glb
    scene: PathBuf,
    /// Only this solver [default: the CPU, and the GPU where there is an adapter]
    #[arg(long, value_enum)]
    solver: Option<SolverOption>,
    #[command(flatten)]
    common: Common,
}

/// Prints what a solve will take.
pub fn run(arguments: &Arguments) -> Result<Outcome> {
    let common = &arguments.common;
    if arguments.solver == Some(SolverOption::Cpu) {
        common.not_for_cpu()?;
    }
    if arguments.solver != Some(SolverOption::Matrix) {
        let asked = visibility(common, arguments.solver != Some(SolverOption::Cpu));
        common.not_for_rays(asked)?;
    }
    let scene = load(&arguments.scene, &common.import())?;
    if arguments.solver == Some(SolverOption::Matrix) {
        common.not_for_matrix()?;
        return matrix(&scene, &settings(common, false)?);
    }
    if arguments.solver != Some(SolverOption::Gpu) {
        plan(&scene, common, None)?;
    }
    if arguments.solver != Some(SolverOption::Cpu) {
        match Gpu::open(common.adapter.as_deref()) {
            Ok(gpu) => plan(&scene, common, Some(&gpu))?,
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

fn plan(scene: &Scene, common: &Common, gpu: Option<&Gpu>) -> Result<()> {
    let (settings, changed) = settings_for(common, scene, gpu.is_some())?;
    let settings = &settings;
    let counts = Counts::new(scene, &settings.meshing);
    let who = gpu.map_or("CPU".into(), |gpu| format!("GPU, {}", gpu.line.name));
    result!("")?;
    result!("{}, {who}", scene.name)?;
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
    let time = seconds(scene, settings, gpu)?;
    if settings.quality == Quality::Normal {
        result!(
            "  mending {}",
            mending(scene, settings, common.given(), time)
        )?;
    }
    if settings.quality == Quality::Reference {
        result!("  note    reference starts with this and halves the cells until it has settled")?;
    }
    Ok(())
}

/// What mending may take, by the samples and pixels of its steps.
fn mending(scene: &Scene, settings: &Settings, given: Given, seconds: f64) -> String {
    let triangle = |face: &&Face| face.shape == Shape::Triangle;
    let triangles = scene.faces.iter().filter(triangle).count() as u64;
    let counts = Counts::new(scene, &settings.meshing);
    let size = Size {
        quads: counts.faces - triangles,
        triangles,
        texels: counts.texels,
    };
    let steps = steps(given, settings, size);
    let Some(last) = steps.last() else {
        return format!(
            "none: more cells and samples would exceed {} samples and pixels",
            count(BUDGET)
        );
    };
    let all: f64 = steps.iter().map(|step| cost(step, size) as f64).sum();
    let more = seconds * all / cost(settings, size) as f64;
    format!(
        "at most {} s more where it is about {} % off: up to {cells}×{cells} cells and {} samples, {} samples and pixels a solve",
        two(more),
        100.0 * MEND,
        last.meshing.samples,
        count(BUDGET),
        cells = last.meshing.cells
    )
}

/// Passes and time, from a short trial; the seconds expected.
fn seconds(scene: &Scene, settings: &Settings, gpu: Option<&Gpu>) -> Result<f64> {
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
    )?;
    Ok(ahead.seconds())
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
