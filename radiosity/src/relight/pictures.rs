//! Draws the figures of a relight report.

use super::RelitScene;
use super::composite::Composite;
use super::files::tone_map_picture;
use crate::report::document::{Figure, Text, bold_text, colour_bar};
use crate::report::format::{format_count, format_number, format_percent};
use crate::report::picture::{
    Exposure, RgbaPicture, decode_srgb, diverging_colour, draw_atlas, encode_srgb, false_colour_range, luminance,
    weighted_rms,
};
use glam::Vec3;
use rayon::prelude::*;
use std::f32::consts::PI;

/// Every `STRIDE`th pixel enters the choice of the false-colour range.
const RANGE_SAMPLE_STRIDE: usize = 7;
/// Linear colour of pixels in which an object hides the room.
const HIDDEN_COLOUR: Vec3 = Vec3::splat(0.25);
/// Colour of lights in the atlas of lights.
const LIGHT_COLOUR: [u8; 3] = [255, 140, 0];

/// Figures of a relight report, by section.
pub struct RelightPictures {
    /// Composite and captured room.
    pub views: Vec<Figure>,
    /// Objects alone, their coverage.
    pub objects: Vec<Figure>,
    /// Objects' change of the room, shadows.
    pub change: Vec<Figure>,
    /// Texel atlases: B₀, B, lights, reflectance.
    pub atlases: Vec<Figure>,
    /// Exposure of all pictures without false colours, in radiance.
    pub exposure: Exposure,
}

/// Function that draws a picture.
type DrawPicture<'a> = &'a (dyn Fn() -> RgbaPicture + Sync);

impl RelightPictures {
    /// Draws all pictures in parallel; PNG compression dominates.
    pub fn new(relit: &RelitScene, composite: &Composite, exposure: Exposure) -> Self {
        let [behind, any] = &composite.coverage;
        let of = |colours: &[Vec3], coverage: &[f32]| tone_map_picture(composite.size, colours, coverage, exposure);
        let seen = composite.background.iter();
        let rms = match weighted_rms(seen.map(|colour| (f64::from(luminance(*colour)), 1.0))) {
            rms if rms > 0.0 => rms,
            _ => 1.0,
        };
        let relative = |k: usize| f64::from(luminance(composite.change[k])) / rms;
        let range = false_colour_range((0..composite.change.len()).step_by(RANGE_SAMPLE_STRIDE).map(relative));

        let white = format_number(f64::from(exposure.white));
        let covered: f64 = composite.mask.iter().map(|share| f64::from(*share)).sum();
        let covered = format_percent(covered / composite.mask.len().max(1) as f64);
        let views: [(DrawPicture, &str, Text); 6] = [
            (
                &|| of(&composite.composite, any),
                "The room with the object",
                captioned_text(
                    "Composite",
                    format!(
                        " · the background with the room's light changed by the objects, and the objects themselves. \
                         White is {white} W/m²/sr."
                    ),
                ),
            ),
            (
                &|| of(&composite.background, behind),
                "The room as it was captured",
                captioned_text("Background", " · as captured, at the same exposure.".into()),
            ),
            (
                &|| of(&composite.objects, &composite.mask),
                "The object alone",
                captioned_text(
                    "The object alone",
                    " · lit by the room, interreflection included.".into(),
                ),
            ),
            (
                &|| draw_mask(composite),
                "The object's coverage",
                captioned_text(
                    "Its mask",
                    format!(" · white where a pixel shows only the object; {covered} of the picture."),
                ),
            ),
            (
                &|| draw_over_room(composite, |k| decode_srgb(diverging_colour(relative(k) / range))),
                "Change of the room in false colours",
                captioned_text(
                    "B − B₀",
                    format!(
                        " · blue is darker, red lighter: luminance relative to the background's rms ({} W/m²/sr), \
                         clipped beyond the range; grey is the object.",
                        format_number(rms)
                    ),
                ) + colour_bar(range),
            ),
            (
                &|| draw_over_room(composite, |k| Vec3::splat(remaining_light_share(composite, k))),
                "Shadows",
                captioned_text(
                    "Shadows",
                    " · the remaining share of the background's light where the objects reduce it: white is 1, black \
                     is 0."
                        .into(),
                ),
            ),
        ];
        let (mut views, atlases) = rayon::join(
            || draw_figures(&views, Figure::from_picture),
            || draw_atlases(relit, exposure),
        );
        let change = views.split_off(4);
        let objects = views.split_off(2);
        Self {
            views,
            objects,
            change,
            atlases,
            exposure,
        }
    }
}

