//! `radiosity stress`.

use super::Outcome;
use super::progress::{Progress, interrupted, listen};
use super::tell::say;
use crate::stress::gates::{self, Gate};
use crate::stress::json::{Told, json};
use crate::stress::run::Run;
use crate::stress::score::{self, Score};
use crate::stress::trial::Case;
use crate::stress::{Study, cases, page};
use clap::Args;
use common::solution::{prepare, write_file};
use common::{Error, Result};
use gpu::Gpu;
use std::path::PathBuf;
use std::time::Instant;

/// Rows of a broken gate that are named on stderr; stress.json has them all.
const NAMED: usize = 12;

/// Arguments of `stress`.
#[derive(Args)]
pub struct Arguments {
    /// Names of cases [default: all]
    cases: Vec<String>,
    /// Where stress.html and stress.json go
    #[arg(long, value_name = "DIR", default_value = "out")]
    out: PathBuf,
    /// The GPU adapter whose name contains NAME
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
    /// No progress, no summary
    #[arg(long)]
    quiet: bool,
}

/// Runs case after case, and writes.
pub fn run(arguments: &Arguments) -> Result<Outcome> {
    let start = Instant::now();
    let cases = chosen(&arguments.cases)?;
    prepare(&arguments.out)?;
    let (gpu, missing) = match Gpu::open(arguments.adapter.as_deref()) {
        Ok(gpu) => (Some(gpu), None),
        Err(error @ Error::NoAdapter(_)) => {
            say!("note: {error}; only the CPU is put to the test");
            (None, Some(error))
        }
        Err(error) => return Err(error),
    };
    listen();
    let run = Run {
        gpu: gpu.as_ref(),
        stop: &interrupted,
    };
    let mut studies = Vec::new();
    for case in &cases {
        let mut progress = Progress::new(case.about.name, arguments.quiet);
        let study = run.case(case, &mut |done, all| {
            // Ctrl-C is asked for by the run itself.
            let _ = progress.show(case.about.parameter, done, all);
        })?;
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
        say!("interrupted: the atlas holds what is measured");
    }
    if !arguments.quiet {
        summary(&gates, &score, told.seconds);
        say!(
            "wrote {0}/stress.html and {0}/stress.json",
            arguments.out.display()
        );
    }
    match missing {
        Some(error) => Err(error),
        None if gates.iter().all(|gate| gate.held) => Ok(Outcome::Done),
        None => Ok(Outcome::Disagree),
    }
}

/// The cases by name; all of them where none is named.
fn chosen(names: &[String]) -> Result<Vec<&'static Case>> {
    let all = cases::all();
    if names.is_empty() {
        return Ok(all);
    }
    let known: Vec<&str> = all.iter().map(|case| case.about.name).collect();
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
