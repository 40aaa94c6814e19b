//! The truth of a trial: B − E of every texel, W/m², in face order.

use super::direct;
use super::trial::{Trial, Truth};
use crate::judge::resample::{average, pieces};
use crate::solve::dense;
use crate::solve::solver::Solver;
use crate::solve::task::Task;
use crate::solve::watch::unwatched;
use common::scene::Scene;
use common::texel::count;
use common::{Error, Result};
use glam::DVec3;

/// Works truths out; the last one that another scene stands for is kept, for a sweep towards it asks
/// again and again.
#[derive(Default)]
pub struct Truths {
    last: Option<(String, Vec<DVec3>)>,
}

impl Truths {
    /// The truth of a trial.
    pub fn of(&mut self, trial: &Trial) -> Result<Vec<DVec3>> {
        let (scene, texels) = (&trial.scene, trial.texels);
        let all = scene.faces.len() * count([texels, texels]) as usize;
        Ok(match &trial.truth {
            Truth::Direct => direct::reflected(scene, texels, &[]),
            Truth::Shadowed(occluders) => direct::reflected(scene, texels, occluders),
            Truth::Constant(value) => vec![*value; all],
            Truth::Dark => vec![DVec3::ZERO; all],
            Truth::Traced(values, _) => values.clone(),
            Truth::Matrix(finer) => matrix(scene, texels, *finer)?,
            Truth::Alike(other, finer) => {
                let mut values = self.alike(other, texels, *finer)?;
                values.resize(all, DVec3::ZERO);
                values
            }
        })
    }

    fn alike(&mut self, scene: &Scene, texels: u32, finer: u32) -> Result<Vec<DVec3>> {
        let key = format!("{texels} {finer} {scene:?}");
        if let Some((last, values)) = &self.last
            && *last == key
        {
            return Ok(values.clone());
        }
        let values = matrix(scene, texels, finer)?;
        self.last = Some((key, values.clone()));
        Ok(values)
    }
}

/// The truth of one trial.
pub fn of(trial: &Trial) -> Result<Vec<DVec3>> {
    Truths::default().of(trial)
}

/// The matrix's answer on texels `finer` times as fine, averaged.
pub fn matrix(scene: &Scene, texels: u32, finer: u32) -> Result<Vec<DVec3>> {
    let solved = scene.once(
        &dense::settings(texels * finer),
        Solver::Matrix,
        &unwatched(),
    )?;
    let (mesh, dense) = (&solved.mesh, solved.matrix.as_ref());
    let dense = dense.ok_or_else(|| Error::Fault("the matrix has no answer".into()))?;
    let irradiance = &dense.answer.irradiance;
    let reflected: Vec<DVec3> = mesh
        .in_face_order()
        .into_iter()
        .map(|k| mesh.texels[k].reflectance.as_dvec3() * irradiance[k])
        .collect();
    if finer == 1 {
        return Ok(reflected);
    }
    let (from, to) = ([texels * finer; 2], [texels; 2]);
    let fine = count(from) as usize;
    let coarse = |(k, face)| {
        let shared = pieces(face, from, to);
        average(&reflected[k * fine..(k + 1) * fine], &shared, to)
    };
    Ok(scene.faces.iter().enumerate().flat_map(coarse).collect())
}
