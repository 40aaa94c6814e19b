//! Draws the pictures and charts of one scene's comparison.

use super::charts;
use crate::report::picture::{
    Exposure, decode_srgb, diverging_colour, draw_item_buffer, draw_radiosity_atlas, face_colour, false_colour_range,
    luminance, weighted_rms,
};
use crate::report::preview::choose_exposure;
use crate::report::view::camera::Camera;
use crate::report::view::interpolation::{InterpolatedField, InterpolationSurface};
use crate::report::view::quality::InterpolationQuality;
use crate::report::view::render::{ViewHit, ViewHits};
use common::rays::Rays;
use common::settings::Iteration;
use common::shooting::{RadiosityField, SolveRun};
use glam::{Vec3, Vec4};
use oracle::compare::comparison::{Comparison, ItemBufferPicture};

/// Pixels per side of a rendered view.
const VIEW_SIDE: u32 = 560;
/// Every `STRIDE`th view sample enters the choice of the false-colour range.
const RANGE_SAMPLE_STRIDE: usize = 5;

/// Pictures as sources of `img` elements, charts as SVG elements, and the values that their captions state.
pub struct ComparisonFigures {
    /// Views of the free runs: CPU, GPU.
    pub views: [String; 2],
    /// Views of the difference: free runs, lockstep.
    pub differences: [String; 2],
    /// Half-width of the false-colour range.
    pub range: f64,
    /// RMS of the CPU's reflected luminance, W/m².
    pub rms: f64,
    /// Exposure of views and atlases.
    pub exposure: Exposure,
    /// Texel atlases: CPU, GPU.
    pub atlases: [String; 2],
    /// Item buffer of one shot; none without shots.
    pub item_buffer: Option<ItemBufferFigure>,
    /// Picture of the error estimate per texel, and its false-colour range.
    pub texel_errors: Option<(String, f64)>,
    /// Chart of unshot power against shots.
    pub convergence: Option<String>,
    /// Chart of mismatches by distance.
    pub histogram: Option<String>,
    /// Interpolation error of the CPU's view.
    pub quality: InterpolationQuality,
    /// Camera of all views.
    pub camera: Camera,
}

/// Item buffer of one shot.
pub struct ItemBufferFigure {
    /// Item buffer, and the scene in the same colours.
    pub pictures: [String; 2],
    /// Number and name of the shooting face.
    pub shooter: String,
    /// Shooting patch.
    pub patch: u32,
    /// Pixels per side.
    pub size: u32,
}

impl ComparisonFigures {
    /// Draws all pictures and charts.
    pub fn new(c: &Comparison) -> Self {
        let rays = Rays::new(&c.mesh);
        let camera = Camera::automatic_view(&c.mesh, &rays);
        let surface = InterpolationSurface::new(&c.scene, &c.mesh);
        let view = ViewHits::new(&camera, &surface, &rays, VIEW_SIDE);
        let cpu = surface.interpolate(&c.cpu.field.irradiance);
        let exposure = choose_exposure(&view, &cpu);
        let (differences, range, rms) = draw_differences(c, &view, &surface);
        Self {
            views: [&cpu, &surface.interpolate(&c.gpu.field.irradiance)].map(|field| {
                view.shade_hits(|hit| exposure.display_light(field.radiosity_at(&hit.stencil)))
                    .data_uri()
            }),
            differences,
            range,
            rms,
            exposure,
            atlases: [&c.cpu, &c.gpu]
                .map(|run| draw_radiosity_atlas(&c.mesh, &run.field.radiosity, exposure).data_uri()),
            item_buffer: c
                .item_buffer
                .as_ref()
                .map(|shot| draw_item_buffer_figure(c, shot, &view)),
            texel_errors: c.error_map.as_ref().map(|off| draw_texel_errors(&view, off, rms)),
            convergence: shoots_singly(c)
                .then(|| charts::convergence_chart(&c.cpu, &c.gpu, c.settings.schedule.epsilon))
                .flatten(),
            histogram: charts::mismatch_chart(&c.pairs.histogram),
            quality: InterpolationQuality::new(&cpu),
            camera,
        }
    }
}

