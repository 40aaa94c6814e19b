//! A trial: the scene of a case at one value, with resolution, judged faces, truth, and the error of an answer.
//!
//! ```text
//! relative RMS = √(ΣA(a − b)² / ΣA b²), worst channel      leak = ΣA|a| / ΣA E
//! ```
//! a, b: B − E of the answer and of the truth over the judged texels. The noise of a traced truth is
//! subtracted.

use common::scene::Scene;
use common::texel::{texel_count, texel_outline};
use common::{Error, Result};
use glam::DVec3;
use oracle::diff::difference::{channel_differences, worst_channel};
use oracle::diff::reflected::ReflectedField;
use oracle::exact::direct_light;
use oracle::path_tracer::debiased_rms;
use oracle::solve::dense;
use oracle::solve::progress::without_progress;
use oracle::solve::solver::SolverChoice;
use oracle::solve::task::SolveTask;
use std::ops::Range;

/// A scene with resolution and truth.
pub struct Trial {
    /// The scene.
    pub scene: Scene,
    /// Texels per side of every face.
    pub texels: u32,
    /// Source of the truth.
    pub truth: TrialTruth,
    /// Judged faces.
    pub judged: Range<usize>,
    /// Number of the first faces that are the room of a relight, the others being the objects; 0 for a solve.
    pub room: usize,
    /// Description of a random scene.
    pub description: Option<String>,
    /// Requested error of a random scene, in place of the method's.
    pub requested_error: Option<f64>,
    /// Texels that are judged; none if all are.
    pub sample: Option<TexelSample>,
}

/// A random sample of texels.
#[derive(Clone, Debug, Default)]
pub struct TexelSample {
    /// Area for which each texel stands: its own over its probability, and 0 if it is not in the sample.
    pub areas: Vec<f64>,
    /// Probability with which each texel was drawn.
    pub probabilities: Vec<f64>,
}

/// Source of a trial's truth, which shares no code with the solvers under test.
pub enum TrialTruth {
    /// Exact mean form factors of the texels to what these occluders leave of the lamps.
    Direct(Range<usize>),
    /// B − E of every texel, W/m².
    Constant(DVec3),
    /// The dense solver's answer for a scene that has the same solution, on texels twice as fine, averaged.
    Dense(Scene),
    /// B − E of each texel by path tracing, and its standard error, W/m².
    Traced(Vec<DVec3>, Vec<DVec3>),
    /// No light on the judged faces.
    Dark,
}

impl Trial {
    /// Makes a solve that judges all faces.
    pub fn new(scene: Scene, texels: u32, truth: TrialTruth) -> Self {
        Self {
            judged: 0..scene.faces.len(),
            scene,
            texels,
            truth,
            room: 0,
            description: None,
            requested_error: None,
            sample: None,
        }
    }

    /// Returns the error of an answer and its standard error, which is 0 unless the truth is traced. Errors: the
    /// answer cannot be compared.
    pub fn error_and_noise(&self, answer: &[DVec3], truth: &[DVec3]) -> std::result::Result<(f64, f64), String> {
        if answer.len() != truth.len() {
            return Err(format!("{} texels instead of {}", answer.len(), truth.len()));
        }
        if !answer.iter().chain(truth).all(|v| v.is_finite()) {
            return Err("some texels are not finite".into());
        }
        let lit = truth.iter().any(|v| *v != DVec3::ZERO);
        // Only a constant truth may be met exactly; otherwise the answer is the truth itself.
        if lit && !matches!(self.truth, TrialTruth::Constant(_)) && answer == truth {
            return Err("the truth itself, bit for bit".into());
        }
        let TexelSample { areas, probabilities } = self.sample.clone().unwrap_or_else(|| TexelSample {
            areas: self.judged_areas(),
            probabilities: vec![1.0; answer.len()],
        });
        let (error, noise) = match &self.truth {
            TrialTruth::Dark => (self.leaked_share(&areas, answer), 0.0),
            TrialTruth::Traced(_, error) => debiased_rms((&areas, &probabilities), answer, truth, error).into(),
            _ => {
                let all = areas.into_iter().zip(answer).zip(truth);
                let judged = all.filter(|((area, _), _)| *area > 0.0);
                let difference = worst_channel(channel_differences(judged.map(|((area, a), b)| (area, *a, *b))));
                (difference.relative_rms, 0.0)
            }
        };
        match (error.is_finite() && noise.is_finite(), &self.truth) {
            (true, _) => Ok((error, noise)),
            (false, TrialTruth::Traced(..)) => Err("the truth is all noise".into()),
            (false, _) => Err("lit, but the truth is all black".into()),
        }
    }

