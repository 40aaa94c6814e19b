//! Draws the pictures of a relight report.

use super::RelitScene;
use super::composite::Composite;
use super::files::tone_map_picture;
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

/// Pictures as sources of `img` elements, and the values that their captions state.
pub struct RelightPictures {
    /// Captured room, composite.
    pub views: [String; 2],
    /// Objects alone, their coverage.
    pub objects: [String; 2],
    /// Objects' change of the room, in false colours.
    pub change: String,
    /// Half-width of the false-colour range.
    pub range: f64,
    /// RMS of the background's luminance, the unit of the false colours, W/m²/sr.
    pub rms: f64,
    /// Shadows: remaining share of the background's light.
    pub shadows: String,
    /// Texel atlases: B₀, B.
    pub atlases: [String; 2],
    /// Atlas of lights, and the number of light texels.
    pub lights: (String, usize),
    /// Atlas of reflectance.
    pub reflectance: String,
    /// Exposure of all pictures without false colours, in radiance.
    pub exposure: Exposure,
}

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
        let texels = &relit.mesh.texels;
        let draw: [&(dyn Fn() -> RgbaPicture + Sync); 10] = [
            &|| of(&composite.background, behind),
            &|| of(&composite.composite, any),
            &|| of(&composite.objects, &composite.mask),
            &|| draw_mask(composite),
            &|| draw_over_room(composite, |k| decode_srgb(diverging_colour(relative(k) / range))),
            &|| draw_over_room(composite, |k| Vec3::splat(remaining_light_share(composite, k))),
            &|| draw_radiance_atlas(relit, exposure, |k| relit.captured_radiosity(k)),
            &|| draw_radiance_atlas(relit, exposure, |k| relit.relit_radiosity(k)),
            &|| draw_lights(relit, exposure),
            &|| draw_atlas(relit.mesh, |k| encode_srgb(texels[k].reflectance)),
        ];
        let drawn: Vec<String> = draw.par_iter().map(|draw| draw().data_uri()).collect();
        let mut drawn = drawn.into_iter();
        let mut next = || drawn.next().unwrap_or_default();
        Self {
            views: [next(), next()],
            objects: [next(), next()],
            change: next(),
            range,
            rms,
            shadows: next(),
            atlases: [next(), next()],
            lights: (next(), (0..texels.len()).filter(|k| relit.is_light(*k)).count()),
            reflectance: next(),
            exposure,
        }
    }
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
    if taken == 0.0 {
        1.0
    } else if open > 0.0 {
        (1.0 + taken / open).clamp(0.0, 1.0)
    } else {
        0.0
    }
}

/// Draws an atlas of radiosity.
fn draw_radiance_atlas(relit: &RelitScene, exposure: Exposure, value: impl Fn(usize) -> Vec3) -> RgbaPicture {
    let colour = |k: usize| encode_srgb(exposure.display_light(value(k) / PI));
    draw_atlas(relit.mesh, colour)
}

/// Draws an atlas with lights in colour on the grey room.
fn draw_lights(relit: &RelitScene, exposure: Exposure) -> RgbaPicture {
    let colour = |k: usize| {
        if relit.is_light(k) {
            return LIGHT_COLOUR;
        }
        let grey = luminance(exposure.display_light(relit.captured_radiosity(k) / PI));
        encode_srgb(Vec3::splat(0.6 * grey))
    };
    draw_atlas(relit.mesh, colour)
}
