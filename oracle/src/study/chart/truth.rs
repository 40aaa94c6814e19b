//! What the points are judged by: a given result, else the matrix's, else that of the CPU to the
//! least error that can be asked for.

use super::store::digest;
use crate::judge::diff::pair::Pair;
use crate::judge::diff::reflected::Reflected;
use crate::solve::solver::{Asked, LEAST, Solver};
use crate::solve::watch::Watch;
use crate::solve::{Question, answer, dense};
use common::scene::Scene;
use common::solution::{Seconds, Stored};
use common::{Error, Result};
use cpu::matrix::memory::{MEMORY, bytes};
use glam::DVec3;
use std::path::Path;

/// The truth.
pub struct Truth {
    /// What it is, in words.
    pub name: String,
    /// Its texels and values.
    pub stored: Stored,
    /// The values' own name: points judged by others are other points.
    pub id: u64,
}

impl Truth {
    /// A result of `solve`.
    pub fn read(dir: &Path, name: String) -> Result<Self> {
        let stored = Stored::read(dir)?;
        let bits: Vec<[u32; 3]> = stored
            .radiosity
            .iter()
            .map(|v| v.to_array().map(f32::to_bits))
            .collect();
        let id = digest(&(bits, &stored.resolutions));
        Ok(Self { name, stored, id })
    }

    /// Refuses a truth of another scene.
    pub fn check(&self, scene: &Scene) -> Result<()> {
        let truth = Reflected::from(&self.stored);
        let black = Reflected {
            scene,
            resolutions: truth.resolutions.clone(),
            values: vec![DVec3::ZERO; truth.values.len()],
        };
        match Pair::new(&black, &truth, None) {
            Ok(_) => Ok(()),
            Err(mismatch) => Err(Error::input(
                self.stored.dir.join("result.json"),
                mismatch.face.map_or(String::new(), |k| format!("face {k}")),
                format!("{} ({})", mismatch.message, scene.name),
            )),
        }
    }

    /// Ours on N×N texels, kept in `dir`: one that is there already is taken.
    pub fn own(scene: &Scene, texels: u32, dir: &Path, watch: &Watch) -> Result<Self> {
        let count = scene.faces.len() as u64 * u64::from(texels).pow(2);
        let dense = bytes(count) <= MEMORY;
        let name = if dense {
            format!("the matrix solver on {texels}×{texels} texels a face")
        } else {
            format!(
                "the CPU to {} %, {texels}×{texels} texels a face",
                100.0 * LEAST
            )
        };
        if let Ok(there) = Self::read(dir, name.clone()) {
            return Ok(there);
        }
        common::solution::prepare(dir)?;
        let question = Question {
            task: scene,
            settings: &dense::settings(texels),
            solver: if dense {
                Solver::Matrix
            } else {
                Solver::Hierarchy(Asked {
                    error: LEAST,
                    texels: Some(texels),
                })
            },
        };
        let told = |_: &str, done| watch.tell("truth", done);
        let own = Watch::new(&told);
        let answered = answer(&question, &own)?;
        if own.stopped() {
            return Err(Error::Interrupted);
        }
        let solution = answered.solution(&question, &answered.notes, Seconds::default());
        solution.write(dir)?;
        Self::read(dir, name)
    }
}
