//! Cases and trials. A case generates scenes from one parameter; a trial is its scene at one value,
//! with resolution, truth and methods.

use super::CaseInfo;
use common::Result;
use common::scene::Scene;
use glam::DVec3;

/// Function that builds the trial of a value.
pub type BuildTrial = fn(f64) -> Result<Trial>;

/// A family of scenes with one parameter, built to break a method.
#[derive(Clone, Copy)]
pub struct Case {
    /// Description.
    pub info: CaseInfo,
    /// Values of the parameter, easy to hard.
    pub values: &'static [f64],
    /// Builds the trial at a value.
    pub build: BuildTrial,
}

/// A scene with resolution, truth and methods.
pub struct Trial {
    /// The scene.
    pub scene: Scene,
    /// Texels per side of every face.
    pub texels: u32,
    /// Source of the truth.
    pub truth: TrialTruth,
    /// Judged faces; if empty, all.
    pub judged: Vec<usize>,
    /// Methods to run.
    pub suite: MethodSuite,
}

/// Source of a trial's truth, which shares no code with the solvers under test.
pub enum TrialTruth {
    /// Direct light without occlusion: exact mean form factors of the texels.
    Direct,
    /// Direct light occluded by these faces.
    Shadowed(Vec<usize>),
    /// B − E of every texel, W/m².
    Constant(DVec3),
    /// The dense solver's answer on texels finer by this factor, averaged.
    Matrix(u32),
    /// The dense solver's answer for an equivalent scene, on texels finer by this factor.
    Alike(Scene, u32),
    /// B − E of each texel by path tracing, and its standard error, W/m².
    Traced(Vec<DVec3>, Vec<DVec3>),
    /// No light on the judged faces.
    Dark,
}

/// Methods that run on a trial.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum MethodSuite {
    /// All methods of the solve cases.
    All,
    /// Only these methods, where others take minutes or show nothing.
    Only(&'static [&'static str]),
    /// Relighting methods; the first faces, of this number, are the room, the others the objects.
    Relight(usize),
}

impl Trial {
    /// Makes a trial of every method that judges all faces.
    pub fn new(scene: Scene, texels: u32, truth: TrialTruth) -> Self {
        Self {
            scene,
            texels,
            truth,
            judged: Vec::new(),
            suite: MethodSuite::All,
        }
    }

    /// Restricts the judged faces.
    pub fn with_judged(self, judged: impl IntoIterator<Item = usize>) -> Self {
        Self {
            judged: judged.into_iter().collect(),
            ..self
        }
    }

    /// Restricts the methods.
    pub fn with_methods(self, methods: &'static [&'static str]) -> Self {
        Self {
            suite: MethodSuite::Only(methods),
            ..self
        }
    }

    /// Makes it a relight: the first `room` faces are the room, the others the objects.
    pub fn into_relight(self, room: usize) -> Self {
        Self {
            suite: MethodSuite::Relight(room),
            ..self
        }
    }

    /// Returns whether a face is judged.
    pub fn is_judged(&self, face: usize) -> bool {
        self.judged.is_empty() || self.judged.contains(&face)
    }
}
