//! The result of one solve. Warnings, files and pages are made from it.

use super::error_estimate::ErrorHistory;
use common::mesh::Mesh;
use common::settings::Settings;
use common::shooting::{Shot, SolveRun};
use cpu::dense::{self, AssemblyQuality};
use glam::Vec4;
use serde_json::{Value, json};

/// The result of one solve.
pub struct Solved {
    /// The options in force.
    pub settings: Settings,
    /// The texels.
    pub mesh: Mesh,
    /// The solution and its shots.
    pub run: SolveRun,
    /// Share of each texel that no body covers, where the solver found it.
    pub open: Option<Vec<f32>>,
    /// True if single shots replaced the requested passes, for lack of memory.
    pub one_by_one: bool,
    /// Details of a dense solve.
    pub dense: Option<DenseReport>,
    /// Steps of an adaptive solve.
    pub history: Option<ErrorHistory>,
    /// Details of a relight.
    pub relight: Option<RelightReport>,
}

impl Solved {
    /// Makes the result of a solve by shooting.
    pub fn new(settings: &Settings, mesh: Mesh, run: SolveRun) -> Self {
        Self {
            settings: *settings,
            mesh,
            run,
            open: None,
            one_by_one: false,
            dense: None,
            history: None,
            relight: None,
        }
    }
}

/// Details of a dense solve beside its run.
pub struct DenseReport {
    /// Quality of the form factors.
    pub quality: AssemblyQuality,
    /// The solution in f64.
    pub solution: dense::DenseSolution,
}

impl DenseReport {
    /// Converts the details for `result.json`.
    pub fn to_json(&self) -> Value {
        let mut details = json!(self.quality);
        details["residual"] = self.solution.residual.into();
        details
    }
}

/// Details of a relight beside its run.
pub struct RelightReport {
    /// Captured radiosity B₀ of each texel, in the mesh's order.
    pub before: Vec<Vec4>,
    /// Number of the room's texels that were recognised as emitters.
    pub emitters: usize,
    /// True if all captured light was shot.
    pub complete: bool,
    /// Shots from the room's patches.
    pub map_shots: usize,
    /// Shots from the objects' patches.
    pub object_shots: usize,
}

impl RelightReport {
    /// Makes the report of a complete relight; counts the shots of room and objects.
    pub fn new(before: Vec<Vec4>, emitters: usize, mesh: &Mesh, run: &SolveRun) -> Self {
        let of_objects = |shot: &&Shot| mesh.is_object(mesh.patches[shot.patch as usize].face);
        let object_shots = run.shots.iter().filter(of_objects).count();
        Self {
            before,
            emitters,
            complete: true,
            map_shots: run.shots.len() - object_shots,
            object_shots,
        }
    }

    /// Number of texels with B below 0 in some channel by more than the rounding of B₀ + δ: half an ulp of
    /// the texel's value per shot.
    pub fn negative_texels(&self, run: &SolveRun) -> usize {
        let roundings = run.shots.len() as f32 * f32::EPSILON;
        let negative = |(b, before): &(&Vec4, &Vec4)| {
            let bound = before.truncate() * roundings;
            b.truncate().cmplt(-bound).any()
        };
        let values = run.field.radiosity.iter().zip(&self.before);
        values.filter(negative).count()
    }
}
