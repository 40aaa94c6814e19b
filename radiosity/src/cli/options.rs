//! Options shared by the commands that solve.

use crate::plan::coarser_defaults::{GivenOptions, coarsen_meshing};
use clap::{Args, ValueEnum};
use common::form_factor::FormFactor;
use common::import::ImportOptions;
use common::scene::Scene;
use common::settings::{
    ItemBufferProjection, ItemBufferSettings, Iteration, Lookup, Meshing, Raster, Schedule, Settings, SolveQuality,
    Transport, Visibility,
};
use common::{Error, Result};
use oracle::solve::solver::{DEFAULT_ERROR, DRAFT_ERROR, MAX_ERROR, MIN_ERROR, REFERENCE_ERROR};

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

impl From<QualityOption> for SolveQuality {
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
            VisibilityOption::Paper => ItemBufferProjection::Paper,
            VisibilityOption::Hemisphere => ItemBufferProjection::Hemisphere(Raster::Pixel),
            VisibilityOption::Stereographic => ItemBufferProjection::Stereographic(Raster::Pixel),
            VisibilityOption::Hemicube => ItemBufferProjection::Hemicube,
        };
        Self::with_item_buffer(projection, ItemBufferSettings::DEFAULT.size)
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
    /// Each pixel's ray is intersected with the faces that may cover it
    Pixel,
    /// Faces are cut into triangles, drawn by their projected corners
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
    /// The pixel onto which the texel projects
    Exact,
    /// Pixel or any of its eight neighbours, unless a face seen there hides the texel
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
    /// The patch with most unshot power shoots to every texel (the paper)
    Southwell,
    /// All patches, by Chebyshev's polynomials
    Chebyshev,
    /// All patches, along conjugate directions
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

/// Options of progressive refinement: each patch shoots its unshot power to all texels.
#[derive(Args, Clone, Default)]
pub struct ShootingOptions {
    /// Stop when unshot power ≤ X × emitted power [default: 0.001; draft 0.01, reference 0.0001]
    #[arg(long, value_name = "X", value_parser = parse_epsilon, allow_negative_numbers = true)]
    pub epsilon: Option<f64>,
    /// Stop after N shots [default: 1000000]
    #[arg(long, value_name = "N")]
    pub max_shots: Option<u32>,
    /// Iteration: the patches that shoot next [default: cg for shoot, southwell otherwise]
    #[arg(long, value_enum)]
    pub iteration: Option<IterationOption>,
    /// Visibility between a texel and a shooter [default: rays on the CPU, stereographic on the GPU]
    #[arg(long, value_enum)]
    pub visibility: Option<VisibilityOption>,
    /// Item buffer pixels per side [default: 1024]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(16..=8192))]
    pub item_buffer: Option<u32>,
    /// Rasterisation of faces into the item buffer [default: pixel, and tessellated for paper]
    #[arg(long, value_enum)]
    pub raster: Option<RasterOption>,
    /// Item buffer pixels looked up for a texel [default: 3x3]
    #[arg(long, value_enum)]
    pub lookup: Option<LookupOption>,
    /// Form factor [default: polygon]
    #[arg(long, value_enum)]
    pub form_factor: Option<FormFactorOption>,
    /// Each face shoots as K×K patches [default: 4; draft 2, reference 8; fewer where there are many faces]
    #[arg(long, alias = "cells", value_name = "K", value_parser = clap::value_parser!(u32).range(1..=256))]
    pub patches: Option<u32>,
    /// Visibility samples between a texel and a patch; 1: centre to centre [default: 4; draft 1, reference 16]
    #[arg(long, value_name = "S", value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub samples: Option<u32>,
    /// Scale each shot's form factors so that power is conserved
    #[arg(long)]
    pub conserve: bool,
}

/// Options of reading and solving a scene.
#[derive(Args, Clone)]
pub struct CommonOptions {
    /// An error of 5, 1 or 0.3 %; when shooting: sets patches, samples and epsilon [default: normal]
    #[arg(long, value_enum)]
    pub quality: Option<QualityOption>,
    /// Texels per side of a face [default: 16; draft 8; fewer where there are many faces]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=8192))]
    pub texels: Option<u32>,
    #[command(flatten)]
    pub shooting: ShootingOptions,
    /// The GPU adapter whose name contains NAME
    #[arg(long, value_name = "NAME")]
    pub adapter: Option<String>,
    /// Fail with exit code 3 when there is no GPU
    #[arg(long)]
    pub require_gpu: bool,
    /// Give each face a front on its back, too
    #[arg(long)]
    pub two_sided: bool,
    /// Join two triangles of a glTF mesh that form a planar convex quad
    #[arg(long)]
    pub join_quads: bool,
    /// No progress, no summary
    #[arg(long)]
    pub quiet: bool,
}

