//! Light on a file's own charts.
//!
//! A pixel has the light at its centre. One beside a chart goes on as the chart begins: bilinear sampling within
//! a pixel of the chart's edge finds what lies on the edge, whatever the other charts are.

use super::charts::Charts;
use super::glb::{Part, parts};
use super::image::Image;
use crate::show::view::surface::Interpolant;
use common::scene::Scene;
use glam::{DMat2, DVec2, DVec3, Vec3};
use rayon::prelude::*;

/// Sides of the picture.
const SIZES: [u32; 2] = [64, 2048];
/// Pixels along a texel, each way.
const FINE: f64 = 2.0;
/// The share of the picture that has so many; the rest is of slivers, which would ask for any number.
const FINE_SHARE: f64 = 0.95;
/// Pixels that bilinear sampling within a chart asks are no farther from it.
const ASKED: f64 = std::f64::consts::SQRT_2;
/// Pixels that have light beside a chart: programs may sample coarser than bilinearly.
const BESIDE: f64 = 4.0;

/// The picture, what it lies on, and what is to be said of it.
pub fn lay<'a>(
    scene: &'a Scene,
    charts: &Charts,
    light: &Interpolant,
) -> (Image, Vec<Part<'a>>, Option<String>) {
    let [_, largest] = SIZES;
    let mut owners = Owners::new(charts, size(charts, light));
    while owners.shared > 0 && owners.size < largest {
        owners = Owners::new(charts, 2 * owners.size);
    }
    let note = (owners.shared > 0).then(|| {
        let (shared, size) = (owners.shared, owners.size);
        format!(
            "of the {size}×{size} pixels of the lightmap {shared} lie between charts that are less than three pixels \
             apart: the light of one shows at the edge of the other"
        )
    });
    let parts = parts(scene, |part, k| {
        let Some(chart) = charts.places[k] else {
            return;
        };
        let first = part.places.len() as u32;
        let corners = scene.faces[k].outline().iter().map(|p| p.as_vec3());
        part.places.extend(corners);
        part.uvs.extend(chart.map(|p| p.as_vec2().to_array()));
        part.index.extend([0, 1, 2].map(|k| first + k));
    });
    (owners.image(charts, light), parts, note)
}

/// The side of a picture whose pixels are finer than the texels.
fn size(charts: &Charts, light: &Interpolant) -> u32 {
    let patches = light.surface.patches.iter();
    let placed = charts.places.iter().zip(patches);
    let mut wanted: Vec<[f64; 2]> = placed
        .filter_map(|(chart, patch)| {
            let [a, b, c] = (*chart)?;
            let area = (b - a).perp_dot(c - a).abs() / 2.0;
            let side = area.sqrt() / f64::from(patch.size[0]);
            (side > 0.0).then_some([FINE / side, area])
        })
        .collect();
    wanted.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let all: f64 = wanted.iter().map(|[_, area]| area).sum();
    let mut below = 0.0;
    let enough = wanted.iter().find(|[_, area]| {
        below += area;
        below >= FINE_SHARE * all
    });
    let [least, most] = SIZES;
    let pixels = enough.map_or(0.0, |[pixels, _]| *pixels);
    (pixels.min(f64::from(most)) as u32)
        .next_power_of_two()
        .clamp(least, most)
}

/// A chart on the pixels, (0, 0) being the first one's centre.
struct Placed {
    face: u32,
    corners: [DVec2; 3],
}

impl Placed {
    fn new(face: u32, chart: [DVec2; 3], size: u32) -> Self {
        Self {
            face,
            corners: chart.map(|p| p * f64::from(size) - 0.5),
        }
    }

    /// Its point that is nearest to another.
    fn nearest(&self, p: DVec2) -> DVec2 {
        let [a, b, c] = self.corners;
        let turn = (b - a).perp_dot(c - a).signum();
        let edges = [(a, b), (b, c), (c, a)];
        let inside = |(from, to): (DVec2, DVec2)| (to - from).perp_dot(p - from) * turn >= 0.0;
        if edges.into_iter().all(inside) {
            return p;
        }
        let on = edges.map(|(from, to)| {
            let along = (p - from).dot(to - from) / (to - from).length_squared();
            let along = if along.is_finite() { along } else { 0.0 };
            from.lerp(to, along.clamp(0.0, 1.0))
        });
        let nearer = |a: DVec2, b: DVec2| {
            if b.distance_squared(p) < a.distance_squared(p) {
                b
            } else {
                a
            }
        };
        on.into_iter().fold(on[0], nearer)
    }

