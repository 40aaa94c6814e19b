//! The truth of a chart: a given result, else the dense solver's, else the CPU's adaptive solution
//! to the smallest error that can be requested.

use super::store::hash_value;
use common::scene::Scene;
use common::solution::{PhaseSeconds, StoredSolution};
use common::{Error, Result};
use cpu::dense::memory::{MAX_MATRIX_BYTES, matrix_bytes};
use glam::DVec3;
use oracle::diff::pair::GridPair;
use oracle::diff::reflected::ReflectedField;
use oracle::solve::progress::ProgressMonitor;
use oracle::solve::solver::{ErrorTarget, MIN_ERROR, SolverChoice};
use oracle::solve::{SolveRequest, dense, solve_request};
use std::path::Path;

/// The solution that errors are measured against.
pub struct ChartTruth {
    /// Description shown on the page.
    pub name: String,
    /// Texels and values.
    pub stored: StoredSolution,
    /// Hash of the values, part of each measurement's key.
    pub id: u64,
}

impl ChartTruth {
    /// Reads a result of `solve`. Errors: it cannot be read.
    pub fn read_result(dir: &Path, name: String) -> Result<Self> {
        let stored = StoredSolution::read(dir)?;
        let bits: Vec<[u32; 3]> = stored
            .radiosity
            .iter()
            .map(|v| v.to_array().map(f32::to_bits))
            .collect();
        let id = hash_value(&(bits, &stored.resolutions));
        Ok(Self { name, stored, id })
    }

    /// Checks that the truth belongs to `scene`. Errors: it is of another scene.
    pub fn check_scene(&self, scene: &Scene) -> Result<()> {
        let truth = ReflectedField::from(&self.stored);
        let black = ReflectedField {
            scene,
            resolutions: truth.resolutions.clone(),
            values: vec![DVec3::ZERO; truth.values.len()],
        };
        match GridPair::new(&black, &truth, None) {
            Ok(_) => Ok(()),
            Err(mismatch) => Err(Error::bad_input(
                self.stored.dir.join("result.json"),
                mismatch.face.map_or(String::new(), |k| format!("face {k}")),
                format!("{} ({})", mismatch.message, scene.name),
            )),
        }
    }

    /// Solves `scene` on N×N texels and stores the result in `dir`; a result that exists there is
    /// reused. Errors: the solve fails or is interrupted, or the result cannot be written.
    pub fn solve_truth(scene: &Scene, texels: u32, dir: &Path, watch: &ProgressMonitor) -> Result<Self> {
        let count = scene.faces.len() as u64 * u64::from(texels).pow(2);
        let dense = matrix_bytes(count) <= MAX_MATRIX_BYTES;
        let name = if dense {
            format!("the matrix solver on {texels}×{texels} texels a face")
        } else {
            format!("the CPU to {} %, {texels}×{texels} texels a face", 100.0 * MIN_ERROR)
        };
        if let Ok(stored) = Self::read_result(dir, name.clone()) {
            return Ok(stored);
        }
        common::solution::prepare_directory(dir)?;
        let question = SolveRequest {
            task: scene,
            settings: &dense::dense_settings(texels),
            solver: if dense {
                SolverChoice::Dense
            } else {
                SolverChoice::Hierarchy(ErrorTarget {
                    error: MIN_ERROR,
                    texels: Some(texels),
                })
            },
        };
        let progress = |_: &str, done| watch.report_share("truth", done);
        let inner_watch = ProgressMonitor::new(&progress);
        let answered = solve_request(&question, &inner_watch)?;
        if inner_watch.is_stopped() {
            return Err(Error::Interrupted);
        }
        let solution = answered.to_solution(&question, &answered.notes, PhaseSeconds::default());
        solution.write(dir)?;
        Self::read_result(dir, name)
    }
}
