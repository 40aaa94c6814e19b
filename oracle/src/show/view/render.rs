//! A picture of the scene: which point each view ray hits, and what colour it gets.
//!
//! The hits are found once and shaded by any field, so that two pictures differ by their fields
//! only.

use crate::show::picture::{Picture, encode};
use crate::show::view::camera::Camera;
use crate::show::view::surface::{Ring, Stencil, Surface};
use common::rays::Rays;
use glam::Vec3;
use rayon::prelude::*;

/// Samples per pixel and side.
const SUPERSAMPLING: u32 = 2;

/// What a view ray hits.
#[derive(Clone, Copy, Debug)]
pub struct Hit {
    /// The face.
    pub face: u32,
    /// Its texel, and the point among the texel's nodes.
    pub stencil: Stencil,
}

/// The hits of a square picture's samples.
pub struct View {
    size: u32,
    hits: Vec<Option<Hit>>,
}

impl View {
    /// What one takes of `size` pixels a side.
    pub const fn bytes(size: u32) -> u64 {
        let samples = size as u64 * SUPERSAMPLING as u64;
        samples * samples * size_of::<Option<Hit>>() as u64
    }

    /// Looks through `camera` with `size` pixels a side.
    pub fn new(camera: &Camera, surface: &Surface, rays: &Rays, size: u32) -> Self {
        let samples = size * SUPERSAMPLING;
        let at = |k: u32| (k as f32 + 0.5) / samples as f32 * 2.0 - 1.0;
        let hits = (0..samples * samples)
            .into_par_iter()
            .map_init(Ring::default, |ring, k| {
                let direction = camera.direction(at(k % samples), -at(k / samples));
                let (face, t) = rays.front(camera.eye, direction)?;
                let point = (camera.eye + direction * t).as_dvec3();
                let texel = surface.texel(face, point);
                Some(Hit {
                    face,
                    stencil: surface.stencil_within(ring, texel, point),
                })
            })
            .collect();
        Self { size, hits }
    }

    /// The hits, row by row from the upper left.
    pub fn hits(&self) -> impl Iterator<Item = &Hit> {
        self.hits.iter().flatten()
    }

    /// Each hit coloured (linear, 0…1) and averaged over its pixel; transparent where none is.
    pub fn shade(&self, colour: impl Fn(&Hit) -> Vec3 + Sync) -> Picture {
        let side = SUPERSAMPLING * SUPERSAMPLING;
        let pixels = self.gather(|hit| colour(hit).clamp(Vec3::ZERO, Vec3::ONE));
        let rgba = pixels
            .into_iter()
            .flat_map(|(sum, count)| {
                let mean = if count > 0 { sum / count as f32 } else { sum };
                let [r, g, b] = encode(mean);
                [r, g, b, (255 * count / side) as u8]
            })
            .collect();
        Picture {
            width: self.size,
            height: self.size,
            rgba,
        }
    }

    /// The mean value of each pixel's hits, row by row from the upper left; none where none is.
    pub fn mean(&self, value: impl Fn(&Hit) -> Vec3 + Sync) -> Vec<Option<Vec3>> {
        let pixels = self.gather(value).into_iter();
        pixels
            .map(|(sum, count)| (count > 0).then(|| sum / count as f32))
            .collect()
    }

    /// Sum and number of each pixel's hits.
    fn gather(&self, value: impl Fn(&Hit) -> Vec3 + Sync) -> Vec<(Vec3, u32)> {
        let (samples, side) = (self.size * SUPERSAMPLING, SUPERSAMPLING);
        (0..self.size * self.size)
            .into_par_iter()
            .map(|k| {
                let (x, y) = (k % self.size * side, k / self.size * side);
                let inside = (0..side * side).filter_map(|s| {
                    let index = (y + s / side) * samples + x + s % side;
                    self.hits[index as usize].as_ref()
                });
                inside.fold((Vec3::ZERO, 0), |(sum, count), hit| {
                    (sum + value(hit), count + 1)
                })
            })
            .collect()
    }
}
