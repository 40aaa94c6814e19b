//! `radiosity compare`, and the demo.

use super::bundled::bundled_scene;
use super::console::{self, message};
use super::options::{CommonOptions, ShootingOptions, parse_error, scene_settings, visibility_in_force};
use super::progress::{Progress, handle_interrupts, is_interrupted};
use super::scene::MaterialOptions;
use super::{Outcome, solve};
use crate::report::comparison as report;
use clap::{Args, Parser};
use common::form_factor::FormFactor;
use common::scene::Scene;
use common::settings::{ItemBufferSettings, Meshing, Settings, Visibility};
use common::solution::{prepare_directory, write_file};
use common::{Error, Result};
use gpu::Gpu;
use oracle::compare::comparison::{Comparison, SceneComparison};
use oracle::compare::presets::{PresetSelection, compare_presets};
use oracle::solve::progress::ProgressMonitor;
use oracle::solve::solver::ErrorTarget;
use std::path::{Path, PathBuf};

/// Arguments of `compare`.
#[derive(Args, Clone)]
pub struct CompareArguments {
    /// .obj, .gltf or .glb files
    #[arg(required = true)]
    scenes: Vec<PathBuf>,
    /// Folder for report.html and report.json
    #[arg(long, value_name = "DIR", default_value = "out")]
    out: PathBuf,
    /// Compare only solves to this error, 0.2 to 10 %
    #[arg(long, value_name = "P%", value_parser = parse_error, allow_negative_numbers = true)]
    error: Option<f64>,
    /// Also print report.json as one line on stdout
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    materials: MaterialOptions,
    #[command(flatten)]
    common: CommonOptions,
}

/// Smallest error contribution of a method that the summary prints.
const MIN_PRINTED_FINDING: f64 = 1e-3;

/// A parser of the arguments alone, for the demo's defaults.
#[derive(Parser)]
struct DemoArguments {
    #[command(flatten)]
    arguments: CompareArguments,
}

/// Runs `compare` on the bundled Cornell box.
pub fn run_demo() -> Result<Outcome> {
    let demo = |scene: &Path| DemoArguments::parse_from([Path::new("radiosity"), scene]).arguments;
    let name = Path::new("cornell_box.obj");
    let scene = bundled_scene("cornell_box.obj", &demo(name).out)?;
    run(&demo(&scene))
}

/// Compares the solvers on each scene and writes the report.
pub fn run(arguments: &CompareArguments) -> Result<Outcome> {
    let common = &arguments.common;
    common.refuse_item_buffer_options(visibility_in_force(common, true))?;
    let scenes: Vec<Scene> = arguments
        .scenes
        .iter()
        .map(|path| arguments.materials.load_lit_scene(path, common.import_options()))
        .collect::<Result<_>>()?;
    let selections: Vec<PresetSelection> = scenes
        .iter()
        .map(|scene| select_presets(arguments, scene))
        .collect::<Result<_>>()?;
    prepare_directory(&arguments.out)?;
    handle_interrupts();
    let gpu = match Gpu::open(common.adapter.as_deref()) {
        Ok(gpu) => gpu,
        Err(error @ Error::NoAdapter(_)) => return Err(solve_without_adapter(arguments, error)),
        Err(error) => return Err(error),
    };
    let mut comparisons = Vec::new();
    for (scene, selection) in scenes.iter().zip(&selections) {
        let progress = Progress::new(&scene.name, common.quiet);
        let show = |phase: &str, done| progress.show_phase(phase, done);
        let judged = compare_presets(scene, selection, &gpu, &[], &ProgressMonitor::new(&show));
        progress.clear();
        if is_interrupted() {
            message!(
                "interrupted: the report holds the {} scenes compared by then",
                comparisons.len()
            );
            print_report_json(arguments, &comparisons)?;
            return Ok(Outcome::Disagree);
        }
        let judged = judged?;
        if !common.quiet {
            print_summary(&judged);
        }
        comparisons.push(judged);
        // Written after every scene, so that an interrupted run keeps the scenes that are done.
        write_report(arguments, &comparisons)?;
    }
    if !common.quiet {
        message!("wrote {0}/report.html and {0}/report.json", arguments.out.display());
    }
    print_report_json(arguments, &comparisons)?;
    Ok(if comparisons.iter().all(SceneComparison::all_agree) {
        Outcome::Done
    } else {
        Outcome::Disagree
    })
}

