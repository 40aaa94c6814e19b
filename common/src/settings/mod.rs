//! Options of a solve, grouped by the stage that reads them. Those in force are written to
//! `result.json`.

mod visibility;

pub use visibility::{ItemBufferProjection, ItemBufferSettings, Lookup, Visibility};

use crate::form_factor::FormFactor;
use serde::Serialize;

/// Choice of the next shooters, and of their share of the residual.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Iteration {
    /// The patch with the most unshot power shoots to every texel (Southwell relaxation; Cohen 1988, the
    /// paper).
    Southwell,
    /// All patches shoot: Chebyshev semi-iteration by the largest reflectance.
    Chebyshev,
    /// All patches shoot, along conjugate directions (conjugate gradients).
    Cg,
}

/// Preset of texels, patches, samples and ε.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum SolveQuality {
    /// Preview: 8×8 texels, 2×2 patches, centre to centre, ε = 1 %.
    Draft,
    /// 16×16 texels, 4×4 patches, 4 samples, ε = 0.1 %.
    #[default]
    Normal,
    /// 16×16 texels, 8×8 patches, 16 samples, ε = 0.01 %.
    Reference,
}

impl SolveQuality {
    /// Texels per side, patches per side and samples of the preset.
    pub const fn meshing(self) -> Meshing {
        let (texels, patches, samples) = match self {
            Self::Draft => (8, 2, 1),
            Self::Normal => (16, 4, 4),
            Self::Reference => (16, 8, 16),
        };
        Meshing {
            texels,
            patches,
            samples,
        }
    }

    /// Share of the emitted power that may stay unshot, ε, of the preset.
    pub const fn epsilon(self) -> f64 {
        match self {
            Self::Draft => 1e-2,
            Self::Normal => 1e-3,
            Self::Reference => 1e-4,
        }
    }
}

/// Settings of a solve; files hold all options at one level.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Settings {
    /// Preset of the options that were not given.
    pub quality: SolveQuality,
    /// Resolution of the mesh.
    #[serde(flatten)]
    pub meshing: Meshing,
    /// Light transport from patches to texels.
    #[serde(flatten)]
    pub transport: Transport,
    /// Choice of shooters, and the end of the solve.
    #[serde(flatten)]
    pub schedule: Schedule,
}

impl Settings {
    /// Returns the settings with another visibility.
    pub fn with_visibility(mut self, visibility: Visibility) -> Self {
        self.transport.visibility = visibility;
        self
    }

    /// Returns the settings of a preset, all else by default.
    pub fn with_quality(quality: SolveQuality) -> Self {
        Self {
            quality,
            meshing: quality.meshing(),
            transport: Transport::default(),
            schedule: Schedule {
                epsilon: quality.epsilon(),
                ..Schedule::default()
            },
        }
    }
}

/// Resolution of a mesh (see [`crate::cover::sampled_mesh`]).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct Meshing {
    /// Texels per side of a face.
    pub texels: u32,
    /// Patches per side of a face.
    #[serde(rename = "cells")]
    pub patches: u32,
    /// Visibility samples between a texel and a patch; 1: centre to centre.
    pub samples: u32,
}

impl Default for Meshing {
    fn default() -> Self {
        Self {
            texels: 16,
            patches: 4,
            samples: 1,
        }
    }
}

/// Light transport from patches to texels; the engines read it to make links.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct Transport {
    /// Visibility.
    #[serde(flatten)]
    pub visibility: Visibility,
    /// Form factor.
    pub form_factor: FormFactor,
    /// Scales each shot's form factors to the exact closure.
    pub conserve: bool,
}

impl Default for Transport {
    fn default() -> Self {
        Self {
            visibility: Visibility::Rays,
            form_factor: FormFactor::Polygon,
            conserve: false,
        }
    }
}

/// Choice of shooters, and the end of the solve; the solve loops read it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct Schedule {
    /// Choice of the next shooters.
    pub iteration: Iteration,
    /// Stops when unshot power ≤ ε × emitted power.
    pub epsilon: f64,
    /// Stops after this many shots.
    pub max_shots: u32,
}

impl Default for Schedule {
    fn default() -> Self {
        Self {
            iteration: Iteration::Southwell,
            epsilon: 1e-3,
            max_shots: 1_000_000,
        }
    }
}

impl Schedule {
    /// Returns the schedule with Southwell relaxation: one patch shoots at a time.
    pub fn with_southwell(self) -> Self {
        Self {
            iteration: Iteration::Southwell,
            ..self
        }
    }
}