/// Parses "5 %", "5%" or "5" as 0.05.
pub fn parse_percentage(text: &str) -> std::result::Result<f64, String> {
    let number = text.trim().trim_end_matches('%').trim_end();
    let value: f64 = number.parse().map_err(|_| format!("{text} is not a percentage"))?;
    if value >= 0.0 && value.is_finite() {
        Ok(value / 100.0)
    } else {
        Err(format!("{text} is not a percentage of 0 or more"))
    }
}

/// Parses an error between the smallest and the largest that a solve accepts, as a share.
pub fn parse_error(text: &str) -> std::result::Result<f64, String> {
    let error = parse_percentage(text)?;
    if (MIN_ERROR..=MAX_ERROR).contains(&error) {
        Ok(error)
    } else {
        Err(format!("{text} is not within 0.2 % to 10 %"))
    }
}

fn parse_epsilon(text: &str) -> std::result::Result<f64, String> {
    let value: f64 = text.parse().map_err(|_| format!("{text} is not a number"))?;
    if value > 0.0 && value <= 1.0 {
        Ok(value)
    } else {
        Err(format!("{text} is not in 0 < X ≤ 1"))
    }
}

/// Returns true if an argument of this name belongs to [`ShootingOptions`].
pub fn is_shooting_option(id: &str) -> bool {
    ShootingOptions::augment_args(clap::Command::new(""))
        .get_arguments()
        .any(|arg| arg.get_id() == id)
}

impl ShootingOptions {
    /// Returns the first option that is given.
    pub fn first_given(&self) -> Option<&'static str> {
        let given = [
            ("--patches", self.patches.is_some()),
            ("--samples", self.samples.is_some()),
            ("--visibility", self.visibility.is_some()),
            ("--form-factor", self.form_factor.is_some()),
            ("--item-buffer", self.item_buffer.is_some()),
            ("--lookup", self.lookup.is_some()),
            ("--raster", self.raster.is_some()),
            ("--iteration", self.iteration.is_some()),
            ("--epsilon", self.epsilon.is_some()),
            ("--max-shots", self.max_shots.is_some()),
            ("--conserve", self.conserve),
        ];
        let first = given.into_iter().find(|(_, given)| *given);
        first.map(|(option, _)| option)
    }

    /// Returns these options without those that `solve --error` obeys: rays and exact polygons are its own way.
    fn without_rays_and_polygons(&self) -> Self {
        Self {
            visibility: self.visibility.filter(|v| *v != VisibilityOption::Rays),
            form_factor: self.form_factor.filter(|f| *f != FormFactorOption::Polygon),
            ..self.clone()
        }
    }

    /// Applies the options of item buffers to `visibility`; with rays
    /// [`CommonOptions::refuse_item_buffer_options`] has refused them.
    fn apply_item_buffer_options(&self, visibility: Visibility) -> Result<Visibility> {
        let Visibility::ItemBuffer(default) = visibility else {
            return Ok(visibility);
        };
        let raster = self.raster.map_or(default.projection.raster_method(), Into::into);
        let projection = default.projection.with_raster(raster).ok_or_else(|| {
            Error::Usage(
                "--raster: paper is always tessellated, and the hemicube always drawn by pixels; leave it out".into(),
            )
        })?;
        Ok(Visibility::ItemBuffer(ItemBufferSettings {
            projection,
            size: self.item_buffer.unwrap_or(default.size),
            lookup: self.lookup.map_or(default.lookup, Into::into),
        }))
    }
}

impl CommonOptions {
    /// Returns the quality in force.
    pub fn quality_or_default(&self) -> SolveQuality {
        self.quality.map_or(SolveQuality::Normal, Into::into)
    }

    /// Returns the settings of a command that may use any iteration; `visibility` and `form_factor` are defaults.
    pub fn pass_settings(&self, visibility: Visibility, form_factor: FormFactor) -> Result<Settings> {
        let mut settings = self.settings_of_one_shot(visibility, form_factor)?;
        settings.schedule.iteration = self.shooting.iteration.map_or(Iteration::Cg, Into::into);
        Ok(settings)
    }

    /// Returns the settings of a command that shoots one patch after the other; `visibility` and `form_factor` are
    /// defaults.
    ///
    /// Errors: another iteration than Southwell's is given.
    pub fn shot_settings(&self, visibility: Visibility, form_factor: FormFactor) -> Result<Settings> {
        match self.shooting.iteration {
            None | Some(IterationOption::Southwell) => self.settings_of_one_shot(visibility, form_factor),
            Some(_) => Err(Error::Usage(
                "this command shoots one patch after the other: leave --iteration out, or give southwell".into(),
            )),
        }
    }

