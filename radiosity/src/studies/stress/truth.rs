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

/// Computes truths and keeps the dense solver's last one, which several values of a case may share.
#[derive(Default)]
pub struct TruthCache {
    dense: Option<(String, Vec<DVec3>)>,
}

impl TruthCache {
    /// Computes the truth of a trial. Errors: the dense solver fails.
    pub fn truth_of(&mut self, trial: &Trial) -> Result<Vec<DVec3>> {
        let all = trial.scene.faces.len() * texel_count([trial.texels; 2]) as usize;
        Ok(match &trial.truth {
            _ if all == 0 => Vec::new(),
            TrialTruth::Direct(occluders) => direct_light::reflected_direct(&trial.scene, trial.texels, occluders),
            TrialTruth::Constant(value) => vec![*value; all],
            TrialTruth::Dark => vec![DVec3::ZERO; all],
            TrialTruth::Traced(values, _) => values.clone(),
            TrialTruth::Dense(scene) => {
                let key = format!("{} {scene:?}", trial.texels);
                if self.dense.as_ref().is_none_or(|(known, _)| *known != key) {
                    self.dense = Some((key, dense_truth(scene, trial.texels, 2)?));
                }
                let mut values = self
                    .dense
                    .iter()
                    .flat_map(|(_, values)| values)
                    .copied()
                    .collect::<Vec<_>>();
                values.resize(all, DVec3::ZERO);
                values
            }
        })
    }
}

/// Solves by the dense solver on texels `finer` times as fine and averages. Errors: the solve fails.
pub fn dense_truth(scene: &Scene, texels: u32, finer: u32) -> Result<Vec<DVec3>> {
    let solved = scene.solve_once(
        &dense::dense_settings(texels * finer),
        SolverChoice::Dense,
        &without_progress(),
    )?;
    let (mesh, dense) = (&solved.mesh, solved.dense.as_ref());
    let dense = dense.ok_or_else(|| Error::Fault("the dense solver has no answer".into()))?;
    let texel = |k: usize| mesh.texels[k].reflectance.as_dvec3() * dense.solution.irradiance[k];
    let reflected: Vec<DVec3> = mesh.texels_in_face_order().into_iter().map(texel).collect();
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
