//! Options that the commands share.

use clap::{Args, ValueEnum};
use common::form_factor::FormFactor;
use common::import::ImportOptions;
use common::settings::{Lookup, Quality, Settings, Visibility};

/// `--quality`.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum QualityOption {
    /// A first look
    Draft,
    /// A few per cent
    Normal,
    /// Refined until the answer settles, about 1 %
    Reference,
}

impl From<QualityOption> for Quality {
    fn from(option: QualityOption) -> Self {
        match option {
            QualityOption::Draft => Self::Draft,
            QualityOption::Normal => Self::Normal,
            QualityOption::Reference => Self::Reference,
        }
    }
}

/// `--visibility`.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum VisibilityOption {
    /// Rays
    Rays,
    /// Item buffer by Table 3 as printed
    Paper,
    /// Item buffer, orthographic, corrected
    Hemisphere,
    /// Item buffer, stereographic
    Stereographic,
}

impl From<VisibilityOption> for Visibility {
    fn from(option: VisibilityOption) -> Self {
        match option {
            VisibilityOption::Rays => Self::Rays,
            VisibilityOption::Paper => Self::Paper,
            VisibilityOption::Hemisphere => Self::Hemisphere,
            VisibilityOption::Stereographic => Self::Stereographic,
        }
    }
}

/// `--form-factor`.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum FormFactorOption {
    /// Eq. 2 of the paper with the area ratio
    Paper,
    /// Wallace's disc of the shooter's area
    Disc,
    /// Lambert's exact polygon
    Polygon,
}

impl From<FormFactorOption> for FormFactor {
    fn from(option: FormFactorOption) -> Self {
        match option {
            FormFactorOption::Paper => Self::Paper,
            FormFactorOption::Disc => Self::Disc,
            FormFactorOption::Polygon => Self::Polygon,
        }
    }
}

/// `--lookup`.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum LookupOption {
    /// The pixel that holds the texel's projection
    Exact,
    /// That pixel or its eight neighbours, unless a face seen there hides the texel
    #[value(name = "3x3")]
    Neighbours,
}

/// How to read the scene, solve it and talk about it.
#[derive(Args, Clone)]
pub struct Common {
    /// Sets texels, cells, samples and epsilon together; the single options override it
    #[arg(long, value_enum, default_value = "normal")]
    pub quality: QualityOption,
    /// Texels per side of a face [default: 16; draft 8]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=8192))]
    pub texels: Option<u32>,
    /// Stop when unshot power ≤ X × emitted power [default: 0.001; draft 0.01, reference 0.0001]
    #[arg(long, value_name = "X", value_parser = epsilon, allow_negative_numbers = true)]
    pub epsilon: Option<f64>,
    /// Stop after N shots
    #[arg(long, value_name = "N", default_value_t = 1_000_000)]
    pub max_shots: u32,
    /// How it is decided whether a texel sees a shooter [default: rays on the CPU, stereographic on the GPU]
    #[arg(long, value_enum)]
    pub visibility: Option<VisibilityOption>,
    /// Item buffer pixels a side
    #[arg(long, value_name = "N", default_value_t = 1024, value_parser = clap::value_parser!(u32).range(16..=8192))]
    pub item_buffer: u32,
    /// Item buffer pixels that a texel asks
    #[arg(long, value_enum, default_value = "3x3")]
    pub lookup: LookupOption,
    /// Form factor [default: polygon, and disc for compare]
    #[arg(long, value_enum)]
    pub form_factor: Option<FormFactorOption>,
    /// Each face shoots as K×K cells [default: 4; draft 2, reference: raised until the answer settles; compare 1]
    #[arg(long, value_name = "K", value_parser = clap::value_parser!(u32).range(1..=256))]
    pub cells: Option<u32>,
    /// Pairs of points by which a texel sees a cell; 1: centre to centre [default: 4; draft 1, reference 16; compare 1]
    #[arg(long, value_name = "S", value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub samples: Option<u32>,
    /// Scale each shot's form factors to the exact closure
    #[arg(long)]
    pub conserve: bool,
    /// The GPU adapter whose name contains NAME
    #[arg(long, value_name = "NAME")]
    pub adapter: Option<String>,
    /// Fail with exit code 3 when there is no GPU
    #[arg(long)]
    pub require_gpu: bool,
    /// Make a front of each back
    #[arg(long)]
    pub two_sided: bool,
    /// Join two triangles of a glTF mesh that form a planar convex quad
    #[arg(long)]
    pub join_quads: bool,
    /// No progress, no summary
    #[arg(long)]
    pub quiet: bool,
}

fn epsilon(text: &str) -> std::result::Result<f64, String> {
    let value: f64 = text
        .parse()
        .map_err(|_| format!("{text} is not a number"))?;
    if value > 0.0 && value <= 1.0 {
        Ok(value)
    } else {
        Err(format!("{text} is not in 0 < X ≤ 1"))
    }
}

impl Common {
    /// The settings of `solve`.
    pub fn settings(&self, visibility: Visibility, form_factor: FormFactor) -> Settings {
        let quality = self.quality.into();
        let (texels, cells, samples, epsilon) = Quality::settings(quality);
        Settings {
            quality,
            texels: self.texels.unwrap_or(texels),
            epsilon: self.epsilon.unwrap_or(epsilon),
            max_shots: self.max_shots,
            visibility: self.visibility.map_or(visibility, Into::into),
            item_buffer: self.item_buffer,
            lookup: match self.lookup {
                LookupOption::Exact => Lookup::Exact,
                LookupOption::Neighbours => Lookup::Neighbours,
            },
            form_factor: self.form_factor.map_or(form_factor, Into::into),
            cells: self.cells.unwrap_or(cells),
            samples: self.samples.unwrap_or(samples),
            conserve: self.conserve,
        }
    }

    /// The import options.
    pub fn import(&self) -> ImportOptions {
        ImportOptions {
            join_quads: self.join_quads,
            two_sided: self.two_sided,
        }
    }
}
