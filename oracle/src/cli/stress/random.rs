//! `radiosity stress random`: freshly drawn scenes.

use super::{Arguments, finish};
use crate::cli::Outcome;
use crate::cli::options::QualityOption;
use crate::cli::progress::{Progress, interrupted};
use crate::cli::tell::say;
use crate::solve::watch::Watch;
use crate::study::random::{Faces, Kind, Options};
use crate::study::stress::json::{Told, json};
use crate::study::stress::random::{self, Asked, CASE, Findings, Found, NAME, gates, page, ratio};
use crate::study::stress::run::Run;
use crate::study::stress::{Study, score};
use clap::{Args, ValueEnum};
use common::settings::Quality;
use common::solution::write_file;
use common::{Error, Result};
use serde_json::{Value, json};
use std::time::Instant;

/// Scenes, unless others are asked for.
const COUNT: u64 = 20;

/// Options of `stress random`.
#[derive(Args)]
pub struct Random {
    /// random: how many scenes [default: 20]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    count: Option<u64>,
    /// random: the seed of the first; the next ones follow [default: 0]
    // Rows hold it as a number: above 2⁵³ they would round it.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(..=1 << 52))]
    seed: Option<u64>,
    /// random: what the faces are [default: quads]
    #[arg(long, value_enum)]
    faces: Option<FacesOption>,
    /// random: which rooms are drawn [default: any]
    #[arg(long, value_enum)]
    kind: Option<KindOption>,
    /// random: texels per side of a face [default: 8]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=64))]
    texels: Option<u32>,
    /// random: normal or reference [default: normal]
    #[arg(long, value_enum)]
    quality: Option<QualityOption>,
    /// random: leave the GPU out
    #[arg(long)]
    cpu: bool,
}

/// `--faces`.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum FacesOption {
    /// Quads
    Quads,
    /// Each quad as two triangles, their corners turned at random
    Triangles,
    /// Some of each
    Mixed,
}

/// `--kind`.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum KindOption {
    /// Everything that can be drawn
    Any,
    /// Boxes with turned boxes that stand and hang in them, two of three closed
    Room,
}

impl Random {
    /// Whether any of them was given.
    pub fn given(&self) -> bool {
        let numbers = self.count.is_some() || self.seed.is_some() || self.texels.is_some();
        let choices = self.faces.is_some() || self.kind.is_some() || self.quality.is_some();
        numbers || choices || self.cpu
    }

    fn asked(&self) -> Result<Asked> {
        let quality = self.quality.map_or(Quality::Normal, Into::into);
        if quality == Quality::Draft {
            return Err(Error::Usage(
                "stress random: --quality is normal or reference".into(),
            ));
        }
        Ok(Asked {
            options: Options {
                kind: match self.kind {
                    Some(KindOption::Room) => Kind::Room,
                    _ => Kind::Any,
                },
                faces: match self.faces {
                    Some(FacesOption::Triangles) => Faces::Triangles,
                    Some(FacesOption::Mixed) => Faces::Mixed,
                    _ => Faces::Quads,
                },
            },
            texels: self.texels.unwrap_or(random::TEXELS),
            quality,
            paths: match quality {
                Quality::Reference => random::FINER_PATHS,
                _ => random::PATHS,
            },
        })
    }
}

/// Draws, solves and writes.
pub fn run(arguments: &Arguments) -> Result<Outcome> {
    let start = Instant::now();
    let asked = arguments.random.asked()?;
    let (gpu, missing) = if arguments.random.cpu {
        (None, None)
    } else {
        arguments.device()?
    };
    let run = Run {
        gpu: gpu.as_ref(),
        stop: &interrupted,
    };
    let range = (
        arguments.random.seed.unwrap_or(0),
        arguments.random.count.unwrap_or(COUNT),
    );
    let progress = Progress::new(NAME, arguments.quiet);
    let show = |phase: &str, done| progress.show(phase, done);
    let findings = Findings::gather(&run, &asked, range, &Watch::new(&show))?;
    progress.clear();
    if findings.all.is_empty() {
        return Err(Error::Interrupted);
    }
    let ratios = findings.ratios();
    let study = [Study {
        about: CASE.about,
        rows: findings.all.iter().map(|found| found.row.clone()).collect(),
        specimen: None,
    }];
    let score = score::of(&study);
    let gates = gates::of(&findings, &ratios);
    let told = Told {
        score: &score,
        gates: &gates,
        adapter: gpu.as_ref().map(|gpu| gpu.line.name.as_str()),
        seconds: start.elapsed().as_secs_f64(),
    };
    let mut found = json(&study, &told);
    found["estimate"] = json!(ratios);
    found["scenes"] = findings.all.iter().map(scene).collect();
    let text = format!("{found:#}\n");
    write_file(&arguments.out.join("stress.json"), text.as_bytes())?;
    let page = page::page(&findings, &ratios, &told);
    write_file(&arguments.out.join("stress.html"), page.as_bytes())?;
    if interrupted() {
        say!(
            "interrupted: the page holds the {} scenes solved by then",
            findings.all.len()
        );
    }
    if !arguments.quiet {
        say!(
            "estimate over error, {} answers above {} %: median {:.2}, below half {:.1} %, above three times {:.1} %",
            ratios.answers,
            100.0 * ratio::FLOOR,
            ratios.median,
            100.0 * ratios.below,
            100.0 * ratios.above
        );
    }
    finish(arguments, &told, missing)
}

/// What a row does not say.
fn scene(found: &Found) -> Value {
    json!({ "seed": found.seed, "scene": found.told, "texels": found.texels })
}
