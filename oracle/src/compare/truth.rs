//! Truth of a comparison: the dense matrix solution on as many texels as take a few seconds.

use crate::compare::comparison::TruthInfo;
use crate::diff::pair::GridPair;
use crate::diff::reflected::ReflectedField;
use crate::solve::dense;
use crate::solve::progress::{ProgressMonitor, without_progress};
use crate::solve::solver::SolverChoice;
use crate::solve::task::SolveTask;
use common::Result;
use common::mesh::Mesh;
use common::scene::Scene;
use common::shooting::RadiosityField;
use glam::DVec3;

/// Largest number of texels of the truth: their form factors take about five seconds on two cores; the time
/// grows with the square.
const MAX_TRUTH_TEXELS: usize = 2500;
/// Fewest texels per side of a face: on fewer, shadows would be smaller than texels.
const MIN_TEXELS_PER_SIDE: u32 = 4;

/// Solution of the dense matrix.
pub struct MatrixTruth {
    scene: Scene,
    resolutions: Vec<[u32; 2]>,
    values: Vec<DVec3>,
    /// Description with its own error.
    pub info: TruthInfo,
}

impl MatrixTruth {
    /// Solves the matrix on N×N texels per face, N = `texels` (at least 8) as far as `MAX_TRUTH_TEXELS` allows; none if
    /// N < `MIN_TEXELS_PER_SIDE`. All presets are compared with the same truth.
    ///
    /// Errors: the solver fails or is interrupted.
    pub fn new(scene: &Scene, texels: u32, watch: &ProgressMonitor) -> Result<Option<Self>> {
        let largest = (MAX_TRUTH_TEXELS / scene.faces.len().max(1)).isqrt() as u32;
        let side = largest.min(texels.max(2 * MIN_TEXELS_PER_SIDE));
        if side < MIN_TEXELS_PER_SIDE {
            return Ok(None);
        }
        let report = |_: &str, done| watch.report_share("truth", done);
        let fine = solve_matrix(scene, side, &ProgressMonitor::new(&report))?;
        let coarse = solve_matrix(scene, side / 2, &without_progress())?;
        let mut truth = Self {
            scene: scene.clone(),
            resolutions: fine.resolutions,
            values: fine.values,
            info: TruthInfo {
                name: format!("the matrix solver on {side}×{side} texels a face"),
                texels: side,
                own_error: f64::NAN,
            },
        };
        truth.info.own_error = truth.relative_error_of(&coarse);
        Ok(Some(truth))
    }

    /// Returns the relative RMS of a field on the texels of `mesh`, averaged on a common grid.
    pub fn relative_error(&self, mesh: &Mesh, field: &RadiosityField) -> f64 {
        self.relative_error_of(&ReflectedField::from_field(&self.scene, mesh, field))
    }

    fn relative_error_of(&self, solution: &ReflectedField) -> f64 {
        let truth = ReflectedField {
            scene: &self.scene,
            resolutions: self.resolutions.clone(),
            values: self.values.clone(),
        };
        match GridPair::new(solution, &truth, None) {
            Ok(pair) => pair.worst_channel().0,
            Err(_) => f64::NAN,
        }
    }
}

fn solve_matrix<'a>(scene: &'a Scene, texels: u32, watch: &ProgressMonitor) -> Result<ReflectedField<'a>> {
    let solved = scene.solve_once(&dense::dense_settings(texels), SolverChoice::Dense, watch)?;
    Ok(ReflectedField::from_field(scene, &solved.mesh, &solved.run.field))
}
