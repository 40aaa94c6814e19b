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

/// A scene, and the presets with which it is compared.
pub struct SceneRequest {
    /// The scene.
    pub scene: Scene,
    /// The presets.
    pub selection: PresetSelection,
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
    let judge = |comparison: Comparison, preset| Comparison {
        preset,
        truth: truth.as_ref().map(|truth| truth.info.clone()),
        truth_error: [&comparison.cpu, &comparison.gpu]
            .map(|run| Some(truth.as_ref()?.relative_error(&comparison.mesh, &run.field))),
        ..comparison
    };
    let (solve_default, first) = match selection {
        PresetSelection::Shooting(settings) => (None, judge(shooting(settings)?, Preset::Requested)),
        PresetSelection::ToError(target, _) => (None, judge(to_error(target)?, Preset::Requested)),
        PresetSelection::PaperAndDefault { paper, target } => (
            Some(judge(to_error(target)?, Preset::SolveDefault)),
            judge(shooting(paper)?, Preset::Paper),
        ),
    };
    Ok(SceneComparison { first, solve_default })
}
