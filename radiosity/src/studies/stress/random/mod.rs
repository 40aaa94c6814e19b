//! The default solve on random scenes: errors, warnings and error estimates where nothing was tuned.

pub mod gates;
pub mod page;
pub mod ratio;

use super::outcome::solver_sides;
use super::run::AtlasRun;
use super::trial::{Case, Trial, TrialTruth};
use super::{AtlasRow, CaseInfo, RELATIVE_RMS, Specimen};
use crate::studies::random::{self, SceneOptions};
use common::Result;
use common::mesh::Mesh;
use common::settings::SolveQuality;
use oracle::path_tracer::trace_radiosity;
use oracle::solve::progress::ProgressMonitor;
use ratio::EstimateRatios;

/// Name on the command line.
pub const COMMAND_NAME: &str = "random";
/// Default texels per side.
pub const DEFAULT_TEXELS: u32 = 8;
/// Paths of a truth, shared by all texels: about four seconds on two cores, and 0.2 to 0.5 % of noise
/// in an error.
pub const DEFAULT_PATHS: u32 = 1 << 22;
/// Paths of a truth for answers of reference quality, whose errors are smaller.
pub const REFERENCE_PATHS: u32 = 1 << 25;
/// Number of scenes whose pictures are kept.
const MAX_PICTURES: usize = 4;

const RANDOM_INFO: CaseInfo = CaseInfo {
    name: COMMAND_NAME,
    parameter: "seed",
    breaks: "whatever was tuned to the scenes that it was built on",
    truth: "paths traced through the scene's faces, their noise taken off",
    measure: RELATIVE_RMS,
};

/// Case of the rows.
pub const RANDOM_CASE: Case = Case {
    info: RANDOM_INFO,
    values: &[],
    build: |seed| {
        traced_trial(
            &RandomRequest::default(),
            &draw_requested(&RandomRequest::default(), seed as u64),
        )
    },
};

/// Options of a run.
#[derive(Clone, Copy, Debug)]
pub struct RandomRequest {
    /// Options of the scenes.
    pub options: SceneOptions,
    /// Texels per side of a face.
    pub texels: u32,
    /// `normal` or `reference`.
    pub quality: SolveQuality,
    /// Paths of the truth, shared by all texels.
    pub paths: u32,
}

impl Default for RandomRequest {
    fn default() -> Self {
        Self {
            options: SceneOptions::default(),
            texels: DEFAULT_TEXELS,
            quality: SolveQuality::Normal,
            paths: DEFAULT_PATHS,
        }
    }
}

/// Results of one scene.
pub struct RandomResult {
    /// Seed of the scene.
    pub seed: u64,
    /// Description of the scene.
    pub description: String,
    /// Texels per side of a face.
    pub texels: u32,
    /// Results on both solvers.
    pub row: AtlasRow,
}

impl RandomResult {
    /// Returns the worse error, infinite without an answer.
    pub fn worst_error(&self) -> f64 {
        self.row.error.unwrap_or(f64::INFINITY)
    }
}

/// Results of all scenes.
#[derive(Default)]
pub struct RandomFindings {
    /// Scenes in the order of their seeds.
    pub all: Vec<RandomResult>,
    /// Specimens of the scenes with the greatest errors, worst first.
    pub worst: Vec<Specimen>,
}

/// Draws the scene of a seed.
fn draw_requested(request: &RandomRequest, seed: u64) -> random::RandomScene {
    random::draw_scene(seed, request.options)
}

/// Makes the trial of a scene and traces its truth.
fn traced_trial(request: &RandomRequest, drawn: &random::RandomScene) -> Result<Trial> {
    let method: &[&str] = match request.quality {
        SolveQuality::Reference => &["reference"],
        _ => &["default"],
    };
    let mesh = Mesh::uniform(&drawn.scene, request.texels, 1)?;
    let traced = trace_radiosity(&drawn.scene, &mesh, request.paths / mesh.texels.len() as u32, 0);
    let truth = TrialTruth::Traced(traced.reflected.values, traced.error);
    Ok(Trial::new(drawn.scene.clone(), request.texels, truth).with_methods(method))
}

impl RandomFindings {
    /// Draws and solves `count` scenes from `seed` on and reports progress to `watch`. After a stop the
    /// finished scenes are returned. Errors: a scene or truth fails.
    pub fn run_scenes(
        run: &AtlasRun,
        request: &RandomRequest,
        (seed, count): (u64, u64),
        watch: &ProgressMonitor,
    ) -> Result<Self> {
        let mut findings = Self::default();
        for k in 0..count {
            let _ = watch.report_count("scenes", k, count);
            if (run.stop)() {
                break;
            }
            let seed = seed + k;
            let drawn = draw_requested(request, seed);
            let trial = traced_trial(request, &drawn)?;
            let texels = trial.texels;
            let truth = super::truth::single_truth(&trial)?;
            let Some((rows, specimen)) = run.run_trial(&RANDOM_CASE, seed as f64, trial, &truth) else {
                break;
            };
            findings.all.extend(rows.into_iter().map(|row| RandomResult {
                seed,
                description: drawn.to_string(),
                texels,
                row,
            }));
            findings.keep_worst(specimen);
        }
        Ok(findings)
    }

    /// Compares the estimates of both solvers with their errors.
    pub fn estimate_ratios(&self) -> EstimateRatios {
        let sides = self.all.iter().flat_map(|result| solver_sides(&result.row));
        ratio::collect_ratios(sides.map(|(_, side)| side))
    }

    /// Adds a specimen and keeps the worst.
    fn keep_worst(&mut self, specimen: Option<Specimen>) {
        self.worst.extend(specimen);
        let all = &self.all;
        let error = |specimen: &Specimen| {
            let result = all.iter().find(|result| result.seed as f64 == specimen.value);
            result.map_or(0.0, RandomResult::worst_error)
        };
        self.worst.sort_by(|a, b| error(b).total_cmp(&error(a)));
        self.worst.truncate(MAX_PICTURES);
    }
}
