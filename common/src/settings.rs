//! The options that a solve obeys; each is written to `result.json`.

use crate::form_factor::FormFactor;
use serde::Serialize;

/// How it is decided whether a texel sees a shooter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Visibility {
    /// Rays between points of the shooter and points of the texel.
    Rays,
    /// Item buffer by Table 3 as printed (vertices only, planar depth, half a unit deep).
    Paper,
    /// Item buffer, orthographic hemisphere, corrected.
    Hemisphere,
    /// Item buffer, stereographic hemisphere.
    Stereographic,
    /// Item buffer, the five sides of a half cube.
    Hemicube,
}

impl Visibility {
    /// Planes of the item buffer's image: the hemicube's sides, or the one of a disc.
    pub fn sides(self) -> u32 {
        if self == Self::Hemicube { 5 } else { 1 }
    }
}

/// How faces get into the item buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Raster {
    /// Every pixel's own ray is intersected with the faces whose image may lie there.
    Pixel,
    /// Faces are cut into triangles, whose projected corners are drawn.
    Tessellated,
}

/// Which item buffer pixels a texel asks for its ID.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Lookup {
    /// The pixel that holds its projection.
    Exact,
    /// That pixel or any of its eight neighbours, unless a face seen there hides the texel.
    #[serde(rename = "3x3")]
    Neighbours,
}

impl Lookup {
    /// How many pixels to each side of its own.
    pub fn reach(self) -> i32 {
        match self {
            Self::Exact => 0,
            Self::Neighbours => 1,
        }
    }
}

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

/// How good an answer is asked for: texels, cells, samples and ε together.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Quality {
    /// A first look: 8×8 texels, 2×2 cells, centre to centre, ε = 1 %.
    Draft,
    /// 16×16 texels, 4×4 cells, 4 samples, ε = 0.1 %.
    #[default]
    Normal,
    /// 16×16 texels, 16 samples, ε = 0.01 %, and cells halved until the answer settles.
    Reference,
}

impl Quality {
    /// Texels a side, cells a side, samples and ε; `Reference` starts with these cells.
    pub fn settings(self) -> (u32, u32, u32, f64) {
        match self {
            Self::Draft => (8, 2, 1, 1e-2),
            Self::Normal => (16, 4, 4, 1e-3),
            Self::Reference => (16, 4, 16, 1e-4),
        }
    }
}

/// The settings of a solve.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct Settings {
    /// What the options below that were not given are taken from.
    pub quality: Quality,
    /// Texels per side of a face.
    pub texels: u32,
    /// Stop when unshot power ≤ ε × emitted power.
    pub epsilon: f64,
    /// Stop after this many shots.
    pub max_shots: u32,
    /// Who shoots next.
    pub iteration: Iteration,
    /// Visibility.
    pub visibility: Visibility,
    /// Item buffer pixels per side.
    pub item_buffer: u32,
    /// Item buffer raster, where the visibility leaves a choice: see [`Settings::raster`].
    pub raster: Raster,
    /// Item buffer lookup.
    pub lookup: Lookup,
    /// Form factor.
    pub form_factor: FormFactor,
    /// Each face shoots as K×K cells.
    pub cells: u32,
    /// Pairs of points by which a texel sees a cell; 1: centre to centre.
    pub samples: u32,
    /// Whether each shot's form factors are scaled to the exact closure.
    pub conserve: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            quality: Quality::Normal,
            texels: 16,
            epsilon: 1e-3,
            max_shots: 1_000_000,
            iteration: Iteration::Southwell,
            visibility: Visibility::Rays,
            item_buffer: 1024,
            raster: Raster::Pixel,
            lookup: Lookup::Neighbours,
            form_factor: FormFactor::Polygon,
            cells: 4,
            samples: 1,
            conserve: false,
        }
    }
}

impl Settings {
    /// The raster in force: Table 3 draws vertices, the hemicube asks pixels.
    pub fn raster(&self) -> Raster {
        match self.visibility {
            Visibility::Paper => Raster::Tessellated,
            Visibility::Hemicube => Raster::Pixel,
            _ => self.raster,
        }
    }
}
