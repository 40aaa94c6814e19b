//! Options that the commands share.

use crate::solve::solver::{DRAFT, REFERENCE, USUAL};
use clap::{Args, ValueEnum};
use common::form_factor::FormFactor;
use common::import::ImportOptions;
use common::settings::{
    Drawing, Iteration, Lookup, Meshing, Projection, Quality, Raster, Schedule, Settings,
    Transport, Visibility,
};
use common::{Error, Result};

/// `--quality`.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum QualityOption {
    /// A first look: 5 %
    Draft,
    /// 1 %
    Normal,
    /// 0.3 %
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
    /// Item buffer, the five sides of a half cube
    Hemicube,
}

impl From<VisibilityOption> for Visibility {
    fn from(option: VisibilityOption) -> Self {
        let projection = match option {
            VisibilityOption::Rays => return Self::Rays,
            VisibilityOption::Paper => Projection::Paper,
            VisibilityOption::Hemisphere => Projection::Hemisphere(Raster::Pixel),
            VisibilityOption::Stereographic => Projection::Stereographic(Raster::Pixel),
            VisibilityOption::Hemicube => Projection::Hemicube,
        };
        Self::drawn(projection, Drawing::DEFAULT.size)
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
    /// Faces are cut into triangles, which are drawn by their projected corners
    Tessellated,
}

impl From<RasterOption> for Raster {
    fn from(option: RasterOption) -> Self {
        match option {
            RasterOption::Pixel => Self::Pixel,
            RasterOption::Tessellated => Self::Tessellated,
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

impl From<LookupOption> for Lookup {
    fn from(option: LookupOption) -> Self {
        match option {
            LookupOption::Exact => Self::Exact,
            LookupOption::Neighbours => Self::Neighbours,
        }
    }
}

/// `--iteration`.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum IterationOption {
    /// The cell with most unshot power, to every texel (the paper)
    Southwell,
    /// All cells, by Chebyshev's polynomials
    Chebyshev,
    /// All cells, along conjugate directions
    Cg,
}

impl From<IterationOption> for Iteration {
    fn from(option: IterationOption) -> Self {
        match option {
            IterationOption::Southwell => Self::Southwell,
            IterationOption::Chebyshev => Self::Chebyshev,
            IterationOption::Cg => Self::Cg,
        }
    }
}

/// How to read the scene, solve it and talk about it.
#[derive(Args, Clone)]
pub struct Common {
    /// An error of 5, 1 or 0.3 %; beside an option of shooting, cells, samples and epsilon together [default: normal]
    #[arg(long, value_enum)]
    pub quality: Option<QualityOption>,
    /// Texels per side of a face [default: 16; draft 8; fewer where there are many faces]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=8192))]
    pub texels: Option<u32>,
    /// Stop when unshot power ≤ X × emitted power [default: 0.001; draft 0.01, reference 0.0001]
    #[arg(long, value_name = "X", value_parser = epsilon, allow_negative_numbers = true)]
    pub epsilon: Option<f64>,
    /// Stop after N shots [default: 1000000]
    #[arg(long, value_name = "N")]
    pub max_shots: Option<u32>,
    /// Which cells shoot next, and how much [default: cg for solve, southwell otherwise]
    #[arg(long, value_enum)]
    pub iteration: Option<IterationOption>,
    /// How to decide whether a texel sees a shooter [default: rays on the CPU, stereographic on the GPU]
    #[arg(long, value_enum)]
    pub visibility: Option<VisibilityOption>,
    /// Item buffer pixels per side [default: 1024]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(16..=8192))]
    pub item_buffer: Option<u32>,
    /// How faces get into the item buffer [default: pixel, and tessellated for paper]
    #[arg(long, value_enum)]
    pub raster: Option<RasterOption>,
    /// Item buffer pixels that are looked up for a texel [default: 3x3]
    #[arg(long, value_enum)]
    pub lookup: Option<LookupOption>,
    /// Form factor [default: polygon]
    #[arg(long, value_enum)]
    pub form_factor: Option<FormFactorOption>,
    /// Each face shoots as K×K cells [default: 4; draft 2, reference 8; fewer where there are many faces]
    #[arg(long, value_name = "K", value_parser = clap::value_parser!(u32).range(1..=256))]
    pub cells: Option<u32>,
    /// Pairs of points by which a texel sees a cell; 1: centre to centre [default: 4; draft 1, reference 16]
    #[arg(long, value_name = "S", value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub samples: Option<u32>,
    /// Scale each shot's form factors so that no light is lost or made up
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

/// "5 %", "5%" or "5" as 0.05.
pub fn percentage(text: &str) -> std::result::Result<f64, String> {
    let number = text.trim().trim_end_matches('%').trim_end();
    let value: f64 = number
        .parse()
        .map_err(|_| format!("{text} is not a percentage"))?;
    if value >= 0.0 && value.is_finite() {
        Ok(value / 100.0)
    } else {
        Err(format!("{text} is not a percentage of 0 or more"))
    }
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
    /// The quality in force.
    pub fn quality(&self) -> Quality {
        self.quality.map_or(Quality::Normal, Into::into)
    }

    /// The settings of `solve`, and of what is done by one.
    pub fn of_passes(&self, visibility: Visibility, form_factor: FormFactor) -> Result<Settings> {
        let shots = Self {
            iteration: None,
            ..self.clone()
        };
        let mut settings = shots.settings(visibility, form_factor)?;
        settings.schedule.iteration = self.iteration.map_or(Iteration::Cg, Into::into);
        Ok(settings)
    }

    /// The settings of a command that shoots one cell after the other; `visibility` where none is
    /// asked for.
    pub fn settings(&self, visibility: Visibility, form_factor: FormFactor) -> Result<Settings> {
        if !matches!(self.iteration, None | Some(IterationOption::Southwell)) {
            return Err(Error::Usage(
                "this command shoots one cell after the other: leave --iteration out, or give southwell".into(),
            ));
        }
        let default = Settings::of(self.quality());
        Ok(Settings {
            quality: default.quality,
            meshing: Meshing {
                texels: self.texels.unwrap_or(default.meshing.texels),
                cells: self.cells.unwrap_or(default.meshing.cells),
                samples: self.samples.unwrap_or(default.meshing.samples),
            },
            transport: Transport {
                visibility: self.drawn(self.visibility.map_or(visibility, Into::into))?,
                form_factor: self.form_factor.map_or(form_factor, Into::into),
                conserve: self.conserve,
            },
            schedule: Schedule {
                iteration: Iteration::Southwell,
                epsilon: self.epsilon.unwrap_or(default.schedule.epsilon),
                max_shots: self.max_shots.unwrap_or(default.schedule.max_shots),
            },
        })
    }

    /// The visibility with the options of item buffers; [`Common::not_for_rays`] has refused them where
    /// nothing is drawn.
    fn drawn(&self, visibility: Visibility) -> Result<Visibility> {
        let Visibility::Drawn(default) = visibility else {
            return Ok(visibility);
        };
        let raster = self.raster.map_or(default.projection.raster(), Into::into);
        let projection = default.projection.by(raster).ok_or_else(|| {
            Error::Usage(
                "--raster: paper is always tessellated, and the hemicube always drawn by pixels; leave it out"
                    .into(),
            )
        })?;
        Ok(Visibility::Drawn(Drawing {
            projection,
            size: self.item_buffer.unwrap_or(default.size),
            lookup: self.lookup.map_or(default.lookup, Into::into),
        }))
    }

    /// The import options.
    pub fn import(&self) -> ImportOptions {
        ImportOptions {
            join_quads: self.join_quads,
            two_sided: self.two_sided,
            ..ImportOptions::default()
        }
    }

    /// Options of item buffers, where the visibility in force has none.
    pub fn not_for_rays(&self, visibility: Visibility) -> Result<()> {
        let given = [
            ("--item-buffer", self.item_buffer.is_some()),
            ("--raster", self.raster.is_some()),
            ("--lookup", self.lookup.is_some()),
        ];
        match given.into_iter().find(|(_, given)| *given) {
            Some((option, _)) if visibility == Visibility::Rays => Err(Error::Usage(format!(
                "{option} applies to item buffers, but visibility is by rays here: leave it out, or give --visibility stereographic, hemisphere, hemicube or paper too"
            ))),
            _ => Ok(()),
        }
    }

    /// Options of the GPU.
    pub fn not_for_cpu(&self) -> Result<()> {
        let given = [
            ("--require-gpu", self.require_gpu),
            ("--adapter", self.adapter.is_some()),
        ];
        match given.into_iter().find(|(_, given)| *given) {
            Some((option, _)) => Err(Error::Usage(format!(
                "{option} contradicts --solver cpu: leave one of them out"
            ))),
            None => Ok(()),
        }
    }

    /// The first option of shooting that is given.
    fn shooting(&self) -> Option<&'static str> {
        let given = [
            ("--epsilon", self.epsilon.is_some()),
            ("--max-shots", self.max_shots.is_some()),
            ("--iteration", self.iteration.is_some()),
            ("--cells", self.cells.is_some()),
            ("--samples", self.samples.is_some()),
            ("--conserve", self.conserve),
            ("--item-buffer", self.item_buffer.is_some()),
            ("--lookup", self.lookup.is_some()),
            ("--raster", self.raster.is_some()),
            ("--visibility", self.visibility.is_some()),
            ("--form-factor", self.form_factor.is_some()),
        ];
        let found = given.into_iter().find(|(_, given)| *given);
        found.map(|(option, _)| option)
    }

    /// The error that the quality stands for; none where an option of shooting asks for that.
    pub fn error(&self) -> Option<f64> {
        self.shooting().is_none().then(|| match self.quality() {
            Quality::Draft => DRAFT,
            Quality::Normal => USUAL,
            Quality::Reference => REFERENCE,
        })
    }

    /// Options of shooting, where an error is asked for: it decides what they would.
    pub fn not_for_error(&self) -> Result<()> {
        let quality = self.quality.map(|_| "--quality");
        // What it does anyway may be said.
        let rest = Self {
            visibility: self.visibility.filter(|v| *v != VisibilityOption::Rays),
            form_factor: self.form_factor.filter(|f| *f != FormFactorOption::Polygon),
            ..self.clone()
        };
        match quality.or_else(|| rest.shooting()) {
            Some(option) => Err(Error::Usage(format!(
                "{option} does not go with --error, which chooses what is needed: leave one of them out"
            ))),
            None => Ok(()),
        }
    }

    /// Options of shooting that the matrix has no use for, by name.
    pub fn not_for_matrix(&self) -> Result<()> {
        let polygon = |f: &FormFactorOption| *f != FormFactorOption::Polygon;
        let given = [
            ("--cells", self.cells.is_some(), "every texel shoots"),
            (
                "--quality",
                self.quality.is_some(),
                "--texels alone decides",
            ),
            (
                "--samples",
                self.samples.is_some(),
                "it samples until it settles",
            ),
            ("--conserve", self.conserve, "its form factors are exact"),
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
            ("--raster", self.raster.is_some(), "visibility is by rays"),
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
}
