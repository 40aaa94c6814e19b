//! `radiosity converge`.

use super::Outcome;
use super::bundled::bundled;
use super::progress::{Progress, interrupted, listen};
use super::scene::Materials;
use super::solver::open_or_twin;
use super::tell::say;
use crate::solve::watch::Watch;
use crate::study::converge::run::Bench;
use crate::study::converge::sweeps::sweeps;
use crate::study::converge::{MeasuredSweep, Study, item_buffer, json, page};
use clap::Args;
use common::cover::sampled;
use common::form_factor::FormFactor;
use common::import::ImportOptions;
use common::scene::Scene;
use common::settings::Meshing;
use common::solution::{Stored, prepare, write_file};
use common::{Error, Result};
use gpu::Gpu;
use std::path::PathBuf;
use std::time::Instant;

/// Arguments of `converge`.
#[derive(Args)]
pub struct Arguments {
    /// .obj, .gltf or .glb files [default: the bundled Cornell box and furnace]
    scenes: Vec<PathBuf>,
    /// Where converge.html and converge.json go
    #[arg(long, value_name = "DIR", default_value = "out")]
    out: PathBuf,
    /// A result of the scene taken as the truth [default: one step finer than the last point]
    #[arg(long, value_name = "DIR")]
    truth: Option<PathBuf>,
    /// The GPU adapter whose name contains NAME
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
    #[command(flatten)]
    materials: Materials,
    /// Make a front of each back
    #[arg(long)]
    two_sided: bool,
    /// Join two triangles of a glTF mesh that form a planar convex quad
    #[arg(long)]
    join_quads: bool,
    /// No progress, no summary
    #[arg(long)]
    quiet: bool,
}

/// The bundled scenes that are swept.
const SCENES: [&str; 2] = ["cornell_box.obj", "furnace.obj"];

/// Item buffer sizes of the table.
const SIZES: [u32; 3] = [256, 512, 1024];

/// Sweeps every parameter on every scene, and writes after each sweep.
pub fn run(arguments: &Arguments) -> Result<Outcome> {
    let scenes = scenes(arguments)?;
    let truth = arguments.truth.as_deref().map(Stored::read).transpose()?;
    prepare(&arguments.out)?;
    listen();
    let gpu = open_or_twin(arguments.adapter.as_deref())?;
    let start = Instant::now();
    let mut studies: Vec<Study> = Vec::new();
    for scene in &scenes {
        let bench = Bench {
            scene,
            gpu: gpu.as_ref(),
            truth: truth.as_ref(),
        };
        let mut study = Study {
            scene: scene.name.clone(),
            faces: scene.faces.len(),
            adapter: gpu
                .as_ref()
                .map_or("the CPU's twin".into(), |gpu| gpu.line.name.clone()),
            sweeps: Vec::new(),
            item_buffers: Vec::new(),
        };
        for sweep in sweeps() {
            let progress = Progress::new(&scene.name, arguments.quiet);
            let show = |phase: &str, done| progress.show(phase, done);
            let done = bench.sweep(&sweep, &Watch::new(&show))?;
            progress.clear();
            let Some(done) = done else { break };
            if !arguments.quiet {
                summary(&scene.name, &done);
            }
            study.sweeps.push(done);
            // Written after every sweep: what is done is not lost.
            let so_far: Vec<Study> = studies.iter().chain([&study]).cloned().collect();
            write(arguments, &so_far, start.elapsed().as_secs_f64())?;
            if interrupted() {
                break;
            }
        }
        if let (Some(gpu), false) = (&gpu, interrupted()) {
            study.item_buffers = item_buffers(scene, gpu, arguments.quiet)?;
        }
        studies.push(study);
        if interrupted() {
            say!("interrupted: the report holds what was measured by then");
            break;
        }
    }
    write(arguments, &studies, start.elapsed().as_secs_f64())?;
    if !arguments.quiet {
        say!(
            "wrote {0}/converge.html and {0}/converge.json",
            arguments.out.display()
        );
    }
    Ok(Outcome::Done)
}

/// Whole faces and centres, as in `compare`.
fn item_buffers(scene: &Scene, gpu: &Gpu, quiet: bool) -> Result<Vec<item_buffer::Row>> {
    let meshing = Meshing {
        cells: 1,
        ..Meshing::default()
    };
    let mesh = sampled(scene, &meshing)?;
    let progress = Progress::new(&scene.name, quiet);
    let mut done = 0;
    let all = (item_buffer::PROJECTIONS.len() * item_buffer::LOOKUPS.len() * SIZES.len()) as u32;
    item_buffer::rows(gpu, &mesh, FormFactor::Polygon, &SIZES, &mut |_| {
        done += 1;
        let _ = progress.show(
            "item buffers against rays",
            f64::from(done) / f64::from(all),
        );
    })
}

fn scenes(arguments: &Arguments) -> Result<Vec<Scene>> {
    if arguments.truth.is_some() && arguments.scenes.len() != 1 {
        return Err(Error::Usage("--truth belongs to one SCENE: name it".into()));
    }
    let ours = |name| bundled(name, &arguments.out);
    let paths = match arguments.scenes.as_slice() {
        [] => SCENES.into_iter().map(ours).collect::<Result<_>>()?,
        given => given.to_vec(),
    };
    let options = ImportOptions {
        join_quads: arguments.join_quads,
        two_sided: arguments.two_sided,
        ..ImportOptions::default()
    };
    let lit = |path: &PathBuf| arguments.materials.lit(path, options);
    paths.iter().map(lit).collect()
}

fn write(arguments: &Arguments, studies: &[Study], seconds: f64) -> Result<()> {
    let text = format!("{:#}\n", json(studies, seconds));
    write_file(&arguments.out.join("converge.json"), text.as_bytes())?;
    write_file(
        &arguments.out.join("converge.html"),
        page::html(studies).as_bytes(),
    )
}

fn summary(scene: &str, sweep: &MeasuredSweep) {
    for curve in &sweep.curves {
        let errors: Vec<String> = curve
            .points
            .iter()
            .map(|p| format!("{:.3}", 100.0 * p.error))
            .collect();
        let order = page::order(curve.order);
        say!(
            "{scene}: {}, {}: {} %, order {order}; {}",
            sweep.option,
            curve.label,
            errors.join(" "),
            curve.finding
        );
    }
}
