//! A trial: the scene of a case at one value, with resolution, truth and judged faces.

use super::ErrorMeasure;
use common::scene::Scene;
use glam::DVec3;
use std::ops::Range;

/// A scene with resolution and truth.
pub struct Trial {
    /// The scene.
    pub scene: Scene,
    /// Texels per side of every face.
    pub texels: u32,
    /// Source of the truth.
    pub truth: TrialTruth,
    /// Judged faces.
    pub judged: Range<usize>,
    /// Number of the first faces that are the room of a relight, the others being the objects; 0 for a solve.
    pub room: usize,
    /// Description of a random scene.
    pub description: Option<String>,
}

/// Source of a trial's truth, which shares no code with the solvers under test.
pub enum TrialTruth {
    /// Exact mean form factors of the texels to what these occluders leave of the lamps.
    Direct(Range<usize>),
    /// B − E of every texel, W/m².
    Constant(DVec3),
    /// The dense solver's answer for a scene that has the same solution, on texels twice as fine, averaged.
    Dense(Scene),
    /// B − E of each texel by path tracing, and its standard error, W/m².
    Traced(Vec<DVec3>, Vec<DVec3>),
    /// No light on the judged faces.
    Dark,
}

impl Trial {
    /// Makes a solve that judges all faces.
    pub fn new(scene: Scene, texels: u32, truth: TrialTruth) -> Self {
        Self {
            judged: 0..scene.faces.len(),
            scene,
            texels,
            truth,
            room: 0,
            description: None,
        }
    }

    /// Returns the measure of its error.
    pub fn measure(&self) -> ErrorMeasure {
        match self.truth {
            TrialTruth::Dark => ErrorMeasure::Leak,
            _ => ErrorMeasure::RelativeRms,
        }
    }
}
