//! Presets of a comparison: the requested settings, or without a request the defaults of `solve` and the paper's
//! settings. All are compared with one truth.

use super::truth::MatrixTruth;
use super::{ComparisonRequest, compare_shooting, hierarchical};
use crate::compare::comparison::{Comparison, Preset, SceneComparison};
use crate::solve::progress::ProgressMonitor;
use crate::solve::solver::ErrorTarget;
use common::Result;
use common::scene::Scene;
use common::settings::Settings;
use gpu::{Gpu, ShaderFault};

/// Presets to compare; `visibility` is the GPU's.
pub enum PresetSelection {
    /// The paper's settings, and the defaults of `solve` (to an error).
    PaperAndDefault {
        /// Whole faces, discs, single shots.
        paper: Settings,
        /// Requested error.
        target: ErrorTarget,
    },
    /// Progressive shooting with these settings.
    Shooting(Settings),
    /// Hierarchical solve to an error.
    ToError(ErrorTarget, Settings),
}

/// Compares CPU and GPU on `scene` with all presets.
///
/// Errors: the scene is invalid, a solver fails, or `watch` interrupts.
pub fn compare_presets(
    scene: &Scene,
    selection: &PresetSelection,
    gpu: &Gpu,
    faults: &[ShaderFault],
    watch: &ProgressMonitor,
) -> Result<SceneComparison> {
    let (PresetSelection::PaperAndDefault { paper: settings, .. }
    | PresetSelection::Shooting(settings)
    | PresetSelection::ToError(_, settings)) = selection;
    let shooting = |settings: &Settings| {
        let request = ComparisonRequest {
            settings: *settings,
            gpu,
            faults,
        };
        compare_shooting(scene, &request, watch)
    };
    let to_error =
        |target: &ErrorTarget| hierarchical::compare_hierarchical(scene, *target, settings, (gpu, faults), watch);
    let truth = MatrixTruth::new(scene, settings.meshing.texels, watch)?;
    let truth = truth.as_ref();
    Ok(match selection {
        PresetSelection::Shooting(settings) => {
            single_comparison(compare_to_truth(shooting(settings)?, truth, Preset::Requested))
        }
        PresetSelection::ToError(target, _) => {
            single_comparison(compare_to_truth(to_error(target)?, truth, Preset::Requested))
        }
        PresetSelection::PaperAndDefault { paper, target } => SceneComparison {
            solve_default: Some(compare_to_truth(to_error(target)?, truth, Preset::SolveDefault)),
            first: compare_to_truth(shooting(paper)?, truth, Preset::Paper),
        },
    })
}

fn single_comparison(first: Comparison) -> SceneComparison {
    SceneComparison {
        first,
        solve_default: None,
    }
}

/// Sets the preset of the comparison and the errors of its runs against the truth.
fn compare_to_truth(mut comparison: Comparison, truth: Option<&MatrixTruth>, preset: Preset) -> Comparison {
    comparison.preset = preset;
    comparison.truth = truth.map(|truth| truth.info.clone());
    comparison.truth_error = [&comparison.cpu, &comparison.gpu]
        .map(|run| truth.map(|truth| truth.relative_error(&comparison.mesh, &run.field)));
    comparison
}
