//! `radiosity stress`: the failure atlas, and scenes drawn at random.

use super::Outcome;
use super::console::message;
use super::progress::{Progress, handle_interrupts, is_interrupted};
use crate::studies::random::{FaceShapes, SceneKind};
use crate::studies::stress::cases::{CASES, Case};
use crate::studies::stress::page;
use crate::studies::stress::random::{COMMAND_NAME, RandomRequest};
use crate::studies::stress::run::AtlasRun;
use crate::studies::stress::summary::Atlas;
use clap::Args;
use common::solution::{prepare_directory, write_file};
use common::{Error, Result};
use gpu::Gpu;
use oracle::solve::progress::ProgressMonitor;
use std::path::PathBuf;
use std::time::Instant;

/// Largest number of rows of a broken gate printed on stderr; stress.json has all of them.
const MAX_PRINTED_ROWS: usize = 12;
/// Default number of random scenes.
const DEFAULT_SCENES: u64 = 20;

/// Arguments of `stress`.
#[derive(Args)]
pub struct StressArguments {
    /// Names of cases [default: all]; or random, and of what: quads, triangles or mixed; room
    cases: Vec<String>,
    /// cpu: no solves on the GPU [default: both]
    #[arg(long, value_name = "SOLVER", value_parser = ["cpu"])]
    solver: Option<String>,
    /// Folder for stress.html and stress.json
    #[arg(long, value_name = "DIR", default_value = "out")]
    out: PathBuf,
    /// The GPU adapter whose name contains NAME
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
    /// No progress, no summary
    #[arg(long)]
    quiet: bool,
    #[command(flatten)]
    random: RandomOptions,
}

/// Options of `stress random`.
#[derive(Args, Default, PartialEq)]
struct RandomOptions {
    /// random: number of scenes [default: 20]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    count: Option<u64>,
    /// random: seed of the first scene; the next scenes have the next seeds [default: 0]
    // Rows hold seeds as f64, exact up to 2⁵³.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(..=1 << 52))]
    seed: Option<u64>,
    /// random: quality of the solves, normal or reference [default: normal]
    #[arg(long, value_name = "QUALITY", value_parser = ["normal", "reference"])]
    quality: Option<String>,
}

