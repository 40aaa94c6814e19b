//! `radiosity check`.

use super::Outcome;
use super::console::{self, message};
use super::options::parse_percentage;
use super::progress::{Progress, handle_interrupts};
use super::scene::MaterialOptions;
use crate::diff::page;
use crate::diff::pictures::DiffPictures;
use clap::Args;
use common::import::ImportOptions;
use common::solution::{StoredSolution, prepare_directory, write_file};
use common::{Error, Result};
use oracle::solve::progress::ProgressMonitor;
use oracle::solve::residual::{GATHER_ERROR, JudgedResult, judge_result};
use serde_json::json;
use std::path::PathBuf;

/// Arguments of `check`.
#[derive(Args)]
pub struct CheckArguments {
    /// A directory with lightmap.exr and result.json, of a solve or of another program
    dir: PathBuf,
    /// The scene, for reflectance and emission that result.json does not have
    #[arg(long, value_name = "SCENE")]
    scene: Option<PathBuf>,
    #[command(flatten)]
    materials: MaterialOptions,
    /// Folder for check.html and check.json
    #[arg(long, value_name = "DIR", default_value = "out")]
    out: PathBuf,
    /// End with exit code 1 when the error is above P per cent
    #[arg(long, value_name = "P%", value_parser = parse_percentage, allow_negative_numbers = true)]
    tolerance: Option<f64>,
    /// Also print check.json as one line on stdout
    #[arg(long)]
    json: bool,
    /// No progress, no summary
    #[arg(long)]
    quiet: bool,
}

/// Judges a result and writes the page and its JSON.
pub fn run(arguments: &CheckArguments) -> Result<Outcome> {
    let materials = &arguments.materials;
    if arguments.scene.is_none() && materials.is_given() {
        return Err(Error::Usage(
            "--reflectance applies to --scene SCENE: give that too, or leave it out".into(),
        ));
    }
    let stored = StoredSolution::read(&arguments.dir)?;
    let read = |path: &PathBuf| materials.load_scene(path, ImportOptions::default());
    let scene = arguments.scene.as_ref().map(read);
    let scene = scene.transpose()?;
    prepare_directory(&arguments.out)?;
    handle_interrupts();
    let progress = Progress::new(&stored.scene.name, arguments.quiet);
    let show = |phase: &str, done| progress.show_phase(phase, done);
    let judged = judge_result(&stored, scene, &ProgressMonitor::new(&show))?;
    progress.clear();
    let JudgedResult { truth, diff, .. } = &judged;
    for note in &diff.notes {
        message!("note: {note}");
    }
    let pictures = DiffPictures::new(&stored, truth, diff, ["A, the result", "B, gathered again"])?;
    let found = (diff, judged.one_bounce, &judged.energy);
    let html = page::render_check_page(&stored, found, &pictures, arguments.tolerance);
    write_file(&arguments.out.join("check.html"), html.as_bytes())?;
    let json = describe_check(&stored, &judged, &pictures);
    let text = format!("{json:#}\n");
    write_file(&arguments.out.join("check.json"), text.as_bytes())?;
    if arguments.json {
        console::print_json(&json)?;
    }
    if !arguments.quiet {
        message!(
            "{}: {:.2} % off; light gathered again differs by {:.2} % (below {:.1} % is within the noise); imbalance {:.1e}",
            stored.scene.name,
            100.0 * diff.worst_rms(),
            100.0 * judged.one_bounce,
            100.0 * GATHER_ERROR,
            judged.energy.imbalance
        );
        message!("wrote check.html and check.json in {}", arguments.out.display());
    }
    Ok(match arguments.tolerance {
        Some(most) if diff.worst_rms() > most => Outcome::Disagree,
        _ => Outcome::Done,
    })
}

fn describe_check(stored: &StoredSolution, judged: &JudgedResult, pictures: &DiffPictures) -> serde_json::Value {
    let flip = pictures.flip.as_ref().map(|flip| flip.mean);
    let mut json = judged.diff.to_json(stored, &judged.truth, flip);
    json["scene"] = stored.scene.name.clone().into();
    json["estimated_error"] = judged.diff.worst_rms().into();
    json["one_bounce"] = judged.one_bounce.into();
    json["floor"] = GATHER_ERROR.into();
    json["energy"] = json!(judged.energy);
    json
}
