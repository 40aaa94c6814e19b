//! Repeats the paper's Table 4 with its room, texels and item buffers: the whole scene solved
//! (reference), Table 2 (paper) and the signed form, each with its error against the full solution.
//!
//! Settings as in the paper: whole faces shoot from one point each, orthographic item buffer, one
//! pixel per texel. Shooting stops at 5 % unshot power, where the reference takes the paper's 320 to
//! 330 shots.

pub mod grid;
pub mod page;

use crate::report::picture::RgbaPicture;
use common::relight::{MendedFlaws, RelightMethod};
use serde::Serialize;

/// Method of a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum TableImage {
    /// Whole scene by progressive refinement.
    Reference,
    /// Algorithm of Table 2.
    Paper,
    /// Table 2, darkening only by the light that the objects hide (V₀ − V).
    Mended,
    /// Signed residuals, stopped after 1.1 times the shots of Table 2.
    #[serde(rename = "signed-early")]
    SignedEarly,
    /// Signed residuals.
    Signed,
}

impl TableImage {
    /// All images, in the table's order.
    pub const ALL: [Self; 5] = [
        Self::Reference,
        Self::Paper,
        Self::Mended,
        Self::SignedEarly,
        Self::Signed,
    ];

    /// Returns the name on the page.
    pub fn name(self) -> &'static str {
        match self {
            Self::Reference => "reference",
            Self::Paper => "paper",
            Self::Mended => "paper, V₀ − V",
            Self::SignedEarly => "signed, early",
            Self::Signed => "signed",
        }
    }

    /// Returns the relighting method; none: the whole scene is solved.
    pub fn relight_method(self) -> Option<RelightMethod> {
        let mended = |empty_room| {
            RelightMethod::Paper(MendedFlaws {
                empty_room,
                object_shadows: empty_room,
                ..MendedFlaws::default()
            })
        };
        match self {
            Self::Reference => None,
            Self::Paper => Some(mended(false)),
            Self::Mended => Some(mended(true)),
            Self::SignedEarly | Self::Signed => Some(RelightMethod::Signed),
        }
    }
}

/// One line of the table.
#[derive(Clone, Debug, Serialize)]
pub struct Table4Row {
    /// Method of the row.
    pub image: TableImage,
    /// Texels per side of a face.
    pub texels: u32,
    /// Item-buffer pixels per side.
    pub item_buffer: u32,
    /// Seconds of visibility and shooting.
    pub seconds: f64,
    /// Number of shots.
    pub shots: usize,
    /// Shots of the room.
    pub map_shots: usize,
    /// Shots of the objects.
    pub object_shots: usize,
    /// Relative RMS error of B − E against the full solution on the same item buffers.
    pub error: f64,
    /// Relative RMS error against the full solution by rays.
    pub error_rays: f64,
    /// Imbalance of power over the emitted power.
    pub imbalance: f64,
    /// Number of negative texels.
    pub negative_texels: usize,
    /// The paper's seconds (2006) and shots.
    pub paper: Option<(f64, u32)>,
}

/// Returns seconds and shots of this row in the paper's Table 4.
pub fn printed_figures(image: TableImage, texels: u32, item_buffer: u32) -> Option<(f64, u32)> {
    match (image, texels, item_buffer) {
        (TableImage::Reference, 16, 1024) => Some((34.0, 322)),
        (TableImage::Reference, 32, 1024) => Some((41.0, 334)),
        (TableImage::Paper, 16, 256) => Some((11.0, 182)),
        (TableImage::Paper, 16, 512) => Some((13.0, 182)),
        (TableImage::Paper, 32, 512) => Some((18.0, 185)),
        (TableImage::Paper, 32, 1024) => Some((24.0, 185)),
        _ => None,
    }
}

/// Picture of a row.
pub struct RowPicture {
    /// Index of the row in the table.
    pub row: usize,
    /// The picture.
    pub picture: RgbaPicture,
}

/// A repeated figure of the paper.
pub struct PaperFigure {
    /// Number and title.
    pub title: String,
    /// Captions and pictures.
    pub pictures: Vec<(String, RgbaPicture)>,
}

/// All measurements and pictures.
#[derive(Default)]
pub struct Table4 {
    /// Rows of the table.
    pub rows: Vec<Table4Row>,
    /// Pictures of the rows.
    pub shown: Vec<RowPicture>,
    /// Figures 8 and 10.
    pub figures: Vec<PaperFigure>,
    /// Name of the adapter.
    pub adapter: String,
    /// Number of faces, and of the objects' faces.
    pub faces: [usize; 2],
}
