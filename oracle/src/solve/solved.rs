//! A task, solved once.

use super::moved::Moved;
use common::mesh::Mesh;
use common::settings::Settings;
use common::shooting::Run;
use cpu::matrix::{self, Quality};
use glam::Vec4;
use serde_json::{Value, json};

/// What one solve came to.
pub struct Solved {
    /// With which options.
    pub settings: Settings,
    /// Its texels.
    pub mesh: Mesh,
    /// The solve.
    pub run: Run,
    /// Whether single shots took the place of the passes that were asked for, for want of room.
    pub one_by_one: bool,
    /// What the matrix says beside it.
    pub matrix: Option<Dense>,
    /// What a solve to an error says beside it.
    pub moved: Option<Moved>,
    /// What a relight knows beside it.
    pub relit: Option<Recovered>,
}

/// What the matrix says beside its run.
pub struct Dense {
    /// Of the form factors.
    pub quality: Quality,
    /// In f64.
    pub answer: matrix::Answer,
}

impl Dense {
    /// For `result.json`.
    pub fn described(&self) -> Value {
        let Quality {
            closure_max,
            closure_mean,
            reciprocity,
            visibility,
            exact_pairs,
            hidden_pairs,
            sampled_pairs,
            bytes,
        } = self.quality;
        json!({
            "closure": { "max": closure_max, "mean": closure_mean },
            "reciprocity": reciprocity,
            "visibility": visibility,
            "residual": self.answer.residual,
            "exact_pairs": exact_pairs,
            "hidden_pairs": hidden_pairs,
            "sampled_pairs": sampled_pairs,
            "bytes": bytes,
        })
    }
}

/// What a relight knows beside its solve.
pub struct Recovered {
    /// B₀.
    pub before: Vec<Vec4>,
    /// Texels of the room that were found to emit.
    pub emitters: usize,
    /// Whether all that was captured was shot.
    pub complete: bool,
    /// Shots of the room's cells.
    pub map_shots: usize,
    /// Shots of the objects'.
    pub object_shots: usize,
}

impl Recovered {
    /// Texels with B below 0 in some channel, by more than the rounding of B₀ + δ: half an ulp of
    /// what the texel had a shot.
    pub fn negative_texels(&self, run: &Run) -> usize {
        let roundings = run.shots.len() as f32 * f32::EPSILON;
        let negative = |(b, before): &(&Vec4, &Vec4)| {
            let bound = before.truncate() * roundings;
            b.truncate().cmplt(-bound).any()
        };
        let values = run.field.radiosity.iter().zip(&self.before);
        values.filter(negative).count()
    }
}