    /// B and H there.
    fn light(&self, p: DVec2, light: &Interpolant) -> [Vec3; 2] {
        let [a, b, c] = self.corners;
        let place = DMat2::from_cols(b - a, c - a).inverse() * (p - a);
        let place = if place.is_finite() {
            place
        } else {
            DVec2::ZERO
        };
        let patch = &light.surface.patches[self.face as usize];
        let point: DVec3 = patch.point(place.x, place.y);
        let stencil = light
            .surface
            .stencil(light.surface.texel(self.face, point), point);
        [light.radiosity(&stencil), light.value(&stencil).as_vec3()]
    }

    /// The same, going on beside it as it does before its edge.
    fn beyond(&self, p: DVec2, light: &Interpolant) -> [Vec3; 2] {
        let edge = self.nearest(p);
        let at_edge = self.light(edge, light);
        let off = p - edge;
        let mirrored = self.nearest(edge - off.clamp_length_max(ASKED));
        if off == DVec2::ZERO || mirrored == edge {
            return at_edge;
        }
        let within = self.light(mirrored, light);
        [0, 1].map(|k| (2.0 * at_edge[k] - within[k]).max(Vec3::ZERO))
    }
}

/// The chart of each pixel.
struct Owners {
    size: u32,
    /// Its face, and how far away it is in pixels.
    pixels: Vec<Option<(u32, f32)>>,
    /// Pixels that two charts ask.
    shared: usize,
}

impl Owners {
    fn new(charts: &Charts, size: u32) -> Self {
        let mut owners = Self {
            size,
            pixels: vec![None; size as usize * size as usize],
            shared: 0,
        };
        for (k, chart) in (0..).zip(&charts.places) {
            if let Some(chart) = chart {
                owners.add(&Placed::new(k, *chart, size), &charts.islands);
            }
        }
        owners
    }

    /// The nearest chart has a pixel.
    fn add(&mut self, placed: &Placed, islands: &[u32]) {
        let [a, b, c] = placed.corners;
        let last = DVec2::splat(f64::from(self.size - 1));
        let low = (a.min(b).min(c) - BESIDE).ceil().clamp(DVec2::ZERO, last);
        let high = (a.max(b).max(c) + BESIDE).floor().clamp(DVec2::ZERO, last);
        let [[left, top], [right, bottom]] = [low, high].map(|p| p.as_uvec2().to_array());
        for (y, x) in (top..=bottom).flat_map(|y| (left..=right).map(move |x| (y, x))) {
            let p = DVec2::new(f64::from(x), f64::from(y));
            let off = placed.nearest(p).distance(p) as f32;
            if off > BESIDE as f32 {
                continue;
            }
            let pixel = &mut self.pixels[y as usize * self.size as usize + x as usize];
            let (other, before) = pixel.unwrap_or((placed.face, f32::INFINITY));
            let apart = islands[other as usize] != islands[placed.face as usize];
            self.shared += usize::from(apart && off.max(before) < ASKED as f32);
            if off < before {
                *pixel = Some((placed.face, off));
            }
        }
    }

    fn image(&self, charts: &Charts, light: &Interpolant) -> Image {
        let mut image = Image::dark([self.size; 2]);
        let size = self.size as usize;
        let lit = self.pixels.par_iter().enumerate().map(|(k, pixel)| {
            let p = DVec2::new((k % size) as f64, (k / size) as f64);
            let owner = pixel.and_then(|(k, _)| Some((k, charts.places[k as usize]?)));
            owner.map_or([Vec3::ZERO; 2], |(k, chart)| {
                Placed::new(k, chart, self.size).beyond(p, light)
            })
        });
        (image.radiosity, image.irradiance) = lit.map(|[b, h]| (b, h)).unzip();
        image
    }
}