/// Scenes that a command line asks for.
enum StressScenes {
    Cases(Vec<&'static Case>),
    Random(RandomRequest),
}

/// Runs the cases and writes the atlas.
pub fn run(arguments: &StressArguments) -> Result<Outcome> {
    let start = Instant::now();
    let asked = asked_scenes(arguments)?;
    prepare_directory(&arguments.out)?;
    handle_interrupts();
    let (gpu, missing) = open_gpu(arguments)?;
    let run = AtlasRun {
        gpu: gpu.as_ref(),
        stop: &is_interrupted,
    };
    let mut studies = Vec::new();
    match asked {
        StressScenes::Cases(cases) => {
            for case in cases.into_iter().take_while(|_| !is_interrupted()) {
                let progress = Progress::new(case.name, arguments.quiet);
                let show = |phase: &str, done| progress.show_phase(phase, done);
                studies.push(run.run_case(case, &ProgressMonitor::new(&show))?);
            }
        }
        StressScenes::Random(request) => {
            let progress = Progress::new(COMMAND_NAME, arguments.quiet);
            let show = |phase: &str, done| progress.show_phase(phase, done);
            let seed = arguments.random.seed.unwrap_or(0);
            let count = arguments.random.count.unwrap_or(DEFAULT_SCENES);
            let study = request.run_scenes(&run, seed, count, &ProgressMonitor::new(&show))?;
            if study.rows.is_empty() {
                return Err(Error::Interrupted);
            }
            studies.push(study);
        }
    }
    let adapter = gpu.as_ref().map(|gpu| gpu.line.name.clone());
    let atlas = Atlas::new(studies, adapter, start.elapsed().as_secs_f64());
    let text = format!("{:#}\n", atlas.to_json());
    write_file(&arguments.out.join("stress.json"), text.as_bytes())?;
    write_file(&arguments.out.join("stress.html"), page::render_page(&atlas).as_bytes())?;
    if is_interrupted() {
        message!("interrupted: the atlas holds what was measured by then");
    }
    if !arguments.quiet {
        print_summary(&atlas);
        message!("wrote {0}/stress.html and {0}/stress.json", arguments.out.display());
    }
    match missing {
        Some(error) => Err(error),
        None if atlas.gates.iter().all(|gate| gate.held) => Ok(Outcome::Done),
        None => Ok(Outcome::Disagree),
    }
}

/// Reads the names of the cases and the options of random scenes. Errors: a case or a combination is unknown.
fn asked_scenes(arguments: &StressArguments) -> Result<StressScenes> {
    let (names, options) = (&arguments.cases, &arguments.random);
    let usage = |text: String| Err(Error::Usage(text));
    if names.iter().any(|name| name == COMMAND_NAME) {
        return parse_random_request(names, options.quality.as_deref()).map(StressScenes::Random);
    }
    if *options != RandomOptions::default() {
        return usage("--count, --seed and --quality are for stress random".into());
    }
    let known: Vec<&str> = CASES.iter().map(|case| case.name).chain([COMMAND_NAME]).collect();
    if let Some(unknown) = names.iter().find(|name| !known.contains(&name.as_str())) {
        return usage(format!("there is no case {unknown}: {}", known.join(", ")));
    }
    let is_asked = |case: &&Case| names.is_empty() || names.iter().any(|name| name == case.name);
    Ok(StressScenes::Cases(CASES.iter().filter(is_asked).collect()))
}

/// Reads the words beside `random`. Errors: a word is unknown.
fn parse_random_request(words: &[String], quality: Option<&str>) -> Result<RandomRequest> {
    let mut request = RandomRequest {
        reference: quality == Some("reference"),
        ..RandomRequest::default()
    };
    for word in words {
        match word.as_str() {
            COMMAND_NAME | "quads" => {}
            "triangles" => request.options.faces = FaceShapes::Triangles,
            "mixed" => request.options.faces = FaceShapes::Mixed,
            "room" => request.options.kind = SceneKind::Room,
            other => {
                return Err(Error::Usage(format!(
                    "stress random takes quads, triangles or mixed, and room, but not {other}"
                )));
            }
        }
    }
    Ok(request)
}

/// Opens the adapter; without one returns the error that ends the command after writing.
fn open_gpu(arguments: &StressArguments) -> Result<(Option<Gpu>, Option<Error>)> {
    if arguments.solver.is_some() {
        return Ok((None, None));
    }
    match Gpu::open(arguments.adapter.as_deref()) {
        Ok(gpu) => Ok((Some(gpu), None)),
        Err(error @ Error::NoAdapter(_)) => {
            message!("note: {error}; only the CPU is put to the test");
            Ok((None, Some(error)))
        }
        Err(error) => Err(error),
    }
}

fn print_summary(atlas: &Atlas) {
    for gate in atlas.gates.iter().filter(|gate| !gate.held) {
        message!("broken: {}", gate.name);
        for line in gate.broken.iter().take(MAX_PRINTED_ROWS) {
            message!("    {line}");
        }
        if gate.broken.len() > MAX_PRINTED_ROWS {
            message!("    and {} more", gate.broken.len() - MAX_PRINTED_ROWS);
        }
    }
    for (name, counts) in [("default", &atlas.score.default), ("all methods", &atlas.score.all)] {
        message!(
            "{name}: {} caught, {} missed, {} false alarms, {} quiet",
            counts.caught,
            counts.missed,
            counts.false_alarms,
            counts.quiet
        );
    }
    if let Some(ratios) = &atlas.estimate {
        message!(
            "estimate over error, {} answers: median {:.2}, below half {:.1} %, above three times {:.1} %",
            ratios.answers,
            ratios.median,
            100.0 * ratios.below,
            100.0 * ratios.above
        );
    }
    message!("{:.0} s", atlas.seconds);
}
