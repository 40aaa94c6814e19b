//! Options that the commands share.

use clap::{Args, ValueEnum};
use common::form_factor::FormFactor;
use common::import::ImportOptions;
use common::settings::{Lookup, Raster, Settings, Visibility};
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
    /// Item buffer, the five sides of a half cube
    Hemicube,
}

impl From<VisibilityOption> for Visibility {
    fn from(option: VisibilityOption) -> Self {
        match option {
            VisibilityOption::Rays => Self::Rays,
            VisibilityOption::Paper => Self::Paper,
            VisibilityOption::Hemisphere => Self::Hemisphere,
            VisibilityOption::Stereographic => Self::Stereographic,
            VisibilityOption::Hemicube => Self::Hemicube,
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

/// `--raster`.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum RasterOption {
    /// Each pixel's own ray is intersected with the faces whose image may lie there
    Pixel,
    /// Faces are cut into triangles, whose projected corners are drawn
    Tessellated,
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
    /// Stop after N shots
    #[arg(long, value_name = "N", default_value_t = 1_000_000)]
    pub max_shots: u32,
    /// How it is decided whether a texel sees a shooter [default: rays on the CPU, stereographic on the GPU]
    #[arg(long, value_enum)]
    pub visibility: Option<VisibilityOption>,
    /// Item buffer pixels a side
    #[arg(long, value_name = "N", default_value_t = 1024, value_parser = clap::value_parser!(u32).range(16..=8192))]
    pub item_buffer: u32,
    /// How faces get into the item buffer [default: pixel, and tessellated for paper]
    #[arg(long, value_enum)]
    pub raster: Option<RasterOption>,
    /// Item buffer pixels that a texel asks
    #[arg(long, value_enum, default_value = "3x3")]
    pub lookup: LookupOption,
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
    ) -> Result<Settings> {
        let mut settings = Settings {
            texels: self.texels,
            epsilon: self.epsilon,
            max_shots: self.max_shots,
            visibility: self.visibility.map_or(visibility, Into::into),
            item_buffer: self.item_buffer,
            raster: match self.raster {
                Some(RasterOption::Tessellated) => Raster::Tessellated,
                Some(RasterOption::Pixel) | None => Raster::Pixel,
            },
            lookup: match self.lookup {
                LookupOption::Exact => Lookup::Exact,
                LookupOption::Neighbours => Lookup::Neighbours,
            },
            form_factor: self.form_factor.map_or(form_factor, Into::into),
            cells: self.cells.unwrap_or(cells),
        };
        let asked = settings.raster;
        settings.raster = settings.raster();
        if self.raster.is_some() && settings.raster != asked {
            return Err(Error::Usage(
                "--raster: paper is tessellated and the hemicube goes by pixels; leave it out"
                    .into(),
            ));
        }
        Ok(settings)
    }

    /// The import options.
    pub fn import(&self) -> ImportOptions {
        ImportOptions {
            join_quads: self.join_quads,
            two_sided: self.two_sided,
        }
    }

    /// Rays run on the CPU.
    pub fn no_rays_on_gpu(&self) -> Result<()> {
        if self.visibility == Some(VisibilityOption::Rays) {
            return Err(Error::Usage(
                "--visibility rays needs --solver cpu: the GPU has hemisphere, stereographic, hemicube and paper".into(),
            ));
        }
        Ok(())
    }
}
