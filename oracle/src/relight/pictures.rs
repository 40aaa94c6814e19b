//! The pictures of a relight's report.

use super::Relit;
use super::composite::Composite;
use super::files::picture;
use crate::show::picture::{
    Exposure, Picture, atlas_of, decode, diverging, encode, luminance, range, rms,
};
use glam::Vec3;
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
    /// Draws everything.
    pub fn new(relit: &Relit, composite: &Composite, exposure: Exposure) -> Self {
        let [behind, any] = &composite.coverage;
        let draw = |colours: &[Vec3], coverage: &[f32]| {
            picture(composite.size, colours, coverage, exposure).data_uri()
        };
        let seen = composite.background.iter();
        let rms = match rms(seen.map(|colour| (f64::from(luminance(*colour)), 1.0))) {
            rms if rms > 0.0 => rms,
            _ => 1.0,
        };
        let relative = |k: usize| f64::from(luminance(composite.change[k])) / rms;
        let range = range((0..composite.change.len()).step_by(STRIDE).map(relative));
        Self {
            views: [
                draw(&composite.background, behind),
                draw(&composite.composite, any),
            ],
            objects: [
                draw(&composite.objects, &composite.mask),
                mask(composite).data_uri(),
            ],
            change: over_room(composite, |k| decode(diverging(relative(k) / range))),
            range,
            rms,
            shadows: over_room(composite, |k| Vec3::splat(left(composite, k))),
            atlases: atlases(relit, exposure),
            lights: lights(relit, exposure),
            reflectance: {
                let texels = &relit.mesh.texels;
                atlas_of(relit.mesh, |k| encode(texels[k].reflectance)).data_uri()
            },
            exposure,
        }
    }
}

/// A colour (linear) for each pixel, grey by as much as objects hide it.
fn over_room(composite: &Composite, colour: impl Fn(usize) -> Vec3) -> String {
    let [w, h] = composite.size;
    let pixel = |x: u32, y: u32| {
        let k = (y * w + x) as usize;
        let shown = composite.coverage[1][k] > 0.0;
        shown.then(|| encode(colour(k).lerp(HIDDEN, composite.mask[k])))
    };
    Picture::from_pixels(w, h, pixel).data_uri()
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

fn atlases(relit: &Relit, exposure: Exposure) -> [String; 2] {
    let draw = |value: &dyn Fn(usize) -> Vec3| {
        let colour = |k: usize| encode(exposure.display(value(k) / PI));
        atlas_of(relit.mesh, colour).data_uri()
    };
    [draw(&|k| relit.captured(k)), draw(&|k| relit.relit(k))]
}

/// Lights stand out of a grey room.
fn lights(relit: &Relit, exposure: Exposure) -> (String, usize) {
    let colour = |k: usize| {
        if relit.is_light(k) {
            return LIGHT;
        }
        let grey = luminance(exposure.display(relit.captured(k) / PI));
        encode(Vec3::splat(0.6 * grey))
    };
    let count = (0..relit.mesh.texels.len())
        .filter(|k| relit.is_light(*k))
        .count();
    (atlas_of(relit.mesh, colour).data_uri(), count)
}
