//! `radiosity check`: gathers the light of a result again and reports how far off it is.

use super::Outcome;
use super::console::message;
use super::diff::JudgementOptions;
use super::progress::{Progress, handle_interrupts};
use crate::diff::page;
use crate::diff::pictures::DiffPictures;
use clap::Args;
use common::Result;
use common::import::{ImportOptions, load_scene};
use common::solution::StoredSolution;
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
    scene: Option<PathBuf>,
    #[command(flatten)]
    judgement: JudgementOptions,
}

/// Judges a result and writes the page and its JSON.
pub fn run(arguments: &CheckArguments) -> Result<Outcome> {
    let judgement = &arguments.judgement;
    let stored = StoredSolution::read(&arguments.dir)?;
    let read = |path: &PathBuf| load_scene(path, &ImportOptions::default());
    let scene = arguments.scene.as_ref().map(read).transpose()?;
    judgement.prepare_folder("check")?;
    handle_interrupts();
    let name = &stored.scene.name;
    let progress = Progress::new(name);
    let show = |phase: &str, done| progress.show_phase(phase, done);
    let judged = judge_result(&stored, scene, &ProgressMonitor::new(&show))?;
    progress.remove_bar();
    let JudgedResult { truth, diff, .. } = &judged;
    for note in &diff.notes {
        message!("note: {note}");
    }
    let pictures = DiffPictures::new(&stored, truth, diff, ["A, the result", "B, gathered again"])?;
    let mut json = diff.to_json(&stored, truth, pictures.flip);
    let html = page::render_page([&stored, truth], (diff, pictures), Some(&judged), judgement.tolerance);
    json["scene"] = name.clone().into();
    json["estimated_error"] = judged.error().into();
    json["one_bounce"] = judged.one_bounce.into();
    json["floor"] = GATHER_ERROR.into();
    json["energy"] = json!(judged.energy);
    let summary = format!(
        "{name}: {:.2} % off; light gathered again differs by {:.2} % (below {:.1} % is within the noise); imbalance {:.1e}",
        100.0 * judged.error(),
        100.0 * judged.one_bounce,
        100.0 * GATHER_ERROR,
        judged.energy.imbalance
    );
    judgement.write_results("check", (&html, &json), &summary, judged.error())
}
