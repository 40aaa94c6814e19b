//! `radiosity stress random`: scenes drawn at random.

use super::{StressArguments, report_outcome};
use crate::cli::Outcome;
use crate::cli::console::message;
use crate::cli::options::QualityOption;
use crate::cli::progress::{Progress, is_interrupted};
use crate::studies::random::{FaceShapes, SceneKind, SceneOptions};
use crate::studies::stress::json::{AtlasSummary, atlas_json};
use crate::studies::stress::random::{
    self, COMMAND_NAME, RANDOM_CASE, RandomFindings, RandomRequest, RandomResult, gates, page, ratio,
};
use crate::studies::stress::run::AtlasRun;
use crate::studies::stress::{CaseStudy, score};
use clap::{Args, ValueEnum};
use common::settings::SolveQuality;
use common::solution::write_file;
use common::{Error, Result};
use oracle::solve::progress::ProgressMonitor;
use serde_json::{Value, json};
use std::time::Instant;

/// Default number of scenes.
const DEFAULT_SCENES: u64 = 20;

/// Options of `stress random`.
#[derive(Args)]
pub struct RandomOptions {
    /// random: number of scenes [default: 20]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    count: Option<u64>,
    /// random: seed of the first scene; the next scenes have the next seeds [default: 0]
    // Rows hold seeds as f64, exact up to 2⁵³.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(..=1 << 52))]
    seed: Option<u64>,
    /// random: kind of the faces [default: quads]
    #[arg(long, value_enum)]
    faces: Option<FacesOption>,
    /// random: kind of the rooms [default: any]
    #[arg(long, value_enum)]
    kind: Option<KindOption>,
    /// random: texels per side of a face [default: 8]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=64))]
    texels: Option<u32>,
    /// random: normal or reference [default: normal]
    #[arg(long, value_enum)]
    quality: Option<QualityOption>,
    /// random: solve on the CPU only
    #[arg(long)]
    cpu: bool,
}

/// `--faces`.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum FacesOption {
    /// Quads
    Quads,
    /// Each quad as two triangles, each beginning at a random corner
    Triangles,
    /// Quads and triangles
    Mixed,
}

/// `--kind`.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum KindOption {
    /// Rooms of every kind
    Any,
    /// Boxes that hold rotated boxes, standing and hanging; two of three are closed
    Room,
}

impl RandomOptions {
    /// Returns true if any of the options was given.
    pub fn is_given(&self) -> bool {
        let numbers = self.count.is_some() || self.seed.is_some() || self.texels.is_some();
        let choices = self.faces.is_some() || self.kind.is_some() || self.quality.is_some();
        numbers || choices || self.cpu
    }

    fn random_request(&self) -> Result<RandomRequest> {
        let quality = self.quality.map_or(SolveQuality::Normal, Into::into);
        if quality == SolveQuality::Draft {
            return Err(Error::Usage("stress random: --quality is normal or reference".into()));
        }
        Ok(RandomRequest {
            options: SceneOptions {
                kind: match self.kind {
                    Some(KindOption::Room) => SceneKind::Room,
                    _ => SceneKind::Any,
                },
                faces: match self.faces {
                    Some(FacesOption::Triangles) => FaceShapes::Triangles,
                    Some(FacesOption::Mixed) => FaceShapes::Mixed,
                    _ => FaceShapes::Quads,
                },
            },
            texels: self.texels.unwrap_or(random::DEFAULT_TEXELS),
            quality,
            paths: match quality {
                SolveQuality::Reference => random::REFERENCE_PATHS,
                _ => random::DEFAULT_PATHS,
            },
        })
    }
}

/// Draws scenes, solves them and writes the atlas.
pub fn run(arguments: &StressArguments) -> Result<Outcome> {
    let start = Instant::now();
    let asked = arguments.random.random_request()?;
    let (gpu, missing) = if arguments.random.cpu {
        (None, None)
    } else {
        arguments.open_gpu()?
    };
    let run = AtlasRun {
        gpu: gpu.as_ref(),
        stop: &is_interrupted,
    };
    let range = (
        arguments.random.seed.unwrap_or(0),
        arguments.random.count.unwrap_or(DEFAULT_SCENES),
    );
    let progress = Progress::new(COMMAND_NAME, arguments.quiet);
    let show = |phase: &str, done| progress.show_phase(phase, done);
    let findings = RandomFindings::run_scenes(&run, &asked, range, &ProgressMonitor::new(&show))?;
    progress.clear();
    if findings.all.is_empty() {
        return Err(Error::Interrupted);
    }
    let ratios = findings.estimate_ratios();
    let study = [CaseStudy {
        info: RANDOM_CASE.info,
        rows: findings.all.iter().map(|result| result.row.clone()).collect(),
        specimen: None,
    }];
    let score = score::score_warnings(&study);
    let gates = gates::evaluate_gates(&findings, &ratios);
    let summary = AtlasSummary {
        score: &score,
        gates: &gates,
        adapter: gpu.as_ref().map(|gpu| gpu.line.name.as_str()),
        seconds: start.elapsed().as_secs_f64(),
    };
    let mut json = atlas_json(&study, &summary);
    json["estimate"] = json!(ratios);
    json["scenes"] = findings.all.iter().map(describe_scene).collect();
    let text = format!("{json:#}\n");
    write_file(&arguments.out.join("stress.json"), text.as_bytes())?;
    let page = page::render_page(&findings, &ratios, &summary);
    write_file(&arguments.out.join("stress.html"), page.as_bytes())?;
    if is_interrupted() {
        message!(
            "interrupted: the page holds the {} scenes solved by then",
            findings.all.len()
        );
    }
    if !arguments.quiet {
        message!(
            "estimate over error, {} answers above {} %: median {:.2}, below half {:.1} %, above three times {:.1} %",
            ratios.answers,
            100.0 * ratio::MIN_JUDGED_ERROR,
            ratios.median,
            100.0 * ratios.below,
            100.0 * ratios.above
        );
    }
    report_outcome(arguments, &summary, missing)
}

/// Describes a scene by what its row does not have.
fn describe_scene(result: &RandomResult) -> Value {
    json!({ "seed": result.seed, "scene": result.description, "texels": result.texels })
}
