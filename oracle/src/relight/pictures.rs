//! The pictures of a relight's report.

use super::Relit;
use super::composite::Composite;
use super::files::picture;
use crate::show::picture::{
    Exposure, Picture, atlas_of, decode, diverging, encode, luminance, range, rms,
};
use glam::Vec3;
use rayon::prelude::*;
use std::f32::consts::PI;

/// Every how manieth pixel decides the range of the false colours.
const STRIDE: usize = 7;
/// Where an object hides the room.
const HIDDEN: Vec3 = Vec3::splat(0.25);
/// Lights in the atlas that shows them.
const LIGHT: [u8; 3] = [255, 140, 0];

/// Sources of `img` elements, with what their captions say.
pub struct Pictures {
    /// The captured room, and with the objects.
    pub views: [String; 2],
    /// The objects alone, and their coverage.
    pub objects: [String; 2],
    /// What the objects change in the room, in false colours.
    pub change: String,
    /// The false colours go from −range to +range.
    pub range: f64,
    /// rms of the background's luminance, W/m²/sr: what 1 is in the false colours.
    pub rms: f64,
    /// The light that the objects leave of the background, where they take some.
    pub shadows: String,
    /// All texels: B₀, B.
    pub atlases: [String; 2],
    /// Which texels of the room are lights, and how many.
    pub lights: (String, usize),
    /// All texels' reflectance.
    pub reflectance: String,
    /// The exposure of everything that is not in false colours, as radiance.
    pub exposure: Exposure,
}

impl Pictures {
    /// Draws everything, some at a time: most of it is packing.
    pub fn new(relit: &Relit, composite: &Composite, exposure: Exposure) -> Self {
        let [behind, any] = &composite.coverage;
        let of = |colours: &[Vec3], coverage: &[f32]| {
            picture(composite.size, colours, coverage, exposure)
        };
        let seen = composite.background.iter();
        let rms = match rms(seen.map(|colour| (f64::from(luminance(*colour)), 1.0))) {
            rms if rms > 0.0 => rms,
            _ => 1.0,
        };
        let relative = |k: usize| f64::from(luminance(composite.change[k])) / rms;
        let range = range((0..composite.change.len()).step_by(STRIDE).map(relative));
        let texels = &relit.mesh.texels;
        let draw: [&(dyn Fn() -> Picture + Sync); 10] = [
            &|| of(&composite.background, behind),
            &|| of(&composite.composite, any),
            &|| of(&composite.objects, &composite.mask),
            &|| mask(composite),
            &|| over_room(composite, |k| decode(diverging(relative(k) / range))),
            &|| over_room(composite, |k| Vec3::splat(left(composite, k))),
            &|| atlas(relit, exposure, |k| relit.captured(k)),
            &|| atlas(relit, exposure, |k| relit.relit(k)),
            &|| lights(relit, exposure),
            &|| atlas_of(relit.mesh, |k| encode(texels[k].reflectance)),
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
            lights: (
                next(),
                (0..texels.len()).filter(|k| relit.is_light(*k)).count(),
            ),
            reflectance: next(),
            exposure,
        }
    }
}

/// A colour (linear) for each pixel, grey by as much as objects hide it.
fn over_room(composite: &Composite, colour: impl Fn(usize) -> Vec3) -> Picture {
    let [w, h] = composite.size;
    let pixel = |x: u32, y: u32| {
        let k = (y * w + x) as usize;
        let shown = composite.coverage[1][k] > 0.0;
        shown.then(|| encode(colour(k).lerp(HIDDEN, composite.mask[k])))
    };
    Picture::from_pixels(w, h, pixel)
}

fn mask(composite: &Composite) -> Picture {
    let [w, h] = composite.size;
    let share = |x: u32, y: u32| composite.mask[(y * w + x) as usize];
    Picture::from_pixels(w, h, |x, y| Some([(share(x, y) * 255.0).round() as u8; 3]))
}

/// 1 + δ/background in luminance, 0…1: 1 where the objects take nothing.
fn left(composite: &Composite, k: usize) -> f32 {
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

/// All texels' radiosity.
fn atlas(relit: &Relit, exposure: Exposure, value: impl Fn(usize) -> Vec3) -> Picture {
    let colour = |k: usize| encode(exposure.display(value(k) / PI));
    atlas_of(relit.mesh, colour)
}

/// Lights stand out of a grey room.
fn lights(relit: &Relit, exposure: Exposure) -> Picture {
    let colour = |k: usize| {
        if relit.is_light(k) {
            return LIGHT;
        }
        let grey = luminance(exposure.display(relit.captured(k) / PI));
        encode(Vec3::splat(0.6 * grey))
    };
    atlas_of(relit.mesh, colour)
}
