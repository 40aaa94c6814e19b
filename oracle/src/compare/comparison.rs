//! Results of a comparison of one scene: plain data that [`crate::compare`] fills in and the report shows.

use crate::compare::parting::FirstDivergence;
use crate::diff::difference::Difference;
use crate::solve::regather::ErrorEstimate;
use crate::solve::solver::ErrorTarget;
use common::energy::EnergyBalance;
use common::mesh::Mesh;
use common::scene::Scene;
use common::settings::Settings;
use common::shooting::SolveRun;
use gpu::{Gpu, ShaderFault};
use serde::Serialize;
use stage_check::tally::Tally;
use std::fmt;

/// Inputs of a comparison beside the scene.
pub struct ComparisonRequest<'a> {
    /// Settings; `visibility` is the GPU's, the CPU uses rays.
    pub settings: Settings,
    /// GPU device.
    pub gpu: &'a Gpu,
    /// Faults planted in the shaders, to test that the comparison detects them.
    pub faults: &'a [ShaderFault],
}

/// Comparison of one shader stage with its CPU twin on the same input.
#[derive(Clone, Debug, Serialize)]
pub struct StageCheck {
    /// Name of the stage.
    pub name: String,
    /// Values compared.
    pub values: u64,
    /// Values that differ at all.
    pub differing: u64,
    /// Largest difference, in the unit that `reason` names.
    pub worst: f64,
    /// Largest difference allowed.
    pub bound: f64,
    /// Unit and reason of the bound.
    pub reason: String,
    /// True if `worst` is within `bound`.
    pub agree: bool,
    /// Values beyond the bound; none if the stage agrees.
    pub difference: Option<StageDifference>,
}

impl StageCheck {
    /// Makes the check of a stage from its name, the reason of its bound and its tally; without values it does not pass.
    pub fn of_tally<L: Copy>(
        (name, reason): (&str, &str),
        tally: &Tally<L>,
        difference: Option<StageDifference>,
    ) -> Self {
        Self {
            name: name.to_owned(),
            values: tally.values,
            differing: tally.unequal,
            worst: tally.largest_error,
            bound: tally.bound,
            reason: reason.to_owned(),
            agree: tally.agrees(),
            difference,
        }
    }

    /// Makes the check of a stage that has left no result, or one that cannot be; `reason` is a line on it.
    pub fn without_result(stage: &str, reason: &str) -> Self {
        Self {
            name: stage.to_owned(),
            values: 1,
            differing: 1,
            worst: f64::NAN,
            bound: 0.0,
            reason: reason.to_owned(),
            agree: false,
            difference: None,
        }
    }
}

/// Values of a stage that differ from their twins by more than the bound.
#[derive(Clone, Debug, Serialize)]
pub struct StageDifference {
    /// The value of the lowest element.
    pub first: DifferingValue,
    /// The value with the largest error.
    pub worst: DifferingValue,
    /// Number of such values.
    pub beyond: u64,
    /// Number of compared values.
    pub values: u64,
    /// What the elements have in common.
    pub pattern: String,
}

/// A value of the GPU beside its twin.
#[derive(Clone, Debug, Serialize)]
pub struct DifferingValue {
    /// What the value is, and of which element.
    pub element: String,
    /// The GPU's.
    pub gpu: String,
    /// The twin's, on the same input.
    pub twin: String,
}

impl fmt::Display for DifferingValue {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(
            f,
            "{}: {} on the GPU, {} in the twin",
            self.element, self.gpu, self.twin
        )
    }
}

impl fmt::Display for StageDifference {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{}; ", self.first)?;
        if self.worst.element != self.first.element {
            write!(f, "at worst {}; ", self.worst)?;
        }
        write!(f, "{} of {} differ: {}", self.beyond, self.values, self.pattern)
    }
}

/// Comparison of visibility by item buffer with visibility by rays, over all (shooter, texel) pairs.
#[derive(Clone, Debug, Default, Serialize)]
pub struct VisibilityStatistics {
    /// Shooters × texels.
    pub pairs: u64,
    /// Pairs of points (one per sample) with a positive form factor: their fronts face each other.
    pub facing: u64,
    /// Facing pairs on which rays and item buffer disagree.
    pub mismatched: u64,
    /// Mismatches within the derived bound of an ID boundary, and those in `vanished`.
    pub explained: u64,
    /// Explained mismatches whose true outline is too thin to appear in the buffer.
    pub vanished: u64,
    /// Mismatches without an explanation.
    pub unexplained: u64,
    /// Facing pairs within that bound of an ID boundary, and all explained ones.
    pub explainable: u64,
    /// Σ F·A of the mismatched over Σ F·A of the facing pairs.
    pub weighted_mismatch: f64,
    /// Σ F·A of the explainable over Σ F·A of the facing pairs: the largest share that silhouettes can change.
    pub weighted_explainable: f64,
    /// Mismatches by distance to the boundary in pixels: bin k is [k/2, (k+1)/2).
    pub histogram: Vec<u64>,
    /// Up to a dozen unexplained pairs (patch, texel), for the report.
    pub examples: Vec<(u32, u32)>,
}

/// One criterion of the verdict.
#[derive(Clone, Debug, Serialize)]
pub struct Criterion {
    /// Name of the criterion.
    pub name: String,
    /// Measured value.
    pub value: f64,
    /// Largest value allowed.
    pub bound: f64,
    /// Reason of the bound.
    pub reason: String,
    /// True if value ≤ bound; false for NaN.
    pub pass: bool,
    /// Values that make it fail: both sides of the first and the worst.
    pub difference: Option<StageDifference>,
}

