//! `radiosity stress`.

mod random;

use crate::cli::Outcome;
use crate::cli::progress::{Progress, interrupted, listen};
use crate::cli::tell::say;
use crate::solve::watch::Watch;
use crate::study::stress::gates::{self, Gate};
use crate::study::stress::json::{Told, json};
use crate::study::stress::random::NAME;
use crate::study::stress::run::Run;
use crate::study::stress::score::{self, Score};
use crate::study::stress::trial::Case;
use crate::study::stress::{Study, cases, page};
use clap::Args;
use common::solution::{prepare, write_file};
use common::{Error, Result};
use gpu::Gpu;
use random::Random;
use std::path::PathBuf;
use std::time::Instant;

/// Rows of a broken gate that are named on stderr; stress.json has them all.
const NAMED: usize = 12;

/// Arguments of `stress`.
#[derive(Args)]
pub struct Arguments {
    /// Names of cases [default: all], or random: freshly drawn scenes
    cases: Vec<String>,
    /// Where stress.html and stress.json go
    #[arg(long, value_name = "DIR", default_value = "out")]
    pub out: PathBuf,
    /// The GPU adapter whose name contains NAME
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
    /// No progress, no summary
    #[arg(long)]
    pub quiet: bool,
    /// Of scenes drawn anew
    #[command(flatten)]
    pub random: Random,
}

impl Arguments {
    /// The GPU, or why there is none.
    pub fn device(&self) -> Result<(Option<Gpu>, Option<Error>)> {
        match Gpu::open(self.adapter.as_deref()) {
            Ok(gpu) => Ok((Some(gpu), None)),
            Err(error @ Error::NoAdapter(_)) => {
                say!("note: {error}; only the CPU is put to the test");
                Ok((None, Some(error)))
            }
            Err(error) => Err(error),
        }
    }
}

/// Runs case after case, and writes.
pub fn run(arguments: &Arguments) -> Result<Outcome> {
    let start = Instant::now();
    let random = arguments.cases.iter().any(|name| name == NAME);
    if random && arguments.cases.len() > 1 {
        return Err(Error::Usage(
            "stress random stands alone: leave out the other cases".into(),
        ));
    }
    if !random && arguments.random.given() {
        return Err(Error::Usage(
            "--count, --seed, --faces, --kind, --texels, --quality and --cpu are for stress random"
                .into(),
        ));
    }
    let cases = if random {
        Vec::new()
    } else {
        chosen(&arguments.cases)?
    };
    prepare(&arguments.out)?;
    listen();
    if random {
        return random::run(arguments);
    }
    let (gpu, missing) = arguments.device()?;
    let run = Run {
        gpu: gpu.as_ref(),
        stop: &interrupted,
    };
    let mut studies = Vec::new();
    for case in &cases {
        let progress = Progress::new(case.about.name, arguments.quiet);
        let show = |phase: &str, done| progress.show(phase, done);
        let study = run.case(case, &Watch::new(&show))?;
        studies.push(study);
        if interrupted() {
            break;
        }
    }
    let score = score::of(&studies);
    let gates = gates::of(&studies, &score);
    let told = Told {
        score: &score,
        gates: &gates,
        adapter: gpu.as_ref().map(|gpu| gpu.line.name.as_str()),
        seconds: start.elapsed().as_secs_f64(),
    };
    write(arguments, &studies, &told)?;
    if interrupted() {
        say!("interrupted: the atlas holds what was measured by then");
    }
    finish(arguments, &told, missing)
}

/// Says what was found, and how that ends.
pub fn finish(arguments: &Arguments, told: &Told, missing: Option<Error>) -> Result<Outcome> {
    if !arguments.quiet {
        summary(told.gates, told.score, told.seconds);
        say!(
            "wrote {0}/stress.html and {0}/stress.json",
            arguments.out.display()
        );
    }
    match missing {
        Some(error) => Err(error),
        None if told.gates.iter().all(|gate| gate.held) => Ok(Outcome::Done),
        None => Ok(Outcome::Disagree),
    }
}

/// The cases by name; all of them where none is named.
fn chosen(names: &[String]) -> Result<Vec<&'static Case>> {
    let all = cases::all();
    if names.is_empty() {
        return Ok(all);
    }
    let mut known: Vec<&str> = all.iter().map(|case| case.about.name).collect();
    known.push(NAME);
    if let Some(unknown) = names.iter().find(|name| !known.contains(&name.as_str())) {
        return Err(Error::Usage(format!(
            "there is no case {unknown}: {}",
            known.join(", ")
        )));
    }
    let asked = |case: &&Case| names.iter().any(|name| name == case.about.name);
    Ok(all.into_iter().filter(asked).collect())
}

fn write(arguments: &Arguments, studies: &[Study], told: &Told) -> Result<()> {
    let text = format!("{:#}\n", json(studies, told));
    write_file(&arguments.out.join("stress.json"), text.as_bytes())?;
    let page = page::page(studies, told);
    write_file(&arguments.out.join("stress.html"), page.as_bytes())
}

fn summary(gates: &[Gate], score: &Score, seconds: f64) {
    for gate in gates.iter().filter(|gate| !gate.held) {
        say!("broken: {}", gate.name);
        for line in gate.broken.iter().take(NAMED) {
            say!("    {line}");
        }
        if gate.broken.len() > NAMED {
            say!("    and {} more", gate.broken.len() - NAMED);
        }
    }
    for (name, counts) in [("default", &score.default), ("all methods", &score.all)] {
        say!(
            "{name}: {} caught, {} missed, {} false alarms, {} quiet",
            counts.caught,
            counts.missed,
            counts.false_alarms,
            counts.quiet
        );
    }
    say!("{seconds:.0} s");
}
