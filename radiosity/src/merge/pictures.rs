//! Draws the radiance map at three exposures, and the photograph with the largest weight in each pixel.

use crate::merge::brackets::{Brackets, RadianceMap};
use crate::report::picture::{Exposure, NOT_A_NUMBER, RgbaPicture, encode_srgb};
use plotters::prelude::{ColorMap, ViridisRGB};

/// Approximate maximum pixels per side of a picture; larger ones are subsampled.
const MAX_PICTURE_SIDE: usize = 640;
/// Shares of the pixels that the three pictures show no brighter than [`PERCENTILE_DISPLAY_VALUE`].
const PICTURE_PERCENTILES: [f64; 3] = [0.5, 0.9, 0.995];
/// Display value of those percentiles, relative to linear white.
const PERCENTILE_DISPLAY_VALUE: f32 = 0.8;

/// Pictures as sources of `img` elements, with the exposures that their captions state.
pub struct MergePictures {
    /// Radiance map exposed for the dark half, for most pixels, and for all but the brightest.
    pub merged: [(Exposure, String); 3],
    /// Photograph with the largest weight, in the colours of [`exposure_colour`]; magenta for none.
    pub dominant: String,
}

impl MergePictures {
    /// Draws all pictures.
    pub fn new(brackets: &Brackets, merged: &RadianceMap) -> Self {
        let mut values: Vec<f32> = merged.radiance.iter().map(|v| v.max_element()).collect();
        values.retain(|value| *value > 0.0);
        values.sort_by(f32::total_cmp);
        let count = brackets.photographs().len();
        Self {
            merged: PICTURE_PERCENTILES.map(|share| {
                let value = values.get((share * values.len() as f64) as usize);
                let white = value.map_or(1.0, |value| (value / PERCENTILE_DISPLAY_VALUE).max(f32::MIN_POSITIVE));
                let exposure = Exposure::with_white(white);
                let display = |k: usize| encode_srgb(exposure.display_light(merged.radiance[k]));
                (exposure, draw_thinned(merged.size, display))
            }),
            dominant: draw_thinned(merged.size, |k| {
                merged.dominant[k].map_or(NOT_A_NUMBER, |k| exposure_colour(k as usize, count))
            }),
        }
    }
}

/// Returns the colour of photograph `k` of `count`, from the longest exposure (violet) to the shortest (yellow).
pub fn exposure_colour(k: usize, count: usize) -> [u8; 3] {
    let last = count.saturating_sub(1).max(1);
    let colour = ViridisRGB.get_color(k as f32 / last as f32);
    [colour.0, colour.1, colour.2]
}

/// Draws a subsampled picture as a data URI.
fn draw_thinned([w, h]: [usize; 2], colour: impl Fn(usize) -> [u8; 3]) -> String {
    let step = w.max(h).div_ceil(MAX_PICTURE_SIDE).max(1);
    let pixels = |n: usize| n.div_ceil(step) as u32;
    let at = |x: u32, y: u32| Some(colour(y as usize * step * w + x as usize * step));
    RgbaPicture::from_pixels(pixels(w), pixels(h), at).data_uri()
}
