//! The default solve on random scenes: errors, warnings and error estimates where nothing was tuned.

use super::cases::Case;
use super::methods::DEFAULT;
use super::run::AtlasRun;
use super::trial::{TexelSample, Trial, TrialTruth};
use super::{CaseStudy, ErrorMeasure};
use crate::studies::random::meshes::draw_mesh;
use crate::studies::random::{FaceShapes, draw_scene};
use common::Result;
use common::mesh::Mesh;
use common::scene::Scene;
use oracle::path_tracer::{PATH_SETS, path_growth_for_noise, trace_radiosity, trace_sample};
use oracle::solve::progress::ProgressMonitor;
use oracle::solve::solver::DEFAULT_ERROR;
use rand::rngs::Xoshiro256PlusPlus;
use rand::{RngExt, SeedableRng};

/// Name on the command line.
pub const COMMAND_NAME: &str = "random";
/// Paths of a truth, shared by all texels: about four seconds on two cores, and 0.2 to 0.5 % of noise
/// in an error.
const TRUTH_PATHS: u32 = 1 << 22;
/// Largest number of bounces of a mesh's truth, shared by the texels of its sample: about ten minutes on two cores.
const MAX_TRUTH_BOUNCES: u32 = 1 << 27;
/// Inverse share of the bounces that show how many the truth needs.
const FIRST_FRACTION: u32 = 128;
/// Standard error that paths leave in the error of an answer as far off as requested, as a share of that error.
const TRUTH_NOISE: f64 = 0.15;
/// Growth of the number of paths beyond the predicted one, so that the next ones are the last as a rule.
const TRUTH_MARGIN: f64 = 1.2;
/// Paths that show where a mesh is lit, shared by all its texels.
const PILOT_PATHS: u32 = 1 << 18;
/// Mean number of texels of a mesh's sample.
const SAMPLE_SIZE: f64 = 2048.0;
/// Number of texels of a mesh up to which its faces have more than one.
const MESH_TEXELS: usize = 1 << 13;
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
    failing_method: DEFAULT,
    values: &[],
    build: |seed| RandomRequest::default().draw_trial(seed),
};

/// Scenes to draw.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DrawnScenes {
    /// Rooms of few faces of this shape
    Rooms(FaceShapes),
    /// Many small triangles
    Meshes,
}

/// Options of a run.
#[derive(Clone, Copy, Debug)]
pub struct RandomRequest {
    /// Scenes to draw.
    pub scenes: DrawnScenes,
    /// Texels per side of a face; of a mesh at most, as long as all are not too many.
    pub texels: u32,
    /// Requested error.
    pub error: f64,
    /// Largest number of bounces of the paths of a mesh's truth.
    pub max_bounces: u32,
}

impl Default for RandomRequest {
    fn default() -> Self {
        Self {
            scenes: DrawnScenes::Rooms(FaceShapes::default()),
            texels: 8,
            error: DEFAULT_ERROR,
            max_bounces: MAX_TRUTH_BOUNCES,
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
    pub fn draw_trial(&self, seed: f64) -> Result<Trial> {
        let trial = match self.scenes {
            DrawnScenes::Rooms(shapes) => {
                let drawn = draw_scene(seed as u64, shapes);
                let description = Some(drawn.to_string());
                let mesh = Mesh::uniform(&drawn.scene, self.texels, 1)?;
                let traced = trace_radiosity(&drawn.scene, &mesh, TRUTH_PATHS / mesh.texels.len() as u32, 0);
                let truth = TrialTruth::Traced(traced.reflected.values, traced.error);
                Trial {
                    description,
                    ..Trial::new(drawn.scene, self.texels, truth)
                }
            }
            DrawnScenes::Meshes => {
                let drawn = draw_mesh(seed as u64);
                let description = Some(drawn.to_string());
                let side = (MESH_TEXELS / drawn.scene.faces.len()).isqrt() as u32;
                Trial {
                    description,
                    ..self.sample_mesh(drawn.scene, side.clamp(1, self.texels))?
                }
            }
        };
        Ok(Trial {
            requested_error: Some(self.error),
            ..trial
        })
    }

    /// Makes the trial of a mesh: the truth is traced at a sample of its texels, drawn by light, area and number alike
    /// as a few paths show it. Each stands for its area over the probability with which it was drawn. First paths show how
    /// many the truth needs.
    fn sample_mesh(&self, scene: Scene, texels: u32) -> Result<Trial> {
        let mesh = Mesh::uniform(&scene, texels, 1)?;
        let order = mesh.texels_in_face_order();
        let areas: Vec<f64> = order.iter().map(|k| f64::from(mesh.texels[*k].area)).collect();
        let pilot = (PILOT_PATHS / mesh.texels.len() as u32).max(1);
        let pilot = trace_radiosity(&scene, &mesh, pilot, 1).reflected.values;
        let squares: Vec<f64> = pilot.iter().map(|light| light.length_squared()).collect();
        let light: f64 = areas.iter().zip(&squares).map(|(area, square)| area * square).sum();
        let area = areas.iter().sum::<f64>();
        let mut source = Xoshiro256PlusPlus::seed_from_u64(0);
        let probabilities: Vec<f64> = (areas.iter().zip(&squares))
            .map(|(own, square)| {
                let shares = [
                    own * square / light.max(f64::MIN_POSITIVE),
                    own / area,
                    1.0 / areas.len() as f64,
                ];
                (SAMPLE_SIZE * shares.iter().sum::<f64>() / 3.0).min(1.0)
            })
            .collect();
        let sampled: Vec<f64> = (areas.iter().zip(&probabilities))
            .map(|(area, probability)| match source.random_bool(*probability) {
                true => area / probability,
                false => 0.0,
            })
            .collect();
        // Between faces of a reflectance ρ a path has 1/(1 − ρ) bounces.
        let absorbed = |(k, area): (&usize, &f64)| area * f64::from(1.0 - mesh.texels[*k].reflectance.max_element());
        let absorbed = order.iter().zip(&areas).map(absorbed).sum::<f64>() / areas.iter().sum::<f64>();
        let count = sampled.iter().filter(|area| **area > 0.0).count().max(1);
        let min_paths = f64::from(PATH_SETS);
        let max_paths = (f64::from(self.max_bounces) * absorbed / count as f64).max(min_paths);
        let mut paths = (max_paths / f64::from(FIRST_FRACTION)).max(min_paths);
        let mut seed = 0;
        let traced = loop {
            let traced = trace_sample(&scene, &mesh, &sampled, paths as u32, seed);
            let light = &traced.reflected.values;
            let growth = path_growth_for_noise(&sampled, light, &traced.error, self.error, TRUTH_NOISE * self.error);
            if growth <= 1.0 || paths >= max_paths {
                break traced;
            }
            paths = (paths * growth * TRUTH_MARGIN).min(max_paths);
            seed += 1;
        };
        let truth = TrialTruth::Traced(traced.reflected.values, traced.error);
        Ok(Trial {
            sample: Some(TexelSample {
                areas: sampled,
                probabilities,
            }),
            ..Trial::new(scene, texels, truth)
        })
    }
}
