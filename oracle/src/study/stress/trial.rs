//! A case is a generator with one parameter; a trial is what it makes at one value: a scene, the
//! question, and how the truth is known.

use super::About;
use common::Result;
use common::scene::Scene;
use glam::DVec3;

/// Makes a scene and its question of a value.
pub type Build = fn(f64) -> Result<Trial>;

/// One scene family, built to break something.
#[derive(Clone, Copy)]
pub struct Case {
    /// What it is.
    pub about: About,
    /// Values of the parameter, easy to hard.
    pub values: &'static [f64],
    /// The scene at a value.
    pub build: Build,
}

/// A scene and the question.
pub struct Trial {
    /// The scene.
    pub scene: Scene,
    /// Texels a side of every face.
    pub texels: u32,
    /// How the truth is known.
    pub truth: Truth,
    /// The faces that are judged; none: all.
    pub judged: Vec<usize>,
    /// Who tries.
    pub suite: Suite,
}

/// How the truth is known; never by what the solvers share.
pub enum Truth {
    /// Light goes one way and nothing hides it: Lambert's exact means over the texels.
    Direct,
    /// The same, with these faces in between.
    Shadowed(Vec<usize>),
    /// B − E of every face is this.
    Constant(DVec3),
    /// The matrix on texels so many times finer, averaged.
    Matrix(u32),
    /// The matrix's answer for a scene that should be lit alike, on texels so many times finer.
    Alike(Scene, u32),
    /// B − E of each texel by tracing paths, and its standard error.
    Traced(Vec<DVec3>, Vec<DVec3>),
    /// No light at all on the faces that are judged.
    Dark,
}

/// Who tries.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Suite {
    /// Every way to solve.
    All,
    /// Only these: the others would take minutes, or cannot tell anything.
    Only(&'static [&'static str]),
    /// The first so many faces are a room into which the others are put.
    Relight(usize),
}

impl Trial {
    /// All faces judged, every method.
    pub fn new(scene: Scene, texels: u32, truth: Truth) -> Self {
        Self {
            scene,
            texels,
            truth,
            judged: Vec::new(),
            suite: Suite::All,
        }
    }

    /// Only these faces are judged.
    pub fn judging(self, judged: impl IntoIterator<Item = usize>) -> Self {
        Self {
            judged: judged.into_iter().collect(),
            ..self
        }
    }

    /// Only these methods try.
    pub fn only(self, methods: &'static [&'static str]) -> Self {
        Self {
            suite: Suite::Only(methods),
            ..self
        }
    }

    /// The first `room` faces are a room, the others objects in it.
    pub fn relit(self, room: usize) -> Self {
        Self {
            suite: Suite::Relight(room),
            ..self
        }
    }

    /// Whether a face is judged.
    pub fn judges(&self, face: usize) -> bool {
        self.judged.is_empty() || self.judged.contains(&face)
    }
}