/// Draws pictures in parallel, each with its alternative text and caption.
fn draw_figures(plans: &[(DrawPicture, &str, Text)], figure: fn(&str, &str, Text) -> Figure) -> Vec<Figure> {
    let draw = |(draw, alt, caption): &(DrawPicture, &str, Text)| figure(&draw().data_uri(), alt, caption.clone());
    plans.par_iter().map(draw).collect()
}

/// Returns a caption: a bold name and what it says.
fn captioned_text(name: &str, says: String) -> Text {
    bold_text(name) + says
}

/// Draws the texel atlases: B₀, B, lights, reflectance.
fn draw_atlases(relit: &RelitScene, exposure: Exposure) -> Vec<Figure> {
    let texels = &relit.mesh.texels;
    let radiance = |value: Vec3| encode_srgb(exposure.display_light(value / PI));
    let atlas_white = format_number(f64::from(PI * exposure.white));
    let lights = format_count((0..texels.len()).filter(|k| relit.is_light(*k)).count() as u64);
    let count = format_count(texels.len() as u64);
    let atlases: [(DrawPicture, &str, Text); 4] = [
        (
            &|| draw_atlas(relit.mesh, |k| radiance(relit.captured_radiosity(k))),
            "Atlas before",
            captioned_text(
                "B₀",
                " · captured radiosity of every texel, faces side by side in file order; objects, black here, come \
                 last."
                    .into(),
            ),
        ),
        (
            &|| draw_atlas(relit.mesh, |k| radiance(relit.relit_radiosity(k))),
            "Atlas after",
            captioned_text(
                "B",
                format!(" · with the object, at the same exposure: white is {atlas_white} W/m²."),
            ),
        ),
        (
            &|| draw_lights(relit, exposure),
            "Lights",
            captioned_text(
                "Lights",
                format!(
                    " · orange: texels at least half of whose radiosity is their own emission; {lights} of {count}."
                ),
            ),
        ),
        (
            &|| draw_atlas(relit.mesh, |k| encode_srgb(texels[k].reflectance)),
            "Atlas of the reflectance",
            captioned_text(
                "ρ",
                " · reflectance of every texel, estimated or given; white is 1.".into(),
            ),
        ),
    ];
    draw_figures(&atlases, Figure::from_texels)
}

/// Draws a linear colour per pixel, blended to grey by the objects' coverage.
fn draw_over_room(composite: &Composite, colour: impl Fn(usize) -> Vec3) -> RgbaPicture {
    let [w, h] = composite.size;
    let pixel = |x: u32, y: u32| {
        let k = (y * w + x) as usize;
        let shown = composite.coverage[1][k] > 0.0;
        shown.then(|| encode_srgb(colour(k).lerp(HIDDEN_COLOUR, composite.mask[k])))
    };
    RgbaPicture::from_pixels(w, h, pixel)
}

/// Draws the objects' coverage.
fn draw_mask(composite: &Composite) -> RgbaPicture {
    let [w, h] = composite.size;
    let share = |x: u32, y: u32| composite.mask[(y * w + x) as usize];
    RgbaPicture::from_pixels(w, h, |x, y| Some([(share(x, y) * 255.0).round() as u8; 3]))
}

/// Returns 1 + change/background in luminance, clamped to 0…1; 1 where the objects add light.
fn remaining_light_share(composite: &Composite, k: usize) -> f32 {
    let taken = luminance(composite.change[k]).min(0.0);
    let open = luminance(composite.background[k]) * (1.0 - composite.mask[k]);
    match (taken < 0.0, open > 0.0) {
        (false, _) => 1.0,
        (true, true) => (1.0 + taken / open).clamp(0.0, 1.0),
        (true, false) => 0.0,
    }
}

/// Draws an atlas with lights in colour on the grey room.
fn draw_lights(relit: &RelitScene, exposure: Exposure) -> RgbaPicture {
    draw_atlas(relit.mesh, |k| match relit.is_light(k) {
        true => LIGHT_COLOUR,
        false => {
            let grey = luminance(exposure.display_light(relit.captured_radiosity(k) / PI));
            encode_srgb(Vec3::splat(0.6 * grey))
        }
    })
}