/// Draws the error estimate per texel relative to `rms`; returns the picture and its range.
fn draw_texel_errors(view: &ViewHits, off: &[f32], rms: f64) -> (String, f64) {
    let at = |hit: &ViewHit| match off.get(hit.stencil.texel as usize) {
        Some(off) if rms > 0.0 => f64::from(*off) / rms,
        _ => 0.0,
    };
    let range = false_colour_range(view.iter_hits().step_by(RANGE_SAMPLE_STRIDE).map(at));
    let picture = view.shade_hits(|hit| decode_srgb(diverging_colour(at(hit) / range)));
    (picture.data_uri(), range)
}

/// Draws the item buffer of a shot and the scene in its colours.
fn draw_item_buffer_figure(c: &Comparison, shot: &ItemBufferPicture, view: &ViewHits) -> ItemBufferFigure {
    let patch = c.mesh.patches.get(shot.patch as usize);
    let shooter = patch.map_or(0, |patch| patch.face);
    let face = c.scene.faces.get(shooter as usize);
    let name = face.map_or("", |face| &face.name);
    ItemBufferFigure {
        pictures: [
            draw_item_buffer(&shot.ids, shot.size).data_uri(),
            view.shade_hits(|hit| item_buffer_colour(hit, shooter)).data_uri(),
        ],
        shooter: format!("face {shooter} “{name}”"),
        patch: shot.patch,
        size: shot.size,
    }
}

/// Returns whether patches shot one at a time (Southwell iteration): only then is there a shot log to draw.
pub fn shoots_singly(c: &Comparison) -> bool {
    c.error_target.is_none() && c.settings.schedule.iteration == Iteration::Southwell
}

/// Returns a hit's item buffer colour; the shooter is white.
fn item_buffer_colour(hit: &ViewHit, shooter: u32) -> Vec3 {
    if hit.face == shooter {
        Vec3::ONE
    } else {
        decode_srgb(face_colour(hit.face))
    }
}

/// Draws the signed differences of reflected luminance; returns the pictures, their range and the RMS they are
/// relative to.
fn draw_differences(c: &Comparison, view: &ViewHits, surface: &InterpolationSurface) -> ([String; 2], f64, f64) {
    let rms = reflected_rms(c);
    // Lockstep is the CPU's log on the GPU, or the GPU's decisions on the CPU.
    let lockstep = match c.error_target {
        Some(_) => [&c.gpu, &c.lockstep],
        None => [&c.lockstep, &c.cpu],
    };
    let fields =
        [[&c.gpu, &c.cpu], lockstep].map(|[run, from]| surface.interpolate(&subtract_irradiance(run, &from.field)));
    let at = |field: &InterpolatedField, hit: &ViewHit| {
        let reflectance = c.mesh.texels[hit.stencil.texel as usize].reflectance;
        let difference = reflectance * field.stencil_value(&hit.stencil).as_vec3();
        let size = f64::from(luminance(difference));
        if size == 0.0 { 0.0 } else { size / rms }
    };
    let range = false_colour_range(
        fields
            .iter()
            .flat_map(|field| view.iter_hits().step_by(RANGE_SAMPLE_STRIDE).map(|hit| at(field, hit))),
    );
    let pictures = fields.each_ref().map(|field| {
        view.shade_hits(|hit| decode_srgb(diverging_colour(at(field, hit) / range)))
            .data_uri()
    });
    (pictures, range, rms)
}

/// Returns the difference of two irradiance fields.
fn subtract_irradiance(run: &SolveRun, from: &RadiosityField) -> Vec<Vec4> {
    run.field
        .irradiance
        .iter()
        .zip(&from.irradiance)
        .map(|(a, b)| a - b)
        .collect()
}

/// Returns the RMS of the luminance of the CPU's ρH, W/m².
fn reflected_rms(c: &Comparison) -> f64 {
    let texels = c.mesh.texels.iter().zip(&c.cpu.field.irradiance);
    weighted_rms(texels.map(|(texel, irradiance)| {
        let reflected = texel.reflectance * irradiance.truncate();
        (f64::from(luminance(reflected)), f64::from(texel.area))
    }))
}
