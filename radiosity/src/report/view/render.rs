//! Renders pictures of the scene: view rays are traced once, then their hits are shaded by any field.

use crate::report::document::{Figure, Text, colour_bar};
use crate::report::picture::{
    EXPOSURE_PERCENTILE, Exposure, RgbaPicture, decode_srgb, diverging_colour, encode_srgb, false_colour_range,
};
use crate::report::view::camera::Camera;
use crate::report::view::interpolation::{InterpolatedField, InterpolationStencil, InterpolationSurface, KnotCache};
use common::rays::Rays;
use glam::Vec3;
use rayon::prelude::*;

/// Samples per side of a pixel.
const SAMPLES_PER_SIDE: u32 = 2;
/// Stride over the hits that choose an exposure or a false-colour range: odd, so that all columns take part.
const RANGE_SAMPLE_STRIDE: usize = 29;

/// Hit point of a view ray.
#[derive(Clone, Copy, Debug)]
pub struct ViewHit {
    /// Face.
    pub face: u32,
    /// Texel and interpolation weights of the point.
    pub stencil: InterpolationStencil,
}

/// View ray hits of a square picture's samples.
pub struct ViewHits {
    size: u32,
    hits: Vec<Option<ViewHit>>,
}

impl ViewHits {
    /// Returns the memory of a picture with `size` pixels per side, bytes.
    pub const fn memory_bytes(size: u32) -> u64 {
        let samples = size as u64 * SAMPLES_PER_SIDE as u64;
        samples * samples * size_of::<Option<ViewHit>>() as u64
    }

    /// Traces the view rays of `camera` with `size` pixels per side.
    pub fn new(camera: &Camera, surface: &InterpolationSurface, rays: &Rays, size: u32) -> Self {
        let samples = size * SAMPLES_PER_SIDE;
        let at = |k: u32| (k as f32 + 0.5) / samples as f32 * 2.0 - 1.0;
        let ray = camera.ray_generator();
        let hits = (0..samples * samples)
            .into_par_iter()
            .map_init(KnotCache::default, |ring, k| {
                let direction = ray(at(k % samples), -at(k / samples));
                let (face, t) = rays.nearest_front(camera.eye, direction)?;
                let point = (camera.eye + direction * t).as_dvec3();
                let texel = surface.texel_at(face, point);
                Some(ViewHit {
                    face,
                    stencil: surface.stencil_within(ring, texel, point),
                })
            })
            .collect();
        Self { size, hits }
    }

    /// Iterates over the hits, row-major from the upper left.
    pub fn iter_hits(&self) -> impl Iterator<Item = &ViewHit> {
        self.hits.iter().flatten()
    }

    /// Shades each hit with a linear colour 0…1 and averages over pixels; pixels without a hit are transparent.
    pub fn shade_hits(&self, colour: impl Fn(&ViewHit) -> Vec3 + Sync) -> RgbaPicture {
        let side = SAMPLES_PER_SIDE * SAMPLES_PER_SIDE;
        let pixels = self.sum_samples(|hit| colour(hit).clamp(Vec3::ZERO, Vec3::ONE));
        let rgba = pixels
            .into_iter()
            .flat_map(|(sum, count)| {
                let mean = if count > 0 { sum / count as f32 } else { sum };
                let [r, g, b] = encode_srgb(mean);
                [r, g, b, (255 * count / side) as u8]
            })
            .collect();
        RgbaPicture {
            width: self.size,
            height: self.size,
            rgba,
        }
    }

    /// Chooses the exposure from the reflected radiosity of the visible texels that emit nothing.
    pub fn choose_exposure(&self, light: &InterpolatedField) -> Exposure {
        let values = self.iter_hits().step_by(RANGE_SAMPLE_STRIDE).filter_map(|hit| {
            let texel = light.surface.mesh.texels.get(hit.stencil.texel as usize)?;
            let reflected = light.radiosity_at(&hit.stencil) - texel.emission;
            (texel.emission == Vec3::ZERO).then_some((reflected.max_element(), 1.0))
        });
        Exposure::from_percentile(values, EXPOSURE_PERCENTILE)
    }

    /// Draws radiosity E + ρH at an exposure.
    pub fn expose_light(&self, light: &InterpolatedField, exposure: Exposure) -> RgbaPicture {
        self.shade_hits(|hit| exposure.display_light(light.radiosity_at(&hit.stencil)))
    }

    /// Draws a value of the hits in false colours from −range to +range, a round number that few values exceed.
    pub fn false_colour_figure(&self, alt: &str, caption: Text, value: impl Fn(&ViewHit) -> f64 + Sync) -> Figure {
        let range = false_colour_range(self.iter_hits().step_by(RANGE_SAMPLE_STRIDE).map(&value));
        let picture = self.shade_hits(|hit| decode_srgb(diverging_colour(value(hit) / range)));
        Figure::from_picture(&picture.data_uri(), alt, caption + colour_bar(range))
    }

    /// Returns the mean value of each pixel's hits, row-major from the upper left; none without a hit.
    pub fn pixel_means(&self, value: impl Fn(&ViewHit) -> Vec3 + Sync) -> Vec<Option<Vec3>> {
        let pixels = self.sum_samples(value).into_iter();
        pixels
            .map(|(sum, count)| (count > 0).then(|| sum / count as f32))
            .collect()
    }

    /// Returns sum and number of each pixel's hits.
    fn sum_samples(&self, value: impl Fn(&ViewHit) -> Vec3 + Sync) -> Vec<(Vec3, u32)> {
        let (samples, side) = (self.size * SAMPLES_PER_SIDE, SAMPLES_PER_SIDE);
        (0..self.size * self.size)
            .into_par_iter()
            .map(|k| {
                let (x, y) = (k % self.size * side, k / self.size * side);
                let inside = (0..side * side).filter_map(|s| {
                    let index = (y + s / side) * samples + x + s % side;
                    self.hits[index as usize].as_ref()
                });
                inside.fold((Vec3::ZERO, 0), |(sum, count), hit| (sum + value(hit), count + 1))
            })
            .collect()
    }
}
