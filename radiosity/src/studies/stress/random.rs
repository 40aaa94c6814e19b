//! The default solve on random scenes: errors, warnings and error estimates where nothing was tuned.

use super::cases::Case;
use super::methods::DEFAULT;
use super::run::AtlasRun;
use super::trial::{Trial, TrialTruth};
use super::{CaseStudy, ErrorMeasure};
use crate::studies::random::{FaceShapes, draw_scene};
use common::Result;
use common::mesh::Mesh;
use oracle::path_tracer::trace_radiosity;
use oracle::solve::progress::ProgressMonitor;

/// Name on the command line.
pub const COMMAND_NAME: &str = "random";
/// Paths of a truth, shared by all texels: about four seconds on two cores, and 0.2 to 0.5 % of noise
/// in an error.
const TRUTH_PATHS: u32 = 1 << 22;
/// Number of scenes whose pictures are kept.
const MAX_PICTURES: usize = 4;

/// Case of the rows: the seeds of the scenes are its values.
pub const RANDOM_CASE: Case = Case {
    name: COMMAND_NAME,
    group: "Solved",
    parameter: "seed",
    weakness: "whatever was tuned to the scenes that it was built on",
    truth: "paths traced through the scene's faces, their noise taken off",
    measure: ErrorMeasure::RelativeRms,
    methods: &[DEFAULT],
    values: &[],
    build: |seed| RandomRequest::default().draw_trial(seed),
};

/// Options of a run.
#[derive(Clone, Copy, Debug)]
pub struct RandomRequest {
    /// Shape of the scenes' faces.
    pub faces: FaceShapes,
    /// Texels per side of a face.
    pub texels: u32,
}

impl Default for RandomRequest {
    fn default() -> Self {
        Self {
            faces: FaceShapes::default(),
            texels: 8,
        }
    }
}

impl RandomRequest {
    /// Draws and solves `count` scenes from `seed` on. After a stop the finished ones are returned. Errors:
    /// a scene or truth fails.
    pub fn run_scenes(&self, run: &AtlasRun, seed: u64, count: u64, watch: &ProgressMonitor) -> Result<CaseStudy> {
        let seeds: Vec<f64> = (seed..seed + count).map(|seed| seed as f64).collect();
        run.run_values(&RANDOM_CASE, &seeds, |seed| self.draw_trial(seed), MAX_PICTURES, watch)
    }

    /// Draws the scene of a seed and traces its truth.
    fn draw_trial(&self, seed: f64) -> Result<Trial> {
        let drawn = draw_scene(seed as u64, self.faces);
        let description = Some(drawn.to_string());
        let mesh = Mesh::uniform(&drawn.scene, self.texels, 1)?;
        let traced = trace_radiosity(&drawn.scene, &mesh, TRUTH_PATHS / mesh.texels.len() as u32, 0);
        let truth = TrialTruth::Traced(traced.reflected.values, traced.error);
        Ok(Trial {
            description,
            ..Trial::new(drawn.scene, self.texels, truth)
        })
    }
}
