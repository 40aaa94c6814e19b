//! The options that a solve obeys, by who takes them; each that is in force is written to
//! `result.json`.

mod visibility;

pub use visibility::{Drawing, Lookup, Projection, Raster, Visibility};

use crate::form_factor::FormFactor;
use serde::Serialize;

/// Which cells shoot next, and how much.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Iteration {
    /// The one with most unshot power, to every texel (Cohen 1988, the paper).
    Southwell,
    /// All of them, by Chebyshev's polynomials of the largest reflectance.
    Chebyshev,
    /// All of them, along conjugate directions.
    Cg,
}

/// How finely it is shot: texels, cells, samples and ε together.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Quality {
    /// A first look: 8×8 texels, 2×2 cells, centre to centre, ε = 1 %.
    Draft,
    /// 16×16 texels, 4×4 cells, 4 samples, ε = 0.1 %.
    #[default]
    Normal,
    /// 16×16 texels, 8×8 cells, 16 samples, ε = 0.01 %.
    Reference,
}

impl Quality {
    /// Texels a side, cells a side and samples.
    pub const fn meshing(self) -> Meshing {
        let (texels, cells, samples) = match self {
            Self::Draft => (8, 2, 1),
            Self::Normal => (16, 4, 4),
            Self::Reference => (16, 8, 16),
        };
        Meshing {
            texels,
            cells,
            samples,
        }
    }

    /// ε.
    pub const fn epsilon(self) -> f64 {
        match self {
            Self::Draft => 1e-2,
            Self::Normal => 1e-3,
            Self::Reference => 1e-4,
        }
    }
}

/// The settings of a solve; in files all options lie side by side.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Settings {
    /// What the options below that were not given are taken from.
    pub quality: Quality,
    /// How the mesh is made.
    #[serde(flatten)]
    pub meshing: Meshing,
    /// How light goes from cells to texels.
    #[serde(flatten)]
    pub transport: Transport,
    /// Who shoots, and until when.
    #[serde(flatten)]
    pub schedule: Schedule,
}

impl Settings {
    /// The same by another visibility.
    pub fn by(mut self, visibility: Visibility) -> Self {
        self.transport.visibility = visibility;
        self
    }

    /// What a quality asks for, all else by default.
    pub fn of(quality: Quality) -> Self {
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

/// How a mesh is made: for [`crate::cover::sampled`] and its like.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct Meshing {
    /// Texels per side of a face.
    pub texels: u32,
    /// Each face shoots as K×K cells.
    pub cells: u32,
    /// Pairs of points by which a texel sees a cell; 1: centre to centre.
    pub samples: u32,
}

impl Default for Meshing {
    fn default() -> Self {
        Self {
            texels: 16,
            cells: 4,
            samples: 1,
        }
    }
}

/// How light goes from cells to texels: for engines, which make links.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct Transport {
    /// Visibility.
    #[serde(flatten)]
    pub visibility: Visibility,
    /// Form factor.
    pub form_factor: FormFactor,
    /// Whether each shot's form factors are scaled to the exact closure.
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

/// Who shoots next, and when that ends: for the loops.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct Schedule {
    /// Who shoots next.
    pub iteration: Iteration,
    /// Stop when unshot power ≤ ε × emitted power.
    pub epsilon: f64,
    /// Stop after this many shots.
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
    /// The same, one cell after the other.
    pub fn one_by_one(self) -> Self {
        Self {
            iteration: Iteration::Southwell,
            ..self
        }
    }
}
