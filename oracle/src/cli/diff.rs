//! `radiosity diff`.

use super::Outcome;
use super::options::percentage;
use super::tell::{self, say};
use crate::judge::diff::pictures::Pictures;
use crate::judge::diff::{Diff, page};
use clap::Args;
use common::Result;
use common::solution::{Stored, prepare, write_file};
use std::path::PathBuf;

/// Arguments of `diff`.
#[derive(Args)]
pub struct Arguments {
    /// A directory with the lightmap.exr and result.json of a solve
    a: PathBuf,
    /// Another, of the same scene, taken as the truth
    b: PathBuf,
    /// Where diff.html and diff.json go
    #[arg(long, value_name = "DIR", default_value = "out")]
    out: PathBuf,
    /// End with exit code 1 when the relative RMS of a channel is above P per cent
    #[arg(long, value_name = "P%", value_parser = percentage, allow_negative_numbers = true)]
    tolerance: Option<f64>,
    /// What diff.json has, as one line on stdout
    #[arg(long)]
    json: bool,
    /// No summary
    #[arg(long)]
    quiet: bool,
}

/// Compares and writes.
pub fn run(arguments: &Arguments) -> Result<Outcome> {
    let (a, b) = (Stored::read(&arguments.a)?, Stored::read(&arguments.b)?);
    let diff = Diff::new(&a, &b)?;
    for note in &diff.notes {
        say!("note: {note}");
    }
    prepare(&arguments.out)?;
    let pictures = Pictures::new(&a, &b, &diff, ["A", "B"])?;
    let flip = pictures.flip.as_ref().map(|flip| flip.mean);
    let html = page::html([&a, &b], &diff, &pictures, arguments.tolerance);
    write_file(&arguments.out.join("diff.html"), html.as_bytes())?;
    let json = diff.json(&a, &b, flip);
    let text = format!("{json:#}\n");
    write_file(&arguments.out.join("diff.json"), text.as_bytes())?;
    if arguments.json {
        tell::json(&json)?;
    }
    if !arguments.quiet {
        summary(&diff, flip, arguments);
    }
    Ok(match arguments.tolerance {
        Some(most) if diff.worst() > most => Outcome::Disagree,
        _ => Outcome::Done,
    })
}

fn summary(diff: &Diff, flip: Option<f64>, arguments: &Arguments) {
    let percent = |channels: [f64; 3]| channels.map(|x| format!("{:.3}", 100.0 * x)).join(" / ");
    say!(
        "relative RMS {} %, bias {} %, largest difference {:.1} % of the rms, FLIP {}",
        percent(diff.relative_rms),
        percent(diff.bias),
        100.0 * diff.max_relative,
        flip.map_or("–".into(), |flip| format!("{flip:.4}")),
    );
    if let Some(error) = diff.standard_error {
        say!("standard error of the truth {} %", percent(error));
    }
    if let Some(most) = arguments.tolerance.filter(|most| diff.worst() > *most) {
        say!(
            "beyond the tolerance: {:.3} % > {:.3} %",
            100.0 * diff.worst(),
            100.0 * most
        );
    }
    say!(
        "wrote {0}/diff.html and {0}/diff.json",
        arguments.out.display()
    );
}
