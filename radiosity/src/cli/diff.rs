//! `radiosity diff`: compares two results; and what it shares with `check`.

use super::Outcome;
use super::console::message;
use super::options::parse_percentage;
use crate::diff::page;
use crate::diff::pictures::DiffPictures;
use clap::Args;
use common::Result;
use common::solution::{StoredSolution, prepare_folder, write_files};
use oracle::diff::Diff;
use serde_json::Value;
use std::path::PathBuf;

/// Arguments of `diff`.
#[derive(Args)]
pub struct DiffArguments {
    /// A directory with the lightmap.exr and result.json of a solve
    a: PathBuf,
    /// Another of the same scene, taken as the truth
    b: PathBuf,
    #[command(flatten)]
    judgement: JudgementOptions,
}

/// Options of the commands that judge a result.
#[derive(Args)]
pub struct JudgementOptions {
    /// Folder for the page and its JSON
    #[arg(long, value_name = "DIR", default_value = "out")]
    out: PathBuf,
    /// End with exit code 1 when the relative RMS error of a channel is above P per cent
    #[arg(long, value_name = "P%", value_parser = parse_percentage)]
    pub tolerance: Option<f64>,
}

/// Returns the names of the page and its JSON.
fn output_names(name: &str) -> [String; 2] {
    ["html", "json"].map(|ending| format!("{name}.{ending}"))
}

impl JudgementOptions {
    /// Prepares the folder for NAME.html and NAME.json.
    ///
    /// Errors: they cannot be written, or would replace an input.
    pub fn prepare_folder(&self, name: &str) -> Result<()> {
        prepare_folder(&self.out, &output_names(name).each_ref().map(String::as_str))
    }

    /// Writes NAME.html and NAME.json, prints `summary` and compares the error with the tolerance.
    ///
    /// Errors: the files cannot be written.
    pub fn write_results(
        &self,
        name: &str,
        (html, json): (&str, &Value),
        summary: &str,
        error: f64,
    ) -> Result<Outcome> {
        let out = &self.out;
        write_files(
            out,
            output_names(name)
                .into_iter()
                .zip([html.to_owned(), format!("{json:#}\n")]),
        )?;
        let exceeded = self.tolerance.filter(|most| error > *most);
        message!("{summary}");
        if let Some(most) = exceeded {
            message!("beyond the tolerance: {:.3} % > {:.3} %", 100.0 * error, 100.0 * most);
        }
        message!("wrote {name}.html and {name}.json in {}", out.display());
        Ok(exceeded.map_or(Outcome::Done, |_| Outcome::Disagree))
    }
}

/// Compares two results and writes the page and its JSON.
pub fn run(arguments: &DiffArguments) -> Result<Outcome> {
    let (a, b) = (StoredSolution::read(&arguments.a)?, StoredSolution::read(&arguments.b)?);
    let diff = Diff::new(&a, &b)?;
    let judgement = &arguments.judgement;
    judgement.prepare_folder("diff")?;
    for note in &diff.notes {
        message!("note: {note}");
    }
    let pictures = DiffPictures::new(&a, &b, &diff, ["A", "B"])?;
    let flip = pictures.flip;
    let html = page::render_page([&a, &b], (&diff, pictures), None, judgement.tolerance);
    let percent = |channels: [f64; 3]| channels.map(|x| format!("{:.3}", 100.0 * x)).join(" / ");
    let noise = diff.standard_error.map(percent);
    let summary = format!(
        "relative RMS {} %, bias {} %, largest difference {:.1} % of the rms, FLIP {}{}",
        percent(diff.relative_rms),
        percent(diff.bias),
        100.0 * diff.max_relative,
        flip.map_or("–".into(), |flip| format!("{flip:.4}")),
        noise.map_or(String::new(), |error| format!(
            ", standard error of the truth {error} %"
        )),
    );
    let json = diff.to_json(&a, &b, flip);
    judgement.write_results("diff", (&html, &json), &summary, diff.worst_rms())
}