/// Returns the settings to compare: one preset if an option selects the method, else the paper's and the default.
/// Texels, ε and pixels apply to either and select none.
fn select_presets(arguments: &CompareArguments, scene: &Scene) -> Result<PresetSelection> {
    let common = &arguments.common;
    if arguments.error.is_some() {
        common.refuse_shooting_options()?;
    }
    // Scenes of many faces have coarser defaults in either preset.
    let (solve, note) = scene_settings(common, scene, true)?;
    if let Some(note) = note {
        message!("note: {}: {note}", scene.name);
    }
    let target = |error| ErrorTarget {
        error,
        texels: Some(solve.meshing.texels),
    };
    // A quality stands for an error unless an option of shooting is given.
    let error = arguments.error.or(common.quality_error());
    if let (Some(error), true) = (error, arguments.error.is_some() || common.quality.is_some()) {
        return Ok(PresetSelection::ToError(target(error), solve));
    }
    // ε, the number of shots and the size of the item buffer apply to the paper's preset as well.
    let either = CommonOptions {
        shooting: ShootingOptions {
            epsilon: None,
            max_shots: None,
            item_buffer: None,
            ..common.shooting.clone()
        },
        ..common.clone()
    };
    let Some(error) = either.quality_error().filter(|_| common.quality.is_none()) else {
        return Ok(PresetSelection::Shooting(solve));
    };
    let paper = Settings {
        meshing: Meshing {
            texels: solve.meshing.texels,
            patches: 1,
            samples: 1,
        },
        ..common.shot_settings(Visibility::ItemBuffer(ItemBufferSettings::DEFAULT), FormFactor::Disc)?
    };
    Ok(PresetSelection::PaperAndDefault {
        paper,
        target: target(error),
    })
}

fn write_report(arguments: &CompareArguments, comparisons: &[SceneComparison]) -> Result<()> {
    let json = format!("{:#}\n", report::report_json(comparisons));
    write_file(&arguments.out.join("report.json"), json.as_bytes())?;
    write_file(
        &arguments.out.join("report.html"),
        report::render_report(comparisons, &[]).as_bytes(),
    )
}

/// Prints the report's JSON on stdout under `--json`.
fn print_report_json(arguments: &CompareArguments, comparisons: &[SceneComparison]) -> Result<()> {
    if arguments.json {
        console::print_json(&report::report_json(comparisons))?;
    }
    Ok(())
}

/// Solves each scene on the CPU into a folder of its own, for want of an adapter. Returns the command's error.
fn solve_without_adapter(arguments: &CompareArguments, error: Error) -> Error {
    message!("note: {error}; each scene is only solved, on the CPU");
    for path in &arguments.scenes {
        let name = path.file_stem().unwrap_or(path.as_os_str());
        if let Err(failure) = solve::solve_on_cpu(
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

/// Prints the verdict and the error of both solvers: agreement is not accuracy.
fn print_summary(judged: &SceneComparison) {
    let name = &judged.first.scene.name;
    for c in judged.iter_comparisons() {
        let verdict = if c.solvers_agree() {
            "the solvers agree"
        } else {
            "THE SOLVERS DISAGREE"
        };
        message!("{name}, {}: {verdict}; {}", c.preset.name(), describe_accuracy(c));
        let (shots, pairs) = match c.error_target {
            Some(target) => (format!("requested {:.2} %", 100.0 * target.error), "blocks of links"),
            None => (
                format!("shots {} CPU, {} GPU", c.cpu.shooters, c.gpu.shooters),
                "facing pairs",
            ),
        };
        message!(
            "  {shots}; lockstep RMS {:.3} %; mismatched {} of {} {pairs}, {} unexplained; {:.1} s CPU, {:.1} s {}",
            100.0 * c.lockstep_difference.relative_rms,
            c.pairs.mismatched,
            c.pairs.facing,
            c.pairs.unexplained,
            c.seconds[0],
            c.seconds[1],
            c.adapter,
        );
        for finding in c.findings.iter().filter(|f| f.value > MIN_PRINTED_FINDING) {
            message!("  {}: {}", finding.name, finding.message);
        }
        for gate in c.criteria.iter().filter(|gate| !gate.pass) {
            message!(
                "  beyond its bound: {} = {:.3e} > {:.3e} ({})",
                gate.name,
                gate.value,
                gate.bound,
                gate.reason
            );
        }
    }
}

fn describe_accuracy(c: &Comparison) -> String {
    match (&c.truth, c.truth_error) {
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
