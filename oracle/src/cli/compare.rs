//! `radiosity compare`, and the demo.

use super::bundled::bundled;
use super::options::Common;
use super::progress::{Progress, interrupted, listen};
use super::scene::Materials;
use super::tell::{self, say};
use super::{Outcome, solve};
use crate::judge::compare::ways::{Ways, judge};
use crate::judge::comparison::{Comparison, Judged};
use crate::show::report;
use crate::solve::solver::Asked;
use crate::solve::watch::Watch;
use clap::{Args, Parser};
use common::form_factor::FormFactor;
use common::scene::Scene;
use common::settings::{Drawing, Meshing, Settings, Visibility};
use common::solution::{prepare, write_file};
use common::{Error, Result};
use gpu::Gpu;
use std::path::{Path, PathBuf};

/// Arguments of `compare`.
#[derive(Args, Clone)]
pub struct Arguments {
    /// .obj, .gltf or .glb files
    #[arg(required = true)]
    scenes: Vec<PathBuf>,
    /// Where report.html and report.json go
    #[arg(long, value_name = "DIR", default_value = "out")]
    out: PathBuf,
    /// Judge solves until the answer is P per cent off at most, 0.2 to 10, and nothing else
    #[arg(long, value_name = "P%", value_parser = solve::error, allow_negative_numbers = true)]
    error: Option<f64>,
    /// What report.json has, as one line on stdout
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    materials: Materials,
    #[command(flatten)]
    common: Common,
}

/// What the method errs by is told beyond this, as everywhere else in per mille.
const TOLD: f64 = 1e-3;

/// A parser around the arguments, for the demo's defaults.
#[derive(Parser)]
struct Demo {
    #[command(flatten)]
    arguments: Arguments,
}

/// `compare` on the bundled Cornell box.
pub fn demo() -> Result<Outcome> {
    let demo = |scene: &Path| Demo::parse_from([Path::new("radiosity"), scene]).arguments;
    let name = Path::new("cornell_box.obj");
    let scene = bundled("cornell_box.obj", &demo(name).out)?;
    run(&demo(&scene))
}

/// Compares and reports.
pub fn run(arguments: &Arguments) -> Result<Outcome> {
    let common = &arguments.common;
    common.not_for_rays(solve::visibility(common, true))?;
    let scenes: Vec<Scene> = arguments
        .scenes
        .iter()
        .map(|path| arguments.materials.lit(path, common.import()))
        .collect::<Result<_>>()?;
    let ways: Vec<Ways> = scenes
        .iter()
        .map(|scene| ways(arguments, scene))
        .collect::<Result<_>>()?;
    prepare(&arguments.out)?;
    listen();
    let gpu = match Gpu::open(common.adapter.as_deref()) {
        Ok(gpu) => gpu,
        Err(error @ Error::NoAdapter(_)) => return Err(cpu_only(arguments, error)),
        Err(error) => return Err(error),
    };
    let mut comparisons = Vec::new();
    for (scene, ways) in scenes.iter().zip(&ways) {
        let progress = Progress::new(&scene.name, common.quiet);
        let show = |phase: &str, done| progress.show(phase, done);
        let judged = judge(scene, ways, &gpu, &[], &Watch::new(&show));
        progress.clear();
        if interrupted() {
            say!(
                "interrupted: the report holds the {} scenes compared by then",
                comparisons.len()
            );
            told(arguments, &comparisons)?;
            return Ok(Outcome::Disagree);
        }
        let judged = judged?;
        if !common.quiet {
            summary(&judged);
        }
        comparisons.push(judged);
        // Written after every scene: what is done is not lost.
        write(arguments, &comparisons)?;
    }
    if !common.quiet {
        say!(
            "wrote {0}/report.html and {0}/report.json",
            arguments.out.display()
        );
    }
    told(arguments, &comparisons)?;
    Ok(if comparisons.iter().all(Judged::agree) {
        Outcome::Done
    } else {
        Outcome::Disagree
    })
}

