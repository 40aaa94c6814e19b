//! `radiosity stress`.

mod random;

use crate::cli::Outcome;
use crate::cli::console::message;
use crate::cli::progress::{Progress, handle_interrupts, is_interrupted};
use crate::studies::stress::gates::{self, AtlasGate};
use crate::studies::stress::json::{AtlasSummary, atlas_json};
use crate::studies::stress::random::COMMAND_NAME;
use crate::studies::stress::run::AtlasRun;
use crate::studies::stress::score::{self, WarningScore};
use crate::studies::stress::trial::Case;
use crate::studies::stress::{CaseStudy, cases, page};
use clap::Args;
use common::solution::{prepare_directory, write_file};
use common::{Error, Result};
use gpu::Gpu;
use oracle::solve::progress::ProgressMonitor;
use random::RandomOptions;
use std::path::PathBuf;
use std::time::Instant;

/// Largest number of rows of a broken gate printed on stderr; stress.json has all of them.
const MAX_PRINTED_ROWS: usize = 12;

/// Arguments of `stress`.
#[derive(Args)]
pub struct StressArguments {
    /// Names of cases [default: all], or random: scenes drawn at random
    cases: Vec<String>,
    /// Folder for stress.html and stress.json
    #[arg(long, value_name = "DIR", default_value = "out")]
    pub out: PathBuf,
    /// The GPU adapter whose name contains NAME
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
    /// No progress, no summary
    #[arg(long)]
    pub quiet: bool,
    /// Options of random scenes.
    #[command(flatten)]
    pub random: RandomOptions,
}

impl StressArguments {
    /// Opens the adapter; without one returns the error that ends the command after writing.
    pub fn open_gpu(&self) -> Result<(Option<Gpu>, Option<Error>)> {
        match Gpu::open(self.adapter.as_deref()) {
            Ok(gpu) => Ok((Some(gpu), None)),
            Err(error @ Error::NoAdapter(_)) => {
                message!("note: {error}; only the CPU is put to the test");
                Ok((None, Some(error)))
            }
            Err(error) => Err(error),
        }
    }
}

/// Runs the cases and writes the atlas.
pub fn run(arguments: &StressArguments) -> Result<Outcome> {
    let start = Instant::now();
    let random = arguments.cases.iter().any(|name| name == COMMAND_NAME);
    if random && arguments.cases.len() > 1 {
        return Err(Error::Usage(
            "stress random stands alone: leave out the other cases".into(),
        ));
    }
    if !random && arguments.random.is_given() {
        return Err(Error::Usage(
            "--count, --seed, --faces, --kind, --texels, --quality and --cpu are for stress random".into(),
        ));
    }
    let cases = if random {
        Vec::new()
    } else {
        select_cases(&arguments.cases)?
    };
    prepare_directory(&arguments.out)?;
    handle_interrupts();
    if random {
        return random::run(arguments);
    }
    let (gpu, missing) = arguments.open_gpu()?;
    let run = AtlasRun {
        gpu: gpu.as_ref(),
        stop: &is_interrupted,
    };
    let mut studies = Vec::new();
    for case in &cases {
        let progress = Progress::new(case.info.name, arguments.quiet);
        let show = |phase: &str, done| progress.show_phase(phase, done);
        let study = run.run_case(case, &ProgressMonitor::new(&show))?;
        studies.push(study);
        if is_interrupted() {
            break;
        }
    }
    let score = score::score_warnings(&studies);
    let gates = gates::evaluate_gates(&studies, &score);
    let summary = AtlasSummary {
        score: &score,
        gates: &gates,
        adapter: gpu.as_ref().map(|gpu| gpu.line.name.as_str()),
        seconds: start.elapsed().as_secs_f64(),
    };
    write_atlas(arguments, &studies, &summary)?;
    if is_interrupted() {
        message!("interrupted: the atlas holds what was measured by then");
    }
    report_outcome(arguments, &summary, missing)
}

/// Prints the summary and returns the outcome.
///
/// Errors: `missing`, the adapter's.
pub fn report_outcome(arguments: &StressArguments, summary: &AtlasSummary, missing: Option<Error>) -> Result<Outcome> {
    if !arguments.quiet {
        print_summary(summary.gates, summary.score, summary.seconds);
        message!("wrote {0}/stress.html and {0}/stress.json", arguments.out.display());
    }
    match missing {
        Some(error) => Err(error),
        None if summary.gates.iter().all(|gate| gate.held) => Ok(Outcome::Done),
        None => Ok(Outcome::Disagree),
    }
}

/// Returns the cases of these names, or all if there are none.
///
/// Errors: there is no case of a name.
fn select_cases(names: &[String]) -> Result<Vec<&'static Case>> {
    let all = cases::all_cases();
    if names.is_empty() {
        return Ok(all);
    }
    let mut known: Vec<&str> = all.iter().map(|case| case.info.name).collect();
    known.push(COMMAND_NAME);
    if let Some(unknown) = names.iter().find(|name| !known.contains(&name.as_str())) {
        return Err(Error::Usage(format!(
            "there is no case {unknown}: {}",
            known.join(", ")
        )));
    }
    let asked = |case: &&Case| names.iter().any(|name| name == case.info.name);
    Ok(all.into_iter().filter(asked).collect())
}

fn write_atlas(arguments: &StressArguments, studies: &[CaseStudy], summary: &AtlasSummary) -> Result<()> {
    let text = format!("{:#}\n", atlas_json(studies, summary));
    write_file(&arguments.out.join("stress.json"), text.as_bytes())?;
    let page = page::render_page(studies, summary);
    write_file(&arguments.out.join("stress.html"), page.as_bytes())
}

fn print_summary(gates: &[AtlasGate], score: &WarningScore, seconds: f64) {
    for gate in gates.iter().filter(|gate| !gate.held) {
        message!("broken: {}", gate.name);
        for line in gate.broken.iter().take(MAX_PRINTED_ROWS) {
            message!("    {line}");
        }
        if gate.broken.len() > MAX_PRINTED_ROWS {
            message!("    and {} more", gate.broken.len() - MAX_PRINTED_ROWS);
        }
    }
    for (name, counts) in [("default", &score.default), ("all methods", &score.all)] {
        message!(
            "{name}: {} caught, {} missed, {} false alarms, {} quiet",
            counts.caught,
            counts.missed,
            counts.false_alarms,
            counts.quiet
        );
    }
    message!("{seconds:.0} s");
}
