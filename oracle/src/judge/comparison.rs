//! What `compare` finds out about one scene: plain data, filled by [`crate::judge::compare`], judged by
//! its gates, told by [`crate::show::report`].

use crate::solve::check::Estimate;
use crate::solve::solver::Asked;
use common::energy::Energy;
use common::mesh::Mesh;
use common::scene::Scene;
use common::settings::Settings;
use common::shooting::Run;
use serde::Serialize;

/// How far field a is from field b: reflected part B − E, area-weighted, the worst channel.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Difference {
    /// √(ΣA(a−b)² / ΣA b²).
    pub relative_rms: f64,
    /// max|a−b| / rms(b).
    pub max_relative: f64,
    /// ΣA(a−b) / ΣA b, the channel with the largest magnitude.
    pub bias: f64,
}

/// One shader stage against its twin on the same input.
#[derive(Clone, Debug, Serialize)]
pub struct Stage {
    /// The shader.
    pub name: String,
    /// Values compared.
    pub values: u64,
    /// Values that differ at all.
    pub differing: u64,
    /// Largest difference, in what the reason says.
    pub worst: f64,
    /// What may differ.
    pub bound: f64,
    /// In words.
    pub reason: String,
    /// Whether the bound holds.
    pub agree: bool,
}

/// Item buffer against rays over all (shooter, texel) pairs.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Pairs {
    /// Shooters × texels.
    pub pairs: u64,
    /// Pairs of points (one a sample) with a form factor: each sees the other's front, were nothing
    /// in between.
    pub facing: u64,
    /// Facing pairs on which rays and item buffer disagree.
    pub mismatched: u64,
    /// Mismatches within the derived bound of an ID boundary.
    pub explained: u64,
    /// Explained ones by a true outline too thin to show in the buffer.
    pub vanished: u64,
    /// The others.
    pub unexplained: u64,
    /// Facing pairs within that bound of a boundary in the buffer, and all explained ones.
    pub explainable: u64,
    /// Σ F·A of the mismatched over Σ F·A of the facing pairs.
    pub weighted_mismatch: f64,
    /// The same of the explainable ones: what silhouettes could come to.
    pub weighted_explainable: f64,
    /// Mismatches by distance to the boundary in pixels: bin k is [k/2, (k+1)/2).
    pub histogram: Vec<u64>,
    /// Up to a dozen unexplained pairs (cell, texel), for the report.
    pub examples: Vec<(u32, u32)>,
}

/// One condition of the verdict.
#[derive(Clone, Debug, Serialize)]
pub struct Gate {
    /// What is asked.
    pub name: String,
    /// What was measured.
    pub value: f64,
    /// What it may be at most.
    pub bound: f64,
    /// Where the bound comes from.
    pub reason: String,
    /// value ≤ bound; false for NaN.
    pub pass: bool,
}

impl Gate {
    /// value ≤ bound, and NaN fails.
    pub fn at_most(name: &str, value: f64, bound: f64, reason: &str) -> Self {
        Self {
            name: name.to_owned(),
            value,
            bound,
            reason: reason.to_owned(),
            pass: value <= bound,
        }
    }
}

/// The item buffer of one shot, for the report.
#[derive(Clone, Debug)]
pub struct ItemBufferPicture {
    /// The shooter.
    pub cell: u32,
    /// Pixels per side.
    pub size: u32,
    /// Face IDs + 1, row-major, 0 where nothing was drawn.
    pub ids: Vec<u32>,
}

/// What the method itself errs by: no fault of the code, and no condition of the verdict.
#[derive(Clone, Debug, Serialize)]
pub struct Finding {
    /// What.
    pub name: String,
    /// How much.
    pub value: f64,
    /// What it comes from, and the option that mends it.
    pub message: String,
}

/// How a scene is solved, and why it is judged.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Way {
    /// Whole faces, discs, one sample, an item buffer, one shot after the other.
    Paper,
    /// What `solve` does by default.
    Solve,
    /// What the options say.
    Asked,
}

impl Way {
    /// In words.
    pub fn name(self) -> &'static str {
        match self {
            Self::Paper => "the paper's way",
            Self::Solve => "as solve does",
            Self::Asked => "as asked for",
        }
    }
}

/// A scene solved by both in one way, and all differences.
pub struct Comparison {
    /// The scene.
    pub scene: Scene,
    /// Which way.
    pub way: Way,
    /// The error that was asked for; none: shooting.
    pub asked: Option<Asked>,
    /// Its texels.
    pub mesh: Mesh,
    /// Options of the CPU (rays); the GPU's differ in `visibility` only.
    pub settings: Settings,
    /// Options of the GPU.
    pub gpu_settings: Settings,
    /// The GPU.
    pub adapter: String,
    /// Free run on the CPU.
    pub cpu: Run,
    /// Free run on the GPU.
    pub gpu: Run,
    /// The CPU's shooters replayed on the GPU; to an error, the CPU by the GPU's way of deciding.
    pub lockstep: Run,
    /// Balance of the CPU's free run.
    pub cpu_energy: Energy,
    /// Balance of the GPU's free run.
    pub gpu_energy: Energy,
    /// Seconds of the free runs: CPU, GPU.
    pub seconds: [f64; 2],
    /// WGSL against twin.
    pub stages: Vec<Stage>,
    /// Item buffer against rays.
    pub pairs: Pairs,
    /// GPU against CPU, same shooters, or the same decisions.
    pub lockstep_difference: Difference,
    /// GPU against CPU, each choosing for itself.
    pub free_difference: Difference,
    /// How far each says it may be off, and what of it: CPU, GPU.
    pub estimates: [Option<Estimate>; 2],
    /// The same of the CPU by texel, W/m².
    pub off: Option<Vec<f32>>,
    /// Error against the truth: CPU, GPU.
    pub error: [Option<f64>; 2],
    /// What the truth is.
    pub truth: Option<Told>,
    /// A shot's item buffer; none where nothing is shot.
    pub item_buffer: Option<ItemBufferPicture>,
    /// The conditions; the solvers agree when all hold.
    pub gates: Vec<Gate>,
    /// What the method errs by.
    pub findings: Vec<Finding>,
    /// What was chosen and why, a line each.
    pub notes: Vec<String>,
}

impl Comparison {
    /// How far the CPU, or the GPU, says it may be off.
    pub fn estimated(&self, side: usize) -> Option<f64> {
        self.estimates[side].as_ref().map(|estimate| estimate.error)
    }

    /// The verdict; a comparison without conditions agrees with nothing.
    pub fn agree(&self) -> bool {
        !self.gates.is_empty() && self.gates.iter().all(|gate| gate.pass)
    }
}

/// A scene and all ways in which it was judged.
pub struct Judged {
    /// The paper's way, or the one that was asked for.
    pub first: Comparison,
    /// What `solve` does by default, where nothing was asked for.
    pub as_solved: Option<Comparison>,
}

impl Judged {
    /// What users get comes first.
    pub fn ways(&self) -> impl Iterator<Item = &Comparison> {
        self.as_solved.iter().chain([&self.first])
    }

    /// Whether all ways agree.
    pub fn agree(&self) -> bool {
        self.ways().all(Comparison::agree)
    }
}

/// What a truth is, and how far it may itself be off.
#[derive(Clone, Debug, Serialize)]
pub struct Told {
    /// In words.
    pub name: String,
    /// Texels a side of a face.
    pub texels: u32,
    /// How far the matrix of half as many texels a side is from it, relative RMS: its own error is
    /// below that, since texels err by their size or its square.
    pub own_error: f64,
}
