//! `radiosity check`.

use super::Outcome;
use super::options::percentage;
use super::progress::{Progress, listen};
use super::scene::Materials;
use super::tell::{self, say};
use crate::judge::diff::page;
use crate::judge::diff::pictures::Pictures;
use crate::solve::anew::{FLOOR, Judged, judge};
use crate::solve::watch::Watch;
use clap::Args;
use common::import::ImportOptions;
use common::solution::{Stored, prepare, write_file};
use common::{Error, Result};
use serde_json::json;
use std::path::PathBuf;

/// Arguments of `check`.
#[derive(Args)]
pub struct Arguments {
    /// A directory with lightmap.exr and result.json, of a solve or of another program
    dir: PathBuf,
    /// What its faces reflect and emit, where result.json does not say
    #[arg(long, value_name = "SCENE")]
    scene: Option<PathBuf>,
    #[command(flatten)]
    materials: Materials,
    /// Where check.html and check.json go
    #[arg(long, value_name = "DIR", default_value = "out")]
    out: PathBuf,
    /// End with exit code 1 when the error is above P per cent
    #[arg(long, value_name = "P%", value_parser = percentage, allow_negative_numbers = true)]
    tolerance: Option<f64>,
    /// What check.json has, as one line on stdout
    #[arg(long)]
    json: bool,
    /// No progress, no summary
    #[arg(long)]
    quiet: bool,
}

/// Judges and writes.
pub fn run(arguments: &Arguments) -> Result<Outcome> {
    let materials = &arguments.materials;
    if arguments.scene.is_none() && materials.any() {
        return Err(Error::Usage(
            "--reflectance applies to --scene SCENE: give that too, or leave it out".into(),
        ));
    }
    let stored = Stored::read(&arguments.dir)?;
    let read = |path: &PathBuf| materials.load(path, ImportOptions::default());
    let scene = arguments.scene.as_ref().map(read);
    let scene = scene.transpose()?;
    prepare(&arguments.out)?;
    listen();
    let progress = Progress::new(&stored.scene.name, arguments.quiet);
    let show = |phase: &str, done| progress.show(phase, done);
    let judged = judge(&stored, scene, &Watch::new(&show))?;
    progress.clear();
    let Judged { truth, diff, .. } = &judged;
    for note in &diff.notes {
        say!("note: {note}");
    }
    let pictures = Pictures::new(&stored, truth, diff, ["A, the result", "B, gathered anew"])?;
    let found = (diff, judged.one_bounce, &judged.energy);
    let html = page::checked(&stored, found, &pictures, arguments.tolerance);
    write_file(&arguments.out.join("check.html"), html.as_bytes())?;
    let json = described(&stored, &judged, &pictures);
    let text = format!("{json:#}\n");
    write_file(&arguments.out.join("check.json"), text.as_bytes())?;
    if arguments.json {
        tell::json(&json)?;
    }
    if !arguments.quiet {
        say!(
            "{}: {:.2} % off; light gathered anew differs by {:.2} % (less than {:.1} % cannot be told from nothing); imbalance {:.1e}",
            stored.scene.name,
            100.0 * diff.worst(),
            100.0 * judged.one_bounce,
            100.0 * FLOOR,
            judged.energy.imbalance
        );
        say!(
            "wrote check.html and check.json in {}",
            arguments.out.display()
        );
    }
    Ok(match arguments.tolerance {
        Some(most) if diff.worst() > most => Outcome::Disagree,
        _ => Outcome::Done,
    })
}

fn described(stored: &Stored, judged: &Judged, pictures: &Pictures) -> serde_json::Value {
    let flip = pictures.flip.as_ref().map(|flip| flip.mean);
    let mut json = judged.diff.json(stored, &judged.truth, flip);
    json["scene"] = stored.scene.name.clone().into();
    json["estimated_error"] = judged.diff.worst().into();
    json["one_bounce"] = judged.one_bounce.into();
    json["floor"] = FLOOR.into();
    json["energy"] = json!(judged.energy);
    json
}
