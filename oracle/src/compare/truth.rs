//! Truth of a comparison: the dense solution on as many texels as take a few seconds. The errors of both solvers are
//! measured against it.

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

/// Largest number of texels of the truth: their form factors take about five seconds on two cores; the time
/// grows with the square.
const MAX_TRUTH_TEXELS: usize = 2500;
/// Fewest texels per side of a face: on fewer, shadows would be smaller than texels.
const MIN_TEXELS_PER_SIDE: u32 = 4;

/// Solution of the dense matrix.
pub struct MatrixTruth<'a> {
    solution: ReflectedField<'a>,
    /// Description with its own error.
    pub info: TruthInfo,
}

impl<'a> MatrixTruth<'a> {
    /// Solves the matrix on N×N texels per face, N = `texels` (at least 8) as far as `MAX_TRUTH_TEXELS` allows; none if
    /// N < `MIN_TEXELS_PER_SIDE`. All presets are compared with the same truth.
    ///
    /// Errors: the solver fails or is interrupted.
    pub fn new(scene: &'a Scene, texels: u32, watch: &ProgressMonitor) -> Result<Option<Self>> {
        let largest = (MAX_TRUTH_TEXELS / scene.faces.len().max(1)).isqrt() as u32;
        let side = largest.min(texels.max(2 * MIN_TEXELS_PER_SIDE));
        if side < MIN_TEXELS_PER_SIDE {
            return Ok(None);
        }
        let solve = |texels: u32, watch: &ProgressMonitor| -> Result<ReflectedField<'a>> {
            let solved = scene.solve_once(&dense::dense_settings(texels), SolverChoice::Dense, watch)?;
            Ok(ReflectedField::from_field(scene, &solved.mesh, &solved.run.field))
        };
        let report = |_: &str, done| watch.report_share("truth", done);
        let solution = solve(side, &ProgressMonitor::new(&report))?;
        let info = TruthInfo {
            name: format!("the dense solver on {side}×{side} texels a face"),
            texels: side,
            own_error: relative_rms(&solve(side / 2, &without_progress())?, &solution),
        };
        Ok(Some(Self { solution, info }))
    }

    /// Returns the relative RMS of a field on the texels of `mesh`, averaged on a common grid.
    pub fn relative_error(&self, mesh: &Mesh, field: &RadiosityField) -> f64 {
        let field = ReflectedField::from_field(self.solution.scene, mesh, field);
        relative_rms(&field, &self.solution)
    }
}

fn relative_rms(solution: &ReflectedField, truth: &ReflectedField) -> f64 {
    GridPair::new(solution, truth, None).map_or(f64::NAN, |pair| pair.worst_channel().0)
}
