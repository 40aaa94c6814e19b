//! `radiosity solve`.

use super::options::Common;
use super::progress::{Progress, interrupted, listen};
use super::solver::{SolverOption, choose, open};
use super::{Outcome, matrix, warnings};
use crate::plan::fits::{Limit, check};
use crate::refine::{Rung, refine};
use clap::Args;
use common::Result;
use common::capture::maps;
use common::energy::Energy;
use common::form_factor::FormFactor;
use common::import::load;
use common::mesh::Mesh;
use common::passes::solve;
use common::scene::Scene;
use common::settings::{Quality, Settings, Visibility};
use common::shooting::{Engine, Field, Run};
use common::solution::{Seconds, Solution, prepare};
use cpu::CpuSolver;
use cpu::cover::sampled;
use glam::Vec3;
use gpu::{Gpu, GpuSolver};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// What a solve writes.
pub const FILES: &str = "lightmap.exr and result.json";

/// Arguments of `solve`.
#[derive(Args)]
pub struct Arguments {
    /// An .obj (with its .mtl), a .gltf or a .glb
    pub scene: PathBuf,
    /// Who solves [default: gpu where there is a hardware adapter, else cpu]
    #[arg(long, value_enum)]
    solver: Option<SolverOption>,
    /// Where lightmap.exr and result.json go
    #[arg(long, value_name = "DIR", default_value = "out")]
    pub out: PathBuf,
    /// Write each face's light as an HDR map as well, into DIR/maps: a room for relight
    #[arg(long)]
    pub maps: bool,
    #[command(flatten)]
    pub common: Common,
}

/// The solve that a comparison without an adapter still does.
pub fn on_cpu(scene: &Path, out: &Path, common: &Common) -> Result<Outcome> {
    run(&Arguments {
        scene: scene.to_path_buf(),
        solver: Some(SolverOption::Cpu),
        out: out.to_path_buf(),
        maps: false,
        common: Common {
            require_gpu: false,
            ..common.clone()
        },
    })
}

/// Solves and writes.
pub fn run(arguments: &Arguments) -> Result<Outcome> {
    let common = &arguments.common;
    if arguments.solver == Some(SolverOption::Matrix) {
        return matrix::run(arguments);
    }
    let solver = choose(arguments.solver, &arguments.common)?;
    let start = Instant::now();
    let scene = load(&arguments.scene, &common.import())?;
    let load_seconds = start.elapsed().as_secs_f64();
    for note in &scene.notes {
        eprintln!("note: {}: {note}", scene.name);
    }
    let (device, missing) = open(solver, common)?;
    let settings = settings(common, device.is_some())?;
    check(&scene, &settings, device.as_ref(), Limit::of_this_machine())?;
    prepare(&arguments.out)?;
    listen();

    let mut timing = Seconds {
        load: load_seconds,
        ..Seconds::default()
    };
    let mut rung =
        |settings: &Settings| rung(&scene, settings, device.as_ref(), common.quiet, &mut timing);
    let mut notes = scene.notes.clone();
    let (rung, mesh, field) = if settings.quality == Quality::Reference && common.cells.is_none() {
        let refined = refine(&scene, &settings, rung, interrupted)?;
        for note in &refined.notes {
            eprintln!("note: {note}");
        }
        notes.extend(refined.notes);
        (refined.rung, refined.answer, refined.field)
    } else {
        let rung = rung(&settings)?;
        let (mesh, field) = (rung.mesh.clone(), rung.run.field.clone());
        (rung, mesh, field)
    };
    notes.extend(fewer_cells(&rung.mesh, &rung.settings));
    if interrupted() {
        notes.push("interrupted: the result is what had been shot by then".into());
    }
    let solution = Solution {
        scene: &scene,
        mesh: &mesh,
        solver: if device.is_some() { "gpu" } else { "cpu" },
        adapter: device.as_ref().map(|gpu| gpu.line.name.as_str()),
        settings: &Settings {
            texels: settings.texels,
            ..rung.settings.clone()
        },
        run: &Run {
            field,
            ..rung.run.clone()
        },
        warnings: &warnings::of(&rung.mesh, &rung.run),
        notes: &notes,
        matrix: None,
        relit: None,
        seconds: timing,
    };
    solution.write(&arguments.out)?;
    if arguments.maps {
        write_maps(&scene, &mesh, &solution.run.field, &arguments.out)?;
    }
    if !common.quiet {
        summary(&solution, arguments);
    }
    missing.map_or(Ok(Outcome::Done), Err)
}

/// The radiance map of every face.
pub fn write_maps(scene: &Scene, mesh: &Mesh, field: &Field, out: &Path) -> Result<()> {
    let radiosity: Vec<Vec3> = mesh
        .in_face_order()
        .into_iter()
        .map(|k| field.radiosity[k].truncate())
        .collect();
    let resolutions: Vec<[u32; 2]> = mesh.faces.iter().map(|f| f.resolution).collect();
    maps::write(&out.join("maps"), scene, &resolutions, &radiosity)
}

/// The settings in force. The most accurate visibility of a solver is its default; at reference
/// quality that is rays on both.
pub fn settings(common: &Common, on_gpu: bool) -> Result<Settings> {
    let visibility = if on_gpu && common.quality() != Quality::Reference {
        Visibility::Stereographic
    } else {
        Visibility::Rays
    };
    common.of_passes(visibility, FormFactor::Polygon)
}

/// One solve at given settings.
fn rung(
    scene: &Scene,
    settings: &Settings,
    device: Option<&Gpu>,
    quiet: bool,
    timing: &mut Seconds,
) -> Result<Rung> {
    let start = Instant::now();
    let mesh = sampled(scene, settings)?;
    let mut engine: Box<dyn Engine> = match device {
        Some(gpu) => Box::new(GpuSolver::new(gpu, &mesh, settings)?),
        None => Box::new(CpuSolver::new(&mesh, settings)),
    };
    timing.prepare += start.elapsed().as_secs_f64();
    let start = Instant::now();
    let mut progress = Progress::new(&scene.name, quiet);
    let run = solve(engine.as_mut(), &mesh, settings, &mut |done| {
        progress.show("shooting", (done * 1000.0) as u64, 1000)
    })?;
    timing.solve += start.elapsed().as_secs_f64();
    drop(engine);
    Ok(Rung {
        settings: settings.clone(),
        mesh,
        run,
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
        "{}: {} faces, {} texels, {} shots in {} passes on {} in {:.2} s, {:.3} % unshot, imbalance {:.1e}, escaped {:.2} %, closure {:.2} %",
        solution.scene.name,
        solution.mesh.faces.len(),
        solution.mesh.texels.len(),
        solution.run.shooters,
        solution.run.passes,
        solution.adapter.unwrap_or("the CPU"),
        solution.seconds.solve,
        100.0 * solution.run.unshot_fraction(),
        energy.imbalance,
        100.0 * energy.share(energy.escaped),
        100.0 * energy.share(energy.closure),
    );
    wrote(solution, FILES, &arguments.out);
}

/// The warnings, and where the files are.
pub fn wrote(solution: &Solution, files: &str, out: &Path) {
    for warning in solution.warnings {
        eprintln!("warning: {}", warning.message);
    }
    eprintln!("wrote {files} in {}", out.display());
}
