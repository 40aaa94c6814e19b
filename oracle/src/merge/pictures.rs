//! The merged picture at three exposures, and which exposure each pixel relied on.

use crate::merge::brackets::{Brackets, Merged};
use crate::show::picture::{Exposure, NOT_A_NUMBER, Picture, encode};
use plotters::prelude::{ColorMap, ViridisRGB};

/// Pictures are thinned out to about this many pixels a side.
const SIDE: usize = 640;
/// Shares of the pixels that are not brighter than [`BRIGHT`] in the three pictures.
const SHOWN: [f64; 3] = [0.5, 0.9, 0.995];
/// Where they go, of a linear display's white.
const BRIGHT: f32 = 0.8;

/// Sources of `img` elements, with what their captions say.
pub struct Pictures {
    /// For the dark half, for most, and for all but the brightest.
    pub merged: [(Exposure, String); 3],
    /// In the colours of [`colour`], magenta where there is none.
    pub relied: String,
}

impl Pictures {
    /// Draws everything.
    pub fn new(brackets: &Brackets, merged: &Merged) -> Self {
        let mut values: Vec<f32> = merged.radiance.iter().map(|v| v.max_element()).collect();
        values.retain(|value| *value > 0.0);
        values.sort_by(f32::total_cmp);
        let count = brackets.exposures().len();
        Self {
            merged: SHOWN.map(|share| {
                let value = values.get((share * values.len() as f64) as usize);
                let white = value.map_or(1.0, |value| (value / BRIGHT).max(f32::MIN_POSITIVE));
                let exposure = Exposure::linear(white);
                let display = |k: usize| encode(exposure.display(merged.radiance[k]));
                (exposure, thinned(merged.size, display))
            }),
            relied: thinned(merged.size, |k| {
                merged.relied[k].map_or(NOT_A_NUMBER, |k| colour(k as usize, count))
            }),
        }
    }
}

/// The colour of exposure k of `count`, from the longest (violet) to the shortest (yellow).
pub fn colour(k: usize, count: usize) -> [u8; 3] {
    let last = count.saturating_sub(1).max(1);
    let colour = ViridisRGB.get_color(k as f32 / last as f32);
    [colour.0, colour.1, colour.2]
}

fn thinned([w, h]: [usize; 2], colour: impl Fn(usize) -> [u8; 3]) -> String {
    let step = w.max(h).div_ceil(SIDE).max(1);
    let pixels = |n: usize| n.div_ceil(step) as u32;
    let at = |x: u32, y: u32| Some(colour(y as usize * step * w + x as usize * step));
    Picture::from_pixels(pixels(w), pixels(h), at).data_uri()
}
