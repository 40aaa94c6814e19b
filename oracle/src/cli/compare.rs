//! `radiosity compare`, and the demo.

use super::options::Common;
use super::progress::{Progress, interrupted, listen};
use super::tell::say;
use super::{Outcome, solve};
use crate::compare::{Request, compare};
use crate::comparison::Comparison;
use crate::report;
use clap::{Args, Parser};
use common::form_factor::FormFactor;
use common::import::load;
use common::scene::Scene;
use common::settings::{Quality, Settings, Visibility};
use common::solution::{prepare, write_file};
use common::{Error, Result};
use gpu::Gpu;
use std::path::PathBuf;

/// Arguments of `compare`.
#[derive(Args, Clone)]
pub struct Arguments {
    /// .obj, .gltf or .glb files
    #[arg(required = true)]
    scenes: Vec<PathBuf>,
    /// Where report.html and report.json go
    #[arg(long, value_name = "DIR", default_value = "out")]
    out: PathBuf,
    #[command(flatten)]
    common: Common,
}

/// A parser around the arguments, for the demo's defaults.
#[derive(Parser)]
struct Demo {
    #[command(flatten)]
    arguments: Arguments,
}

/// `compare` on the bundled Cornell box.
pub fn demo() -> Result<Outcome> {
    let scene = super::bundled("cornell_box.obj");
    run(&Demo::parse_from(["radiosity".into(), scene.into_os_string()]).arguments)
}

/// Compares and reports.
pub fn run(arguments: &Arguments) -> Result<Outcome> {
    let common = &arguments.common;
    let asked = common.visibility.map(Into::into);
    common.not_for_rays(asked.unwrap_or(Visibility::Stereographic))?;
    let scenes: Vec<Scene> = arguments
        .scenes
        .iter()
        .map(|path| load(path, &common.import()))
        .collect::<Result<_>>()?;
    prepare(&arguments.out)?;
    listen();
    let gpu = match Gpu::open(common.adapter.as_deref()) {
        Ok(gpu) => gpu,
        Err(error @ Error::NoAdapter(_)) => return Err(cpu_only(arguments, error)),
        Err(error) => return Err(error),
    };
    let settings = settings(common)?;
    let mut comparisons = Vec::new();
    for scene in &scenes {
        let request = Request {
            settings: settings.clone(),
            gpu: &gpu,
            faults: &[],
        };
        let mut progress = Progress::new(&scene.name, common.quiet);
        let comparison = compare(scene, &request, &mut |phase, done, all| {
            progress.show(phase, done, all)
        })?;
        drop(progress);
        if interrupted() {
            say!(
                "interrupted: the report holds the {} scenes compared by then",
                comparisons.len()
            );
            return Ok(Outcome::Disagree);
        }
        if !common.quiet {
            summary(&comparison);
        }
        comparisons.push(comparison);
        // Written after every scene: what is done is not lost.
        write(arguments, &comparisons)?;
    }
    if !common.quiet {
        say!(
            "wrote {0}/report.html and {0}/report.json",
            arguments.out.display()
        );
    }
    Ok(if comparisons.iter().all(Comparison::agree) {
        Outcome::Done
    } else {
        Outcome::Disagree
    })
}

/// Whole faces and centre to centre: which pair sees which is a yes or a no, so that it can be
/// compared pair by pair.
fn settings(common: &Common) -> Result<Settings> {
    if common.samples.is_some_and(|samples| samples > 1) {
        return Err(Error::Usage(
            "compare judges pairs of centres: --samples is for solve, or 1".into(),
        ));
    }
    if common.quality() == Quality::Reference {
        return Err(Error::Usage(
            "compare judges one setting: --quality reference is for solve".into(),
        ));
    }
    Ok(Settings {
        cells: common.cells.unwrap_or(1),
        samples: 1,
        ..common.settings(Visibility::Stereographic, FormFactor::Disc)?
    })
}

fn write(arguments: &Arguments, comparisons: &[Comparison]) -> Result<()> {
    let json = format!("{:#}\n", report::json(comparisons));
    write_file(&arguments.out.join("report.json"), json.as_bytes())?;
    write_file(
        &arguments.out.join("report.html"),
        report::html(comparisons, &[]).as_bytes(),
    )
}

/// Without an adapter each scene is solved on the CPU, in a folder of its own.
fn cpu_only(arguments: &Arguments, error: Error) -> Error {
    say!("note: {error}; solving on the CPU, nothing is compared");
    for path in &arguments.scenes {
        let name = path.file_stem().unwrap_or(path.as_os_str());
        if let Err(failure) = solve::on_cpu(path, &arguments.out.join(name), &arguments.common) {
            return failure;
        }
    }
    error
}

fn summary(c: &Comparison) {
    say!(
        "{}: {}",
        c.scene.name,
        if c.agree() {
            "the solvers agree"
        } else {
            "THE SOLVERS DISAGREE"
        }
    );
    say!(
        "  shots {} CPU, {} GPU; lockstep RMS {:.3} %; mismatched {} of {} facing pairs, {} unexplained; {:.1} s CPU, {:.1} s {}",
        c.cpu.shots.len(),
        c.gpu.shots.len(),
        100.0 * c.lockstep_difference.relative_rms,
        c.pairs.mismatched,
        c.pairs.facing,
        c.pairs.unexplained,
        c.seconds[0],
        c.seconds[1],
        c.adapter,
    );
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
