//! Draws the figures of a relight report.

use super::composite::Composite;
use super::files::tone_map_picture;
use crate::report::document::{Figure, Text, bold_text, colour_bar};
use crate::report::format::{format_number, format_percent};
use crate::report::picture::{
    Exposure, RgbaPicture, compute_luminance, decode_srgb, diverging_colour, encode_srgb, false_colour_range,
    png_data_uri, weighted_rms,
};
use glam::Vec3;
use rayon::prelude::*;

/// Every `STRIDE`th pixel enters the choice of the false-colour range.
const RANGE_SAMPLE_STRIDE: usize = 7;
/// Linear colour of pixels in which an object hides the room.
const HIDDEN_COLOUR: Vec3 = Vec3::splat(0.25);

/// Function that draws a picture.
type DrawPicture<'a> = &'a (dyn Fn() -> RgbaPicture + Sync);

/// Draws captured room, objects alone and their change of the room in parallel, as PNG compression dominates, after the
/// composite's own `png`.
pub fn draw_figures(composite: &Composite, png: &[u8], exposure: Exposure) -> Vec<Figure> {
    let of = |colours: &[Vec3], coverage: &[f32]| tone_map_picture(composite.size, colours, coverage, exposure);
    let seen = composite.background.iter();
    let rms = match weighted_rms(seen.map(|colour| (f64::from(compute_luminance(*colour)), 1.0))) {
        rms if rms > 0.0 => rms,
        _ => 1.0,
    };
    let relative = |k: usize| f64::from(compute_luminance(composite.change[k])) / rms;
    let range = false_colour_range((0..composite.change.len()).step_by(RANGE_SAMPLE_STRIDE).map(relative));

    let white = format_number(f64::from(exposure.white));
    let covered: f64 = composite.mask.iter().map(|share| f64::from(*share)).sum();
    let covered = format_percent(covered / composite.mask.len().max(1) as f64);
    let composite_figure = Figure::from_picture(
        &png_data_uri(png),
        "The room with the object",
        bold_text("Composite")
            + " · the background with the room's light changed by the objects, and the objects themselves. White is "
            + format!("{white} W/m²/sr."),
    );
    let plans: [(DrawPicture, &str, Text); 3] = [
        (
            &|| of(&composite.background, &composite.coverage[0]),
            "The room as it was captured",
            bold_text("Background") + " · as captured, at the same exposure.",
        ),
        (
            &|| of(&composite.objects, &composite.mask),
            "The object alone",
            bold_text("The object alone")
                + format!(" · lit by the room, interreflection included; {covered} of the picture."),
        ),
        (
            &|| draw_over_room(composite, |k| decode_srgb(diverging_colour(relative(k) / range))),
            "Change of the room in false colours",
            bold_text("B − B₀")
                + format!(
                    " · blue is darker, red lighter: luminance relative to the background's rms ({} W/m²/sr), \
                         clipped beyond the range; grey is the object.",
                    format_number(rms)
                )
                + colour_bar(range),
        ),
    ];
    let draw = |(draw, alt, caption): &(DrawPicture, &str, Text)| {
        Figure::from_picture(&draw().data_uri(), alt, caption.clone())
    };
    let others: Vec<Figure> = plans.par_iter().map(draw).collect();
    [composite_figure].into_iter().chain(others).collect()
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
