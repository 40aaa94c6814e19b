//! Computes the truth of a trial: B − E of every texel in face order, W/m².

use super::direct_light;
use super::trial::{Trial, TrialTruth};
use common::resample::{area_average, shared_pieces};
use common::scene::Scene;
use common::texel::texel_count;
use common::{Error, Result};
use glam::DVec3;
use oracle::solve::dense;
use oracle::solve::progress::without_progress;
use oracle::solve::solver::SolverChoice;
use oracle::solve::task::SolveTask;

/// Computes truths and keeps the last one of [`TrialTruth::Alike`], which all values of a sweep share.
#[derive(Default)]
pub struct TruthCache {
    last: Option<(String, Vec<DVec3>)>,
}

impl TruthCache {
    /// Computes the truth of a trial. Errors: the dense solver fails.
    pub fn truth_of(&mut self, trial: &Trial) -> Result<Vec<DVec3>> {
        let (scene, texels) = (&trial.scene, trial.texels);
        let all = scene.faces.len() * texel_count([texels, texels]) as usize;
        Ok(match &trial.truth {
            TrialTruth::Direct => direct_light::reflected_direct(scene, texels, &[]),
            TrialTruth::Shadowed(occluders) => direct_light::reflected_direct(scene, texels, occluders),
            TrialTruth::Constant(value) => vec![*value; all],
            TrialTruth::Dark => vec![DVec3::ZERO; all],
            TrialTruth::Traced(values, _) => values.clone(),
            TrialTruth::Matrix(finer) => dense_truth(scene, texels, *finer)?,
            TrialTruth::Alike(other, finer) => {
                let mut values = self.truth_of_equivalent(other, texels, *finer)?;
                values.resize(all, DVec3::ZERO);
                values
            }
        })
    }

    fn truth_of_equivalent(&mut self, scene: &Scene, texels: u32, finer: u32) -> Result<Vec<DVec3>> {
        let key = format!("{texels} {finer} {scene:?}");
        if let Some((last, values)) = &self.last
            && *last == key
        {
            return Ok(values.clone());
        }
        let values = dense_truth(scene, texels, finer)?;
        self.last = Some((key, values.clone()));
        Ok(values)
    }
}

/// Computes the truth of a single trial. Errors: the dense solver fails.
pub fn single_truth(trial: &Trial) -> Result<Vec<DVec3>> {
    TruthCache::default().truth_of(trial)
}

/// Solves by the dense solver on texels `finer` times as fine and averages. Errors: the solve fails.
pub fn dense_truth(scene: &Scene, texels: u32, finer: u32) -> Result<Vec<DVec3>> {
    let solved = scene.solve_once(
        &dense::dense_settings(texels * finer),
        SolverChoice::Dense,
        &without_progress(),
    )?;
    let (mesh, dense) = (&solved.mesh, solved.dense.as_ref());
    let dense = dense.ok_or_else(|| Error::Fault("the matrix has no answer".into()))?;
    let irradiance = &dense.solution.irradiance;
    let reflected: Vec<DVec3> = mesh
        .texels_in_face_order()
        .into_iter()
        .map(|k| mesh.texels[k].reflectance.as_dvec3() * irradiance[k])
        .collect();
    if finer == 1 {
        return Ok(reflected);
    }
    let (from, to) = ([texels * finer; 2], [texels; 2]);
    let fine = texel_count(from) as usize;
    let coarse = |(k, face)| {
        let shared = shared_pieces(face, from, to);
        area_average(&reflected[k * fine..(k + 1) * fine], &shared, to)
    };
    Ok(scene.faces.iter().enumerate().flat_map(coarse).collect())
}
