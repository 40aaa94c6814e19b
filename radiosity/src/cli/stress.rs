//! `radiosity stress`: the failure atlas, and scenes drawn at random.

use super::Outcome;
use super::console::message;
use super::options::parse_error;
use super::progress::{Progress, handle_interrupts, is_interrupted};
use super::solver::open_adapter;
use crate::studies::random::FaceShapes;
use crate::studies::stress::CaseStudy;
use crate::studies::stress::cases::{ALL_CASES, Case};
use crate::studies::stress::page;
use crate::studies::stress::random::{COMMAND_NAME, DrawnScenes, RandomRequest};
use crate::studies::stress::run::{AtlasRun, MAX_SOLVE_SECONDS};
use crate::studies::stress::summary::Atlas;
use clap::Args;
use common::solution::{prepare_folder, write_files};
use common::{Error, Result};
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
    /// Names of cases [default: all]; or random, and of what: quads, triangles, mixed or meshes
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
    /// random: number of scenes [default: 20]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    count: Option<u64>,
    /// random: seed of the first scene; the next scenes have the next seeds [default: 0]
    // Rows hold seeds as f64, exact up to 2⁵³.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(..=1 << 52))]
    seed: Option<u64>,
    /// random: requested error, 0.2 to 10 [default: 1]
    #[arg(long, value_name = "P%", value_parser = parse_error)]
    error: Option<f64>,
}

/// Runs the cases and writes the atlas.
pub fn run(arguments: &StressArguments) -> Result<Outcome> {
    let start = Instant::now();
    let random = asked_scenes(arguments)?;
    let cases = match random {
        Some(_) => Vec::new(),
        None => asked_cases(arguments)?,
    };
    prepare_folder(&arguments.out, &["stress.json", "stress.html"])?;
    handle_interrupts();
    // Without an adapter the command's error is returned after its files are written.
    let (gpu, missing) = match arguments.solver {
        Some(_) => (None, None),
        None => open_adapter(arguments.adapter.as_deref(), "only the CPU is put to the test")?,
    };
    let run = AtlasRun {
        gpu: gpu.as_ref(),
        stop: &is_interrupted,
        max_seconds: MAX_SOLVE_SECONDS,
        estimates_shooting: true,
    };
    let with_progress = |name: &str, study: &dyn Fn(&ProgressMonitor) -> Result<CaseStudy>| {
        let progress = Progress::new(name);
        study(&ProgressMonitor::new(&|phase, done| progress.show_phase(phase, done)))
    };
    let mut studies = Vec::new();
    for case in cases.into_iter().take_while(|_| !is_interrupted()) {
        studies.push(with_progress(case.name, &|watch| run.run_case(case, watch))?);
    }
    if let Some(request) = random {
        let (seed, count) = (arguments.seed.unwrap_or(0), arguments.count.unwrap_or(DEFAULT_SCENES));
        let study = with_progress(COMMAND_NAME, &|watch| request.run_scenes(&run, seed, count, watch))?;
        if study.rows.is_empty() {
            return Err(Error::Interrupted);
        }
        studies.push(study);
    }
    let adapter = gpu.as_ref().map(|gpu| gpu.line.name.clone());
    let atlas = Atlas::new(studies, adapter, start.elapsed().as_secs_f64());
    let text = format!("{:#}\n", atlas.to_json());
    let files = [("stress.json", text), ("stress.html", page::render_page(&atlas))];
    write_files(&arguments.out, files)?;
    if is_interrupted() {
        message!("interrupted: the atlas holds what was measured by then");
    }
    print_summary(&atlas);
    message!("wrote {0}/stress.html and {0}/stress.json", arguments.out.display());
    match missing {
        Some(error) => Err(error),
        None if atlas.gates.iter().all(|gate| gate.held) => Ok(Outcome::Done),
        None => Ok(Outcome::Disagree),
    }
}

/// Returns the cases by name, or all. Errors: a case is unknown, or an option is for random scenes.
fn asked_cases(arguments: &StressArguments) -> Result<Vec<&'static Case>> {
    let names = &arguments.cases;
    if arguments.count.or(arguments.seed).is_some() || arguments.error.is_some() {
        return Err(Error::Usage("--count, --seed and --error are for stress random".into()));
    }
    let known: Vec<&str> = ALL_CASES.iter().map(|case| case.name).chain([COMMAND_NAME]).collect();
    if let Some(unknown) = names.iter().find(|name| !known.contains(&name.as_str())) {
        return Err(Error::Usage(format!(
            "there is no case {unknown}: {}",
            known.join(", ")
        )));
    }
    let is_asked = |case: &&Case| names.is_empty() || names.iter().any(|name| name == case.name);
    Ok(ALL_CASES.iter().filter(is_asked).collect())
}

/// Returns the random scenes, if they are asked for. Errors: a word beside `random` is unknown.
fn asked_scenes(arguments: &StressArguments) -> Result<Option<RandomRequest>> {
    if arguments.cases.iter().all(|name| name != COMMAND_NAME) {
        return Ok(None);
    }
    let mut request = RandomRequest::default();
    request.error = arguments.error.unwrap_or(request.error);
    for word in &arguments.cases {
        match word.as_str() {
            COMMAND_NAME | "quads" => {}
            "triangles" => request.scenes = DrawnScenes::Rooms(FaceShapes::Triangles),
            "mixed" => request.scenes = DrawnScenes::Rooms(FaceShapes::Mixed),
            "meshes" => request.scenes = DrawnScenes::Meshes,
            other => {
                return Err(Error::Usage(format!(
                    "stress random takes quads, triangles, mixed or meshes, but not {other}"
                )));
            }
        }
    }
    Ok(Some(request))
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
    message!("default: {}", atlas.score.describe_counts());
    if let Some(ratios) = &atlas.estimate {
        message!("{}", ratios.describe_ratios());
    }
    message!("{:.0} s", atlas.seconds);
}
