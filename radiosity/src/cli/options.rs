//! Options shared by several commands, and the parsers of their values.

use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use common::form_factor::FormFactor;
use common::import::{ImportOptions, load_scene};
use common::scene::Scene;
use common::settings::{ItemBufferProjection, ItemBufferSettings, Iteration, Settings, SolveQuality, Visibility};
use common::{Error, Result};
use glam::Vec3;
use oracle::solve::solver::{DEFAULT_ERROR, DRAFT_ERROR, MAX_ERROR, MIN_ERROR, REFERENCE_ERROR};
use std::path::Path;

/// A value of an option: its name, its help, and what it stands for.
pub type Choice<T> = (&'static str, &'static str, T);

const QUALITIES: [Choice<SolveQuality>; 3] = [
    ("draft", "A first look: 5 %", SolveQuality::Draft),
    ("normal", "1 %", SolveQuality::Normal),
    ("reference", "0.3 %", SolveQuality::Reference),
];

const ITERATIONS: [Choice<Iteration>; 3] = [
    (
        "southwell",
        "The patch with most unshot power shoots to every texel (the paper)",
        Iteration::Southwell,
    ),
    (
        "chebyshev",
        "All patches, by Chebyshev's polynomials",
        Iteration::Chebyshev,
    ),
    ("cg", "All patches, along conjugate directions", Iteration::Cg),
];

const VISIBILITIES: [Choice<Visibility>; 5] = [
    ("rays", "Rays", Visibility::Rays),
    (
        "paper",
        "Item buffer by Table 3 as printed",
        item_buffer(ItemBufferProjection::Paper),
    ),
    (
        "hemisphere",
        "Item buffer, orthographic, corrected",
        item_buffer(ItemBufferProjection::Hemisphere),
    ),
    (
        "stereographic",
        "Item buffer, stereographic",
        item_buffer(ItemBufferProjection::Stereographic),
    ),
    (
        "hemicube",
        "Item buffer, the five sides of a half cube",
        item_buffer(ItemBufferProjection::Hemicube),
    ),
];

const FORM_FACTORS: [Choice<FormFactor>; 3] = [
    ("paper", "Eq. 2 of the paper with the area ratio", FormFactor::Paper),
    ("disc", "Wallace's disc of the shooter's area", FormFactor::Disc),
    ("polygon", "Lambert's exact polygon", FormFactor::Polygon),
];

const fn item_buffer(projection: ItemBufferProjection) -> Visibility {
    Visibility::with_item_buffer(projection, ItemBufferSettings::DEFAULT.size)
}

/// Makes a parser of the names of `choices`.
pub fn choice_parser<T: Copy + Send + Sync>(choices: &'static [Choice<T>]) -> impl TypedValueParser<Value = T> {
    let names = choices
        .iter()
        .map(|(name, help, _)| PossibleValue::new(*name).help(*help));
    PossibleValuesParser::new(names).try_map(move |name| {
        let chosen = choices.iter().find(|(known, ..)| known == &name);
        chosen.map(|(.., value)| *value).ok_or("unknown name")
    })
}

/// Options of reading and solving a scene.
#[derive(Args, Clone, Default)]
pub struct CommonOptions {
    /// An error of 5, 1 or 0.3 %; when shooting: sets patches, samples and epsilon [default: normal]
    #[arg(long, value_parser = choice_parser(&QUALITIES))]
    pub quality: Option<SolveQuality>,
    /// Texels per side of a face [default: 16; draft 8; fewer where there are many faces]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=8192))]
    pub texels: Option<u32>,
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
}

/// Options of progressive refinement: each patch shoots its unshot power to all texels.
#[derive(Args, Clone, Default, PartialEq)]
pub struct ShootingOptions {
    /// Stop when unshot power ≤ X × emitted power [default: 0.001; draft 0.01, reference 0.0001]
    #[arg(long, value_name = "X", value_parser = parse_epsilon)]
    pub epsilon: Option<f64>,
    /// Stop after N shots [default: 1000000]
    #[arg(long, value_name = "N")]
    pub max_shots: Option<u32>,
    /// Visibility between a texel and a shooter [default: rays on the CPU, stereographic on the GPU]
    #[arg(long, value_parser = choice_parser(&VISIBILITIES))]
    pub visibility: Option<Visibility>,
    /// Item buffer pixels per side [default: 1024]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(16..=8192))]
    pub item_buffer: Option<u32>,
    /// Form factor [default: polygon]
    #[arg(long, value_parser = choice_parser(&FORM_FACTORS))]
    pub form_factor: Option<FormFactor>,
    /// Each face shoots as K×K patches [default: 4; draft 2, reference 8; fewer where there are many faces]
    #[arg(long, value_name = "K", value_parser = clap::value_parser!(u32).range(1..=256))]
    pub patches: Option<u32>,
    /// Visibility samples between a texel and a patch; 1: centre to centre [default: 4; draft 1, reference 16]
    #[arg(long, value_name = "S", value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub samples: Option<u32>,
}

/// Options of progressive refinement that a relight does not have.
#[derive(Args, Clone, Default, PartialEq)]
pub struct PassOptions {
    /// Iteration: the patches that shoot next [default: cg]
    #[arg(long, value_parser = choice_parser(&ITERATIONS))]
    pub iteration: Option<Iteration>,
    /// Scale each shot's form factors so that power is conserved
    #[arg(long)]
    pub conserve: bool,
}

