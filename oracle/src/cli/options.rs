//! Options that the commands share.

use clap::{Args, ValueEnum};
use common::form_factor::FormFactor;
use common::import::ImportOptions;
use common::settings::{Lookup, Settings, Visibility};
use common::{Error, Result};

/// `--visibility`.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum VisibilityOption {
    /// Rays (CPU)
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
    /// Texels per side of a face
    #[arg(long, value_name = "N", default_value_t = 16, value_parser = clap::value_parser!(u32).range(1..=8192))]
    pub texels: u32,
    /// Stop when unshot power ≤ X × emitted power
    #[arg(long, value_name = "X", default_value_t = 0.001, value_parser = epsilon, allow_negative_numbers = true)]
    pub epsilon: f64,
    /// Stop after N shots [default: 1000000]
    #[arg(long, value_name = "N")]
    pub max_shots: Option<u32>,
    /// How it is decided whether a texel sees a shooter [default: rays on the CPU, stereographic on the GPU]
    #[arg(long, value_enum)]
    pub visibility: Option<VisibilityOption>,
    /// Item buffer pixels a side [default: 1024]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(16..=8192))]
    pub item_buffer: Option<u32>,
    /// Item buffer pixels that a texel asks [default: 3x3]
    #[arg(long, value_enum)]
    pub lookup: Option<LookupOption>,
    /// Form factor [default: polygon, and disc for compare]
    #[arg(long, value_enum)]
    pub form_factor: Option<FormFactorOption>,
    /// Each face shoots as K×K cells [default: 4, and 1 for compare]
    #[arg(long, value_name = "K", value_parser = clap::value_parser!(u32).range(1..=256))]
    pub cells: Option<u32>,
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
    /// The settings, with a command's own defaults.
    pub fn settings(
        &self,
        visibility: Visibility,
        form_factor: FormFactor,
        cells: u32,
    ) -> Settings {
        let default = Settings::default();
        Settings {
            texels: self.texels,
            epsilon: self.epsilon,
            max_shots: self.max_shots.unwrap_or(default.max_shots),
            visibility: self.visibility.map_or(visibility, Into::into),
            item_buffer: self.item_buffer.unwrap_or(default.item_buffer),
            lookup: match self.lookup {
                Some(LookupOption::Exact) => Lookup::Exact,
                Some(LookupOption::Neighbours) => Lookup::Neighbours,
                None => default.lookup,
            },
            form_factor: self.form_factor.map_or(form_factor, Into::into),
            cells: self.cells.unwrap_or(cells),
        }
    }

    /// The import options.
    pub fn import(&self) -> ImportOptions {
        ImportOptions {
            join_quads: self.join_quads,
            two_sided: self.two_sided,
        }
    }

    /// Options of shooting that the matrix has no use for, by name.
    pub fn not_for_matrix(&self) -> Result<()> {
        let polygon = |f: &FormFactorOption| *f != FormFactorOption::Polygon;
        let given = [
            ("--cells", self.cells.is_some(), "every texel shoots"),
            (
                "--max-shots",
                self.max_shots.is_some(),
                "nothing is shot one by one",
            ),
            (
                "--item-buffer",
                self.item_buffer.is_some(),
                "visibility is by rays",
            ),
            ("--lookup", self.lookup.is_some(), "visibility is by rays"),
            (
                "--visibility",
                self.visibility.is_some_and(|v| v != VisibilityOption::Rays),
                "only rays",
            ),
            (
                "--form-factor",
                self.form_factor.is_some_and(|f| polygon(&f)),
                "only polygon",
            ),
            ("--adapter", self.adapter.is_some(), "it runs on the CPU"),
            ("--require-gpu", self.require_gpu, "it runs on the CPU"),
        ];
        match given.into_iter().find(|(_, given, _)| *given) {
            Some((option, _, reason)) => Err(Error::Usage(format!(
                "{option} does not go with --solver matrix ({reason}): leave it out"
            ))),
            None => Ok(()),
        }
    }

    /// Rays run on the CPU.
    pub fn no_rays_on_gpu(&self) -> Result<()> {
        if self.visibility == Some(VisibilityOption::Rays) {
            return Err(Error::Usage(
                "--visibility rays needs --solver cpu: the GPU has hemisphere, stereographic and paper".into(),
            ));
        }
        Ok(())
    }
}
