//! The paper's Table 4, repeated: its room, its texels, its item buffers; the whole scene solved
//! (reference), Table 2 (paper) and the signed form, each with its error against the full solution.
//!
//! As the paper did it: whole faces shoot, one point each, orthographic item buffer, one pixel per
//! texel; stopped when 5 % is unshot (with that the reference takes the paper's 320 to 330 shots).

pub mod grid;
pub mod page;

use crate::show::picture::Picture;
use common::relight::{Mended, Method};
use serde::Serialize;

/// What a row was made by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Image {
    /// The whole scene, by plain shooting.
    Reference,
    /// Table 2.
    Paper,
    /// Table 2, but only what the objects hide is darkened (V₀ − V).
    Mended,
    /// Signed residuals, stopped at 1.1 times the shots of Table 2.
    #[serde(rename = "signed-early")]
    SignedEarly,
    /// Signed residuals.
    Signed,
}

impl Image {
    /// All of them, in the table's order.
    pub const ALL: [Self; 5] = [
        Self::Reference,
        Self::Paper,
        Self::Mended,
        Self::SignedEarly,
        Self::Signed,
    ];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Reference => "reference",
            Self::Paper => "paper",
            Self::Mended => "paper, V₀ − V",
            Self::SignedEarly => "signed, early",
            Self::Signed => "signed",
        }
    }

    /// How it relights; none: everything is solved.
    pub fn method(self) -> Option<Method> {
        let mended = |empty_room| {
            Method::Paper(Mended {
                empty_room,
                object_shadows: empty_room,
                ..Mended::default()
            })
        };
        match self {
            Self::Reference => None,
            Self::Paper => Some(mended(false)),
            Self::Mended => Some(mended(true)),
            Self::SignedEarly | Self::Signed => Some(Method::Signed),
        }
    }
}

/// One line of the table.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// What it is.
    pub image: Image,
    /// Texels a side of a face.
    pub texels: u32,
    /// Item buffer pixels a side.
    pub item_buffer: u32,
    /// Seconds of visibility and shots.
    pub seconds: f64,
    /// All shots.
    pub shots: usize,
    /// Those of the room, and of the objects.
    pub map_shots: usize,
    /// Shots of the objects.
    pub object_shots: usize,
    /// Relative RMS of B − E against the full solution on the same item buffers.
    pub error: f64,
    /// The same against the full solution by rays.
    pub error_rays: f64,
    /// What the balance of power misses, over the emitted power.
    pub imbalance: f64,
    /// Texels below 0.
    pub negative_texels: usize,
    /// What the paper prints: seconds (2006), shots.
    pub paper: Option<(f64, u32)>,
}

/// What the paper's Table 4 says of this row.
pub fn printed(image: Image, texels: u32, item_buffer: u32) -> Option<(f64, u32)> {
    match (image, texels, item_buffer) {
        (Image::Reference, 16, 1024) => Some((34.0, 322)),
        (Image::Reference, 32, 1024) => Some((41.0, 334)),
        (Image::Paper, 16, 256) => Some((11.0, 182)),
        (Image::Paper, 16, 512) => Some((13.0, 182)),
        (Image::Paper, 32, 512) => Some((18.0, 185)),
        (Image::Paper, 32, 1024) => Some((24.0, 185)),
        _ => None,
    }
}

/// A picture of a row.
pub struct Shown {
    /// Its place in the table.
    pub row: usize,
    /// What the camera sees.
    pub picture: Picture,
}

/// A figure of the paper again.
pub struct Figure {
    /// Its number and what it shows.
    pub title: String,
    /// Pictures and what each is.
    pub pictures: Vec<(String, Picture)>,
}

/// Everything that was measured.
#[derive(Default)]
pub struct Table {
    /// The lines.
    pub rows: Vec<Row>,
    /// The same as pictures.
    pub shown: Vec<Shown>,
    /// Figures 8 and 10.
    pub figures: Vec<Figure>,
    /// Who solved.
    pub adapter: String,
    /// Faces, and those of the objects.
    pub faces: [usize; 2],
}