/// Parses "5 %", "5%" or "5" as 0.05.
pub fn parse_percentage(text: &str) -> std::result::Result<f64, String> {
    let number = text.trim().trim_end_matches('%').trim_end();
    match number.parse::<f64>() {
        Ok(value) if value >= 0.0 && value.is_finite() => Ok(value / 100.0),
        _ => Err(format!("{text} is not a percentage of 0 or more")),
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

/// Parses a number that `fits`; the message says that it `is_not`.
pub fn parse_number(text: &str, fits: impl Fn(f64) -> bool, is_not: &str) -> std::result::Result<f64, String> {
    let number = text.parse().ok().filter(|x| fits(*x));
    number.ok_or_else(|| format!("{text} is not {is_not}"))
}

fn parse_epsilon(text: &str) -> std::result::Result<f64, String> {
    parse_number(text, |x| x > 0.0 && x <= 1.0, "in 0 < X ≤ 1")
}

impl ShootingOptions {
    /// Refuses pixels of an item buffer where visibility is by rays.
    ///
    /// Errors: [`Error::Usage`].
    pub fn check_item_buffer(&self, on_gpu: bool) -> Result<()> {
        match (self.visibility_in_force(on_gpu), self.item_buffer) {
            (Visibility::Rays, Some(_)) => Err(Error::Usage(
                "--item-buffer applies to item buffers, but visibility is by rays here: leave it out, or give --visibility stereographic, hemisphere, hemicube or paper too".into(),
            )),
            _ => Ok(()),
        }
    }

    /// Returns the visibility in force; the default is the most accurate one of the solver.
    fn visibility_in_force(&self, on_gpu: bool) -> Visibility {
        let default = match on_gpu {
            true => Visibility::ItemBuffer(ItemBufferSettings::DEFAULT),
            false => Visibility::Rays,
        };
        match self.visibility.unwrap_or(default) {
            Visibility::Rays => Visibility::Rays,
            Visibility::ItemBuffer(drawing) => Visibility::ItemBuffer(ItemBufferSettings {
                size: self.item_buffer.unwrap_or(drawing.size),
                ..drawing
            }),
        }
    }
}

impl CommonOptions {
    /// Returns the settings in force, by default with exact polygons and conjugate gradients.
    pub fn shooting_settings(&self, shooting: &ShootingOptions, passes: &PassOptions, on_gpu: bool) -> Settings {
        let mut settings = Settings::with_quality(self.quality.unwrap_or_default());
        let set = |to: &mut u32, given: Option<u32>| *to = given.unwrap_or(*to);
        set(&mut settings.meshing.texels, self.texels);
        set(&mut settings.meshing.patches, shooting.patches);
        set(&mut settings.meshing.samples, shooting.samples);
        set(&mut settings.schedule.max_shots, shooting.max_shots);
        settings.schedule.epsilon = shooting.epsilon.unwrap_or(settings.schedule.epsilon);
        settings.schedule.iteration = passes.iteration.unwrap_or(Iteration::Cg);
        settings.transport.visibility = shooting.visibility_in_force(on_gpu);
        settings.transport.form_factor = shooting.form_factor.unwrap_or(FormFactor::Polygon);
        settings.transport.conserve = passes.conserve;
        settings
    }

    /// Returns the import options.
    pub fn import_options(&self) -> ImportOptions {
        ImportOptions {
            join_quads: self.join_quads,
            two_sided: self.two_sided,
            ..ImportOptions::default()
        }
    }

    /// Returns the error that the quality stands for.
    pub fn quality_error(&self) -> f64 {
        match self.quality.unwrap_or_default() {
            SolveQuality::Draft => DRAFT_ERROR,
            SolveQuality::Normal => DEFAULT_ERROR,
            SolveQuality::Reference => REFERENCE_ERROR,
        }
    }

    /// Returns the option of the GPU that is given.
    pub fn gpu_option(&self) -> Option<&'static str> {
        let adapter = self.adapter.as_ref().map(|_| "--adapter");
        self.require_gpu.then_some("--require-gpu").or(adapter)
    }
}

/// Reads a scene.
///
/// Errors: it cannot be read, or gives no light.
pub fn load_lit_scene(path: &Path, options: &ImportOptions) -> Result<Scene> {
    let scene = load_scene(path, options)?;
    require_light(path, &scene).map(|()| scene)
}

const NO_LIGHT: &str = "no face emits light: give a material Ke (OBJ) or emissiveFactor (glTF), or solve it with --lamp X,Y,Z,W or --sky L";

/// Requires that some face emits or light comes from outside, and that its light is not lost.
pub fn require_light(path: &Path, scene: &Scene) -> Result<()> {
    let refuse = |message: String| Err(Error::bad_input(path, "", message));
    match scene.faces.iter().any(|face| face.emission != Vec3::ZERO) {
        _ if scene.sky.is_some() => Ok(()),
        true => scene.explain_lost_lamps().map_or(Ok(()), refuse),
        false => refuse(NO_LIGHT.into()),
    }
}