impl Criterion {
    /// Creates the criterion value ≤ bound; NaN fails.
    pub fn at_most(name: &str, value: f64, bound: f64, reason: &str) -> Self {
        Self {
            name: name.to_owned(),
            value,
            bound,
            reason: reason.to_owned(),
            pass: value <= bound,
            difference: None,
        }
    }
}

/// The item buffer of one shot, for the report.
#[derive(Clone, Debug)]
pub struct ItemBufferPicture {
    /// Shooting patch.
    pub patch: u32,
    /// Pixels per side.
    pub size: u32,
    /// Face IDs + 1, row-major, 0 where nothing was drawn.
    pub ids: Vec<u32>,
}

/// Error of the method itself: neither a fault of the code nor a criterion of agreement.
#[derive(Clone, Debug, Serialize)]
pub struct MethodFinding {
    /// Name of the error.
    pub name: String,
    /// Size of the error.
    pub value: f64,
    /// Cause of the error, and the option that reduces it.
    pub message: String,
}

/// Preset of the settings with which a scene is compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Preset {
    /// Whole faces, discs, one sample, an item buffer, one shot after the other.
    Paper,
    /// Defaults of `solve`: to an error.
    #[serde(rename = "solve")]
    SolveDefault,
    /// Settings of the command's options.
    #[serde(rename = "asked")]
    Requested,
}

impl Preset {
    /// Returns a description.
    pub fn name(self) -> &'static str {
        match self {
            Self::Paper => "the paper's settings",
            Self::SolveDefault => "the defaults of solve",
            Self::Requested => "the requested settings",
        }
    }
}

/// A scene solved by CPU and GPU with one preset, and all differences.
pub struct Comparison {
    /// Compared scene.
    pub scene: Scene,
    /// Preset of the settings.
    pub preset: Preset,
    /// Requested error of a hierarchical solve; none for progressive shooting.
    pub error_target: Option<ErrorTarget>,
    /// Patches and texels.
    pub mesh: Mesh,
    /// Settings of the CPU (rays); the GPU's differ in `visibility` only.
    pub settings: Settings,
    /// Settings of the GPU.
    pub gpu_settings: Settings,
    /// Name of the GPU.
    pub adapter: String,
    /// Free run on the CPU.
    pub cpu: SolveRun,
    /// Free run on the GPU.
    pub gpu: SolveRun,
    /// The CPU's shooters replayed on the GPU; in a hierarchical solve, the CPU with the GPU's refinement by rays.
    pub lockstep: SolveRun,
    /// Energy balance of the CPU's free run.
    pub cpu_energy: EnergyBalance,
    /// Energy balance of the GPU's free run.
    pub gpu_energy: EnergyBalance,
    /// Seconds of the free runs: CPU, GPU.
    pub seconds: [f64; 2],
    /// Shader stages against their twins.
    pub stages: Vec<StageCheck>,
    /// Visibility by item buffer against rays.
    pub pairs: VisibilityStatistics,
    /// GPU against CPU with the same shooters, or the same refinement.
    pub lockstep_difference: Difference,
    /// GPU against CPU, each with its own choices.
    pub free_difference: Difference,
    /// Error estimates: CPU, GPU.
    pub estimates: [Option<ErrorEstimate>; 2],
    /// Estimated error of the CPU by texel, W/m².
    pub error_map: Option<Vec<f32>>,
    /// Error against the truth: CPU, GPU.
    pub truth_error: [Option<f64>; 2],
    /// Description of the truth.
    pub truth: Option<TruthInfo>,
    /// Item buffer of a shot; none for rays and hierarchical solves.
    pub item_buffer: Option<ItemBufferPicture>,
    /// Criteria; the solvers agree if all pass.
    pub criteria: Vec<Criterion>,
    /// Errors of the method.
    pub findings: Vec<MethodFinding>,
    /// Where the solvers part; none if it was not searched.
    pub first_divergence: Option<FirstDivergence>,
    /// Notes about choices and their reasons, one line each.
    pub notes: Vec<String>,
}

impl Comparison {
    /// Returns the estimated error of the CPU (side 0) or the GPU (side 1).
    pub fn estimated_error(&self, side: usize) -> Option<f64> {
        self.estimates[side].as_ref().map(|estimate| estimate.error)
    }

    /// True if all criteria pass; false if there are none.
    pub fn solvers_agree(&self) -> bool {
        !self.criteria.is_empty() && self.criteria.iter().all(|criterion| criterion.pass)
    }
}

/// Comparisons of one scene with all requested presets.
pub struct SceneComparison {
    /// Comparison with the paper's or the requested settings.
    pub first: Comparison,
    /// Comparison with the defaults of `solve`; none if settings were requested.
    pub solve_default: Option<Comparison>,
}

impl SceneComparison {
    /// Iterates over the comparisons, the defaults of `solve` first.
    pub fn iter_comparisons(&self) -> impl Iterator<Item = &Comparison> {
        self.solve_default.iter().chain([&self.first])
    }

    /// True if the solvers agree in all comparisons.
    pub fn all_agree(&self) -> bool {
        self.iter_comparisons().all(Comparison::solvers_agree)
    }
}

/// Description of the truth, with its own error.
#[derive(Clone, Debug, Serialize)]
pub struct TruthInfo {
    /// Description.
    pub name: String,
    /// Texels per side of a face.
    pub texels: u32,
    /// Relative RMS of the matrix solution with half as many texels per side against it. Its own error is
    /// smaller, since the error of texels is proportional to their size or its square.
    pub own_error: f64,
}
