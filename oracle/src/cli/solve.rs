//! `radiosity solve`.

use super::options::Common;
use super::progress::{Progress, interrupted, listen};
use super::{Outcome, warnings};
use clap::{Args, ValueEnum};
use common::energy::Energy;
use common::form_factor::FormFactor;
use common::import::load;
use common::mesh::Mesh;
use common::settings::{Settings, Visibility};
use common::shooting::{self, Engine, Run, solve};
use common::solution::{Seconds, Solution, prepare};
use common::{Error, Result};
use cpu::CpuSolver;
use gpu::{Gpu, GpuSolver, adapters};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// `--solver`.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum SolverOption {
    /// Rays, or the scalar twin of the item buffer
    Cpu,
    /// Item buffer
    Gpu,
}

/// Arguments of `solve`.
#[derive(Args)]
pub struct Arguments {
    /// An .obj (with its .mtl), a .gltf or a .glb
    scene: PathBuf,
    /// Who solves [default: gpu where there is a hardware adapter, else cpu]
    #[arg(long, value_enum)]
    solver: Option<SolverOption>,
    /// Where lightmap.exr and result.json go
    #[arg(long, value_name = "DIR", default_value = "out")]
    out: PathBuf,
    #[command(flatten)]
    common: Common,
}

/// The solve that a comparison without an adapter still does.
pub fn on_cpu(scene: &Path, out: &Path, common: &Common) -> Result<Outcome> {
    run(&Arguments {
        scene: scene.to_path_buf(),
        solver: Some(SolverOption::Cpu),
        out: out.to_path_buf(),
        common: Common {
            require_gpu: false,
            ..common.clone()
        },
    })
}

/// Solves and writes.
pub fn run(arguments: &Arguments) -> Result<Outcome> {
    let common = &arguments.common;
    let solver = choose(arguments)?;
    let start = Instant::now();
    let scene = load(&arguments.scene, &common.import())?;
    let load_seconds = start.elapsed().as_secs_f64();
    for note in &scene.notes {
        eprintln!("note: {}: {note}", scene.name);
    }
    prepare(&arguments.out)?;
    listen();

    let start = Instant::now();
    let settings = |visibility| common.settings(visibility, FormFactor::Polygon, 4);
    let device = match solver {
        SolverOption::Cpu => None,
        SolverOption::Gpu => Some(Gpu::open(common.adapter.as_deref())),
    };
    // Without an adapter the CPU does what it can, and the exit code says that it was not asked.
    let (device, missing) = match device {
        Some(Err(error @ Error::NoAdapter(_))) => (None, Some(error)),
        Some(other) => (Some(other?), None),
        None => (None, None),
    };
    if let Some(error) = &missing {
        eprintln!("note: {error}; solving on the CPU");
    }
    let settings = settings(if device.is_some() {
        Visibility::Stereographic
    } else {
        Visibility::Rays
    })?;
    let mesh = Mesh::uniform(&scene, settings.texels, settings.cells)?;
    let mut engine: Box<dyn Engine> = match &device {
        Some(gpu) => Box::new(GpuSolver::new(gpu, &mesh, &settings)?),
        None => Box::new(CpuSolver::new(&mesh, &settings)),
    };
    let prepare_seconds = start.elapsed().as_secs_f64();

    let start = Instant::now();
    let run = shoot(engine.as_mut(), &settings, &scene.name, common.quiet)?;
    let solve_seconds = start.elapsed().as_secs_f64();

    let mut notes = scene.notes.clone();
    notes.extend(fewer_cells(&mesh, &settings));
    if interrupted() {
        notes.push("interrupted: the result is what had been shot by then".into());
    }
    let solution = Solution {
        scene: &scene,
        mesh: &mesh,
        solver: if device.is_some() { "gpu" } else { "cpu" },
        adapter: device.as_ref().map(|gpu| gpu.line.name.as_str()),
        settings: &settings,
        run: &run,
        warnings: &warnings::of(&mesh, &run),
        notes: &notes,
        seconds: Seconds {
            load: load_seconds,
            prepare: prepare_seconds,
            solve: solve_seconds,
        },
    };
    solution.write(&arguments.out)?;
    if !common.quiet {
        summary(&solution, arguments);
    }
    missing.map_or(Ok(Outcome::Done), Err)
}

fn choose(arguments: &Arguments) -> Result<SolverOption> {
    let common = &arguments.common;
    let solver = match arguments.solver {
        Some(solver) => solver,
        None if common.require_gpu || adapters().iter().any(|line| !line.software) => {
            SolverOption::Gpu
        }
        None => SolverOption::Cpu,
    };
    if solver == SolverOption::Cpu && common.require_gpu {
        return Err(Error::Usage(
            "--require-gpu contradicts --solver cpu".into(),
        ));
    }
    if solver == SolverOption::Gpu {
        common.no_rays_on_gpu()?;
    }
    Ok(solver)
}

fn shoot(engine: &mut dyn Engine, settings: &Settings, title: &str, quiet: bool) -> Result<Run> {
    let mut progress = Progress::new(title, quiet);
    solve(engine, settings, &mut |shot, emitted| {
        let done = shooting::progress(shot, emitted, settings.epsilon);
        progress.show("shooting", (done * 1000.0) as u64, 1000)
    })
}

/// A triangle's cells are blocks of whole texels only for divisors of its side.
fn fewer_cells(mesh: &Mesh, settings: &Settings) -> Option<String> {
    let asked = (settings.cells * settings.cells) as usize * mesh.faces.len();
    (mesh.cells.len() < asked).then(|| {
        format!(
            "{} cells instead of {asked}: a face has at most one a texel, and a triangle's side is cut by a divisor of its {} texels",
            mesh.cells.len(),
            settings.texels
        )
    })
}

fn summary(solution: &Solution, arguments: &Arguments) {
    let energy = Energy::new(solution.mesh, &solution.run.field, &solution.run.shots);
    eprintln!(
        "{}: {} faces, {} texels, {} shots on {} in {:.2} s, {:.3} % unshot, imbalance {:.1e}, escaped {:.2} %, closure {:.2} %",
        solution.scene.name,
        solution.mesh.faces.len(),
        solution.mesh.texels.len(),
        solution.run.shots.len(),
        solution.adapter.unwrap_or("the CPU"),
        solution.seconds.solve,
        100.0 * solution.run.unshot_fraction(),
        energy.imbalance,
        100.0 * energy.share(energy.escaped),
        100.0 * energy.share(energy.closure),
    );
    for warning in solution.warnings {
        eprintln!("warning: {}", warning.message);
    }
    eprintln!(
        "wrote {}/lightmap.exr and result.json",
        arguments.out.display()
    );
}
