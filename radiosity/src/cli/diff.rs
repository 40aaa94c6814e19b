//! `radiosity diff`.

use super::Outcome;
use super::console::{self, message};
use super::options::parse_percentage;
use crate::diff::page;
use crate::diff::pictures::DiffPictures;
use clap::Args;
use common::Result;
use common::solution::{StoredSolution, prepare_directory, write_file};
use oracle::diff::Diff;
use std::path::PathBuf;

/// Arguments of `diff`.
#[derive(Args)]
pub struct DiffArguments {
    /// A directory with the lightmap.exr and result.json of a solve
    a: PathBuf,
    /// Another of the same scene, taken as the truth
    b: PathBuf,
    /// Folder for diff.html and diff.json
    #[arg(long, value_name = "DIR", default_value = "out")]
    out: PathBuf,
    /// End with exit code 1 when the relative RMS of a channel is above P per cent
    #[arg(long, value_name = "P%", value_parser = parse_percentage, allow_negative_numbers = true)]
    tolerance: Option<f64>,
    /// Also print diff.json as one line on stdout
    #[arg(long)]
    json: bool,
    /// No summary
    #[arg(long)]
    quiet: bool,
}

/// Compares two results and writes the page and its JSON.
pub fn run(arguments: &DiffArguments) -> Result<Outcome> {
    let (a, b) = (StoredSolution::read(&arguments.a)?, StoredSolution::read(&arguments.b)?);
    let diff = Diff::new(&a, &b)?;
    for note in &diff.notes {
        message!("note: {note}");
    }
    prepare_directory(&arguments.out)?;
    let pictures = DiffPictures::new(&a, &b, &diff, ["A", "B"])?;
    let flip = pictures.flip.as_ref().map(|flip| flip.mean);
    let html = page::render_page([&a, &b], &diff, &pictures, arguments.tolerance);
    write_file(&arguments.out.join("diff.html"), html.as_bytes())?;
    let json = diff.to_json(&a, &b, flip);
    let text = format!("{json:#}\n");
    write_file(&arguments.out.join("diff.json"), text.as_bytes())?;
    if arguments.json {
        console::print_json(&json)?;
    }
    if !arguments.quiet {
        print_summary(&diff, flip, arguments);
    }
    Ok(match arguments.tolerance {
        Some(most) if diff.worst_rms() > most => Outcome::Disagree,
        _ => Outcome::Done,
    })
}

fn print_summary(diff: &Diff, flip: Option<f64>, arguments: &DiffArguments) {
    let percent = |channels: [f64; 3]| channels.map(|x| format!("{:.3}", 100.0 * x)).join(" / ");
    message!(
        "relative RMS {} %, bias {} %, largest difference {:.1} % of the rms, FLIP {}",
        percent(diff.relative_rms),
        percent(diff.bias),
        100.0 * diff.max_relative,
        flip.map_or("–".into(), |flip| format!("{flip:.4}")),
    );
    if let Some(error) = diff.standard_error {
        message!("standard error of the truth {} %", percent(error));
    }
    if let Some(most) = arguments.tolerance.filter(|most| diff.worst_rms() > *most) {
        message!(
            "beyond the tolerance: {:.3} % > {:.3} %",
            100.0 * diff.worst_rms(),
            100.0 * most
        );
    }
    message!("wrote {0}/diff.html and {0}/diff.json", arguments.out.display());
}
