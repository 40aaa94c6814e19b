//! `radiosity plan`.

use super::Outcome;
use super::options::Common;
use super::solve::settings;
use super::solver::SolverOption;
use crate::answer::Given;
use crate::answer::mend::{BUDGET, MEND, cost, steps};
use crate::plan::fits::{Limit, check, size};
use crate::plan::memory::Memory;
use crate::plan::passes::{Expected, expected};
use crate::plan::{Counts, trial};
use crate::report::number::{count, number};
use clap::Args;
use common::import::load;
use common::scene::Scene;
use common::settings::{Iteration, Quality, Settings};
use common::shooting::Engine;
use common::{Error, Result};
use cpu::CpuSolver;
use cpu::cover::sampled;
use cpu::matrix::memory;
use gpu::{Gpu, GpuSolver};
use std::path::PathBuf;
use std::time::Instant;

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
    let scene = load(&arguments.scene, &common.import())?;
    if arguments.solver == Some(SolverOption::Matrix) {
        common.not_for_matrix()?;
        return matrix(&scene, &settings(common, false)?);
    }
    let given = common.given();
    if arguments.solver != Some(SolverOption::Gpu) {
        plan(&scene, &settings(common, false)?, given, None)?;
    }
    if arguments.solver != Some(SolverOption::Cpu) {
        match Gpu::open(common.adapter.as_deref()) {
            Ok(gpu) => plan(&scene, &settings(common, true)?, given, Some(&gpu))?,
            Err(Error::NoAdapter(_))
                if arguments.solver.is_none()
                    && common.adapter.is_none()
                    && !common.require_gpu =>
            {
                println!("\nGPU: no adapter");
            }
            Err(error) => return Err(error),
        }
    }
    Ok(Outcome::Done)
}

fn plan(scene: &Scene, settings: &Settings, given: Given, gpu: Option<&Gpu>) -> Result<()> {
    let counts = Counts::new(scene, settings);
    let who = gpu.map_or("CPU".into(), |gpu| format!("GPU, {}", gpu.line.name));
    println!("\n{}, {who}", scene.name);
    println!(
        "  size    {} faces, {} texels, {} cells; {} links of {} samples",
        count(counts.faces),
        count(counts.texels),
        count(counts.cells),
        count(counts.links()),
        settings.samples
    );
    let memory = match gpu {
        None => Memory::cpu(&counts, settings),
        Some(gpu) => Memory::gpu(gpu, &counts, settings),
    };
    let limit = Limit::of_this_machine();
    println!(
        "  memory  {}: mesh {}, state {}, links {} at most ({} {})",
        size(memory.bytes()),
        size(memory.mesh),
        size(memory.state),
        size(memory.links),
        size(limit.bytes),
        limit.source
    );
    if let Err(error) = check(scene, settings, gpu, limit) {
        println!("  refused {error}");
        return Ok(());
    }
    let time = seconds(scene, settings, gpu)?;
    if settings.quality == Quality::Normal {
        println!("  mending {}", mending(&counts, settings, given, time));
    }
    if settings.quality == Quality::Reference {
        println!("  note    reference starts with this and halves the cells until it has settled");
    }
    Ok(())
}

/// What mending may take, by the samples and pixels of its steps.
fn mending(counts: &Counts, settings: &Settings, given: Given, seconds: f64) -> String {
    let size = [counts.faces, counts.texels];
    let steps = steps(given, settings, size);
    let Some(last) = steps.last() else {
        return format!(
            "none: more cells and samples would be beyond {} samples and pixels",
            count(BUDGET)
        );
    };
    let all: f64 = steps.iter().map(|step| cost(step, size) as f64).sum();
    let more = seconds * all / cost(settings, size) as f64;
    format!(
        "at most {} s more where it is about {} % off: up to {cells}×{cells} cells and {} samples, {} samples and pixels a solve",
        two(more),
        100.0 * MEND,
        last.samples,
        count(BUDGET),
        cells = last.cells
    )
}

/// Passes and time, from a short trial; the seconds expected.
fn seconds(scene: &Scene, settings: &Settings, gpu: Option<&Gpu>) -> Result<f64> {
    let start = Instant::now();
    let mesh = sampled(scene, settings)?;
    let mut engine: Box<dyn Engine> = match gpu {
        None => Box::new(CpuSolver::new(&mesh, settings)),
        Some(gpu) => Box::new(GpuSolver::new(gpu, &mesh, settings)?),
    };
    let prepare = start.elapsed().as_secs_f64();
    let mut settings = settings.clone();
    if !engine.exchanges() {
        settings.iteration = Iteration::Southwell;
    }
    let expected = expected(scene, &settings)?;
    println!("  passes  {}", passes(&settings, &expected));
    let time = trial::time(engine.as_mut(), &mesh, &expected)?;
    let all = prepare + time.seconds();
    println!(
        "  time    about {} s, between {} and {} s: prepare {}, links {}, passes {} s ({} cells tried)",
        two(all),
        two(prepare + time.seconds() / time.factor),
        two(prepare + time.seconds() * time.factor),
        two(prepare),
        two(time.links),
        two(time.passes + time.gather),
        time.tried
    );
    Ok(all)
}

fn passes(settings: &Settings, expected: &Expected) -> String {
    let (passes, shots) = (
        count(expected.passes.round() as u64),
        count(expected.shots.round() as u64),
    );
    let name = format!("{:?}", settings.iteration).to_lowercase();
    let what = match settings.iteration {
        Iteration::Southwell | Iteration::Overshoot => format!("{shots} shots"),
        _ => format!("{passes} passes, {shots} shots"),
    };
    match expected.from {
        Some(side) => format!("about {what} by {name} (a solve on {side}×{side} texels a face)"),
        None => format!("at most {what} by {name} (a bound of the largest reflectance)"),
    }
}

/// Two digits: more would be made up.
fn two(seconds: f64) -> String {
    let scale = 10f64.powf(seconds.log10().floor() - 1.0);
    let rounded = (seconds / scale).round() * scale;
    number(if rounded.is_finite() {
        rounded
    } else {
        seconds
    })
}

fn matrix(scene: &Scene, settings: &Settings) -> Result<Outcome> {
    let counts = Counts::new(scene, settings);
    println!("\n{}, matrix", scene.name);
    println!(
        "  size    {} faces, {} texels, {} pairs",
        count(counts.faces),
        count(counts.texels),
        count(counts.texels.saturating_mul(counts.texels))
    );
    println!(
        "  memory  {} ({} are allowed)",
        size(memory::bytes(counts.texels)),
        size(memory::MEMORY)
    );
    if let Err(error) = memory::check(scene, settings.texels) {
        println!("  refused {error}");
    }
    Ok(Outcome::Done)
}