    /// Returns the exact answer, B − E of every texel in face order, W/m²; none if the truth is a solver's or a path tracer's.
    pub fn exact_answer(&self) -> Option<Vec<DVec3>> {
        let all = self.scene.faces.len() * texel_count([self.texels; 2]) as usize;
        match &self.truth {
            TrialTruth::Direct(occluders) => Some(direct_light::reflected_direct(&self.scene, self.texels, occluders)),
            TrialTruth::Constant(value) => Some(vec![*value; all]),
            TrialTruth::Dark => Some(vec![DVec3::ZERO; all]),
            TrialTruth::Dense(_) | TrialTruth::Traced(..) => None,
        }
    }

    /// Returns the area of each texel, 0 if it is not judged.
    pub fn judged_areas(&self) -> Vec<f64> {
        let resolution = [self.texels; 2];
        let texels = |(k, face)| {
            let judged = self.judged.contains(&k);
            let area = move |t| {
                if judged {
                    texel_outline(face, resolution, t).area()
                } else {
                    0.0
                }
            };
            (0..texel_count(resolution)).map(area)
        };
        self.scene.faces.iter().enumerate().flat_map(texels).collect()
    }

    fn leaked_share(&self, areas: &[f64], answer: &[DVec3]) -> f64 {
        let behind = areas.iter().zip(answer);
        let behind: f64 = behind.map(|(a, v)| a * v.abs().element_sum()).sum();
        let faces = self.scene.faces.iter();
        let emitted: f64 = faces.map(|f| f.area() * f.emission.as_dvec3().element_sum()).sum();
        if behind == 0.0 { 0.0 } else { behind / emitted }
    }
}

/// Computes truths, B − E of every texel in face order in W/m², and keeps the dense solver's last one, which several
/// values of a case may share.
#[derive(Default)]
pub struct TruthCache {
    dense: Option<(String, Vec<DVec3>)>,
}

impl TruthCache {
    /// Computes the truth of a trial. Errors: the dense solver fails.
    pub fn truth_of(&mut self, trial: &Trial) -> Result<Vec<DVec3>> {
        let all = trial.scene.faces.len() * texel_count([trial.texels; 2]) as usize;
        let scene = match &trial.truth {
            _ if all == 0 => return Ok(Vec::new()),
            TrialTruth::Traced(values, _) => return Ok(values.clone()),
            TrialTruth::Dense(scene) => scene,
            _ => return Ok(trial.exact_answer().unwrap_or_default()),
        };
        let key = format!("{} {scene:?}", trial.texels);
        let mut values = match self.dense.take() {
            Some((known, values)) if known == key => values,
            _ => dense_truth(scene, trial.texels, 2)?,
        };
        self.dense = Some((key, values.clone()));
        values.resize(all, DVec3::ZERO);
        Ok(values)
    }
}

/// Solves by the dense solver on texels `finer` times as fine and averages. Errors: the solve fails.
pub fn dense_truth(scene: &Scene, texels: u32, finer: u32) -> Result<Vec<DVec3>> {
    let settings = dense::dense_settings(texels * finer);
    let solved = scene.solve_once(&settings, SolverChoice::Dense, &without_progress())?;
    let (mesh, dense) = (&solved.mesh, solved.dense.as_ref());
    let dense = dense.ok_or_else(|| Error::Fault("the dense solver has no answer".into()))?;
    let texel = |k: usize| mesh.texels[k].reflectance.as_dvec3() * dense.solution.irradiance[k];
    let resolutions = |side: u32| vec![[side; 2]; scene.faces.len()];
    let fine = ReflectedField {
        scene,
        resolutions: resolutions(texels * finer),
        values: mesh.texels_in_face_order().into_iter().map(texel).collect(),
    };
    Ok(fine.average_onto(resolutions(texels)).values)
}