/// With an option that says how to solve, that one way. Texels, ε and pixels are asked of any way.
fn ways(arguments: &Arguments, scene: &Scene) -> Result<Ways> {
    let common = &arguments.common;
    if arguments.error.is_some() {
        common.not_for_error()?;
    }
    // Of many faces the defaults are coarser, in either way.
    let (solve, note) = solve::settings_for(common, scene, true)?;
    if let Some(note) = note {
        say!("note: {}: {note}", scene.name);
    }
    let asked = |error| Asked {
        error,
        texels: Some(solve.meshing.texels),
    };
    // A quality is an error, unless something is asked of shooting.
    let error = arguments.error.or(common.error());
    if let (Some(error), true) = (error, arguments.error.is_some() || common.quality.is_some()) {
        return Ok(Ways::ToError(asked(error), solve));
    }
    // Of the paper's way too it may be asked when it stops, and how large its item buffer is.
    let either = Common {
        epsilon: None,
        max_shots: None,
        item_buffer: None,
        ..common.clone()
    };
    let Some(error) = either.error().filter(|_| common.quality.is_none()) else {
        return Ok(Ways::Shooting(solve));
    };
    let paper = Settings {
        meshing: Meshing {
            texels: solve.meshing.texels,
            cells: 1,
            samples: 1,
        },
        ..common.settings(Visibility::Drawn(Drawing::DEFAULT), FormFactor::Disc)?
    };
    Ok(Ways::Both {
        paper,
        asked: asked(error),
    })
}

fn write(arguments: &Arguments, comparisons: &[Judged]) -> Result<()> {
    let json = format!("{:#}\n", report::json(comparisons));
    write_file(&arguments.out.join("report.json"), json.as_bytes())?;
    write_file(
        &arguments.out.join("report.html"),
        report::html(comparisons, &[]).as_bytes(),
    )
}

/// On stdout, if asked for.
fn told(arguments: &Arguments, comparisons: &[Judged]) -> Result<()> {
    if arguments.json {
        tell::json(&report::json(comparisons))?;
    }
    Ok(())
}

/// Without an adapter each scene is solved on the CPU, in a folder of its own.
fn cpu_only(arguments: &Arguments, error: Error) -> Error {
    say!("note: {error}; each scene is only solved, on the CPU");
    for path in &arguments.scenes {
        let name = path.file_stem().unwrap_or(path.as_os_str());
        if let Err(failure) = solve::on_cpu(
            (path, &arguments.materials),
            &arguments.out.join(name),
            arguments.error,
            &arguments.common,
        ) {
            return failure;
        }
    }
    error
}

/// The verdict with the error of the answers beside it: agreement is not accuracy.
fn summary(judged: &Judged) {
    let name = &judged.first.scene.name;
    for c in judged.ways() {
        let verdict = if c.agree() {
            "the solvers agree"
        } else {
            "THE SOLVERS DISAGREE"
        };
        say!("{name}, {}: {verdict}; {}", c.way.name(), accuracy(c));
        let (shots, pairs) = match c.asked {
            Some(asked) => (
                format!("asked {:.2} %", 100.0 * asked.error),
                "blocks of links",
            ),
            None => (
                format!("shots {} CPU, {} GPU", c.cpu.shooters, c.gpu.shooters),
                "facing pairs",
            ),
        };
        say!(
            "  {shots}; lockstep RMS {:.3} %; mismatched {} of {} {pairs}, {} unexplained; {:.1} s CPU, {:.1} s {}",
            100.0 * c.lockstep_difference.relative_rms,
            c.pairs.mismatched,
            c.pairs.facing,
            c.pairs.unexplained,
            c.seconds[0],
            c.seconds[1],
            c.adapter,
        );
        for finding in c.findings.iter().filter(|f| f.value > TOLD) {
            say!("  {}: {}", finding.name, finding.message);
        }
        for gate in c.gates.iter().filter(|gate| !gate.pass) {
            say!(
                "  beyond its bound: {} = {:.3e} > {:.3e} ({})",
                gate.name,
                gate.value,
                gate.bound,
                gate.reason
            );
        }
    }
}

fn accuracy(c: &Comparison) -> String {
    match (&c.truth, c.error) {
        (Some(truth), [Some(cpu), Some(gpu)]) => format!(
            "the answers are {:.1} % off on the CPU, {:.1} % on the GPU, against {} (itself off by less than {:.1} %)",
            100.0 * cpu,
            100.0 * gpu,
            truth.name,
            100.0 * truth.own_error,
        ),
        _ => "how far off the answers are is not known: there is no truth to judge by".into(),
    }
}