    fn settings_of_one_shot(&self, visibility: Visibility, form_factor: FormFactor) -> Result<Settings> {
        let default = Settings::with_quality(self.quality_or_default());
        let given = &self.shooting;
        let visibility = given.visibility.map_or(visibility, Into::into);
        Ok(Settings {
            quality: default.quality,
            meshing: Meshing {
                texels: self.texels.unwrap_or(default.meshing.texels),
                patches: given.patches.unwrap_or(default.meshing.patches),
                samples: given.samples.unwrap_or(default.meshing.samples),
            },
            transport: Transport {
                visibility: given.apply_item_buffer_options(visibility)?,
                form_factor: given.form_factor.map_or(form_factor, Into::into),
                conserve: given.conserve,
            },
            schedule: Schedule {
                iteration: Iteration::Southwell,
                epsilon: given.epsilon.unwrap_or(default.schedule.epsilon),
                max_shots: given.max_shots.unwrap_or(default.schedule.max_shots),
            },
        })
    }

    /// Returns the import options.
    pub fn import_options(&self) -> ImportOptions {
        ImportOptions {
            join_quads: self.join_quads,
            two_sided: self.two_sided,
            ..ImportOptions::default()
        }
    }

    /// Refuses options of item buffers if visibility is by rays.
    pub fn refuse_item_buffer_options(&self, visibility: Visibility) -> Result<()> {
        let given = [
            ("--item-buffer", self.shooting.item_buffer.is_some()),
            ("--raster", self.shooting.raster.is_some()),
            ("--lookup", self.shooting.lookup.is_some()),
        ];
        match given.into_iter().find(|(_, given)| *given) {
            Some((option, _)) if visibility == Visibility::Rays => Err(Error::Usage(format!(
                "{option} applies to item buffers, but visibility is by rays here: leave it out, or give --visibility stereographic, hemisphere, hemicube or paper too"
            ))),
            _ => Ok(()),
        }
    }

    /// Refuses options of the GPU.
    pub fn refuse_gpu_options(&self) -> Result<()> {
        match self.first_gpu_option() {
            Some(option) => Err(Error::Usage(format!(
                "{option} contradicts --solver cpu: leave one of them out"
            ))),
            None => Ok(()),
        }
    }

    fn first_gpu_option(&self) -> Option<&'static str> {
        let adapter = self.adapter.as_ref().map(|_| "--adapter");
        self.require_gpu.then_some("--require-gpu").or(adapter)
    }

    /// Returns the error that the quality stands for; none if an option of shooting is given.
    pub fn quality_error(&self) -> Option<f64> {
        self.shooting
            .first_given()
            .is_none()
            .then(|| match self.quality_or_default() {
                SolveQuality::Draft => DRAFT_ERROR,
                SolveQuality::Normal => DEFAULT_ERROR,
                SolveQuality::Reference => REFERENCE_ERROR,
            })
    }

    /// Refuses options of shooting beside `--error`, which determines them.
    pub fn refuse_shooting_options(&self) -> Result<()> {
        let quality = self.quality.map(|_| "--quality");
        let shooting = self.shooting.without_rays_and_polygons();
        match quality.or_else(|| shooting.first_given()) {
            Some(option) => Err(Error::Usage(format!(
                "{option} does not go with --error, which chooses it: leave one of them out"
            ))),
            None => Ok(()),
        }
    }

    /// Refuses options that the dense solver does not use: texels alone determine its answer.
    pub fn refuse_dense_conflicts(&self) -> Result<()> {
        let quality = self.quality.map(|_| "--quality");
        let shooting = self.shooting.without_rays_and_polygons();
        let unused = quality
            .or_else(|| shooting.first_given())
            .or_else(|| self.first_gpu_option());
        match unused {
            Some(option) => Err(Error::Usage(format!(
                "{option} does not go with --solver dense, which solves all texels exactly on the CPU: leave it out"
            ))),
            None => Ok(()),
        }
    }
}

/// Returns the settings in force, whatever the scene.
pub fn general_settings(common: &CommonOptions, on_gpu: bool) -> Result<Settings> {
    common.pass_settings(visibility_in_force(common, on_gpu), FormFactor::Polygon)
}

/// Returns the visibility in force; the default is the most accurate one of the solver.
pub fn visibility_in_force(common: &CommonOptions, on_gpu: bool) -> Visibility {
    match common.shooting.visibility {
        Some(given) => given.into(),
        None if on_gpu => Visibility::ItemBuffer(ItemBufferSettings::DEFAULT),
        None => Visibility::Rays,
    }
}

/// Returns the settings in force for `scene`, and a note if its many faces make the defaults coarser.
pub fn scene_settings(common: &CommonOptions, scene: &Scene, on_gpu: bool) -> Result<(Settings, Option<String>)> {
    let chosen = GivenOptions {
        quality: common.quality.is_some(),
        texels: common.texels.is_some(),
        patches: common.shooting.patches.is_some(),
        samples: common.shooting.samples.is_some(),
    };
    let mut settings = general_settings(common, on_gpu)?;
    let (meshing, changed) = coarsen_meshing(scene, &settings.meshing, chosen);
    settings.meshing = meshing;
    Ok((settings, changed))
}
