//! Renders the lightmap on the scene file's own UV charts.
//!
//! A pixel gets the light at its centre. Pixels beside a chart are extrapolated from it (gutter), so that bilinear
//! sampling up to the chart's edge does not mix charts.

use super::LightmapImage;
use super::glb::{MeshPart, group_parts};
use super::uv_charts::UvCharts;
use crate::report::picture::weighted_percentile;
use crate::report::view::interpolation::InterpolatedField;
use common::scene::Scene;
use glam::{DMat2, DVec2, DVec3, Vec3};
use rayon::prelude::*;

/// Minimum and maximum pixels per side of the lightmap.
const LIGHTMAP_SIDE_RANGE: [u32; 2] = [64, 2048];
/// Pixels per texel and side.
const PIXELS_PER_TEXEL: f64 = 2.0;
/// Share of the chart area with that resolution; the rest are slivers, which would need any number of pixels.
const RESOLVED_AREA_SHARE: f64 = 0.95;
/// Distance from a chart, in pixels, within which bilinear sampling inside the chart reads pixels.
const FILTER_RADIUS_PIXELS: f64 = std::f64::consts::SQRT_2;
/// Width of the gutter around a chart in pixels: viewers may use a wider filter than bilinear.
const GUTTER_PIXELS: f64 = 4.0;

/// Renders the lightmap on `charts`; returns it with the mesh parts and a note on charts that are too close.
pub fn render_on_file_charts<'a>(
    scene: &'a Scene,
    charts: &UvCharts,
    light: &InterpolatedField,
) -> (LightmapImage, Vec<MeshPart<'a>>, Option<String>) {
    let [_, largest] = LIGHTMAP_SIDE_RANGE;
    let mut owners = PixelOwners::new(charts, lightmap_side(charts, light));
    while owners.conflicts > 0 && owners.size < largest {
        owners = PixelOwners::new(charts, 2 * owners.size);
    }
    let note = (owners.conflicts > 0).then(|| {
        let (shared, size) = (owners.conflicts, owners.size);
        format!(
            "{shared} of the {size}×{size} pixels of the lightmap lie between charts less than three pixels apart: \
             light bleeds from one chart to the edge of the other"
        )
    });
    let parts = group_parts(scene, |part, k| {
        let Some(chart) = charts.corners[k] else {
            return;
        };
        let first = part.positions.len() as u32;
        let corners = scene.faces[k].outline().iter().map(|p| p.as_vec3());
        part.positions.extend(corners);
        part.uvs.extend(chart.map(|p| p.as_vec2().to_array()));
        part.indices.extend([0, 1, 2].map(|k| first + k));
    });
    (owners.render_lightmap(charts, light), parts, note)
}

/// Chooses the lightmap's side so that its pixels are finer than the texels.
fn lightmap_side(charts: &UvCharts, light: &InterpolatedField) -> u32 {
    let grids = light.surface.face_grids.iter();
    let placed = charts.corners.iter().zip(grids);
    let mut wanted: Vec<(f64, f64)> = placed
        .filter_map(|(chart, grid)| {
            let [a, b, c] = (*chart)?;
            let area = (b - a).perp_dot(c - a).abs() / 2.0;
            let side = area.sqrt() / f64::from(grid.size[0]);
            (side > 0.0).then_some((PIXELS_PER_TEXEL / side, area))
        })
        .collect();
    let enough = weighted_percentile(&mut wanted, RESOLVED_AREA_SHARE);
    let [least, most] = LIGHTMAP_SIDE_RANGE;
    let pixels = enough.unwrap_or(0.0);
    (pixels.min(f64::from(most)) as u32)
        .next_power_of_two()
        .clamp(least, most)
}

/// Chart in pixel coordinates; (0, 0) is the centre of the first pixel.
struct PixelChart {
    face: u32,
    corners: [DVec2; 3],
}

impl PixelChart {
    fn new(face: u32, chart: [DVec2; 3], size: u32) -> Self {
        Self {
            face,
            corners: chart.map(|p| p * f64::from(size) - 0.5),
        }
    }

    /// Returns the chart's point nearest to `p`.
    fn nearest_point(&self, p: DVec2) -> DVec2 {
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
        let distance = |point: &DVec2| point.distance_squared(p);
        let nearest = on.into_iter().min_by(|a, b| distance(a).total_cmp(&distance(b)));
        nearest.unwrap_or(p)
    }

    /// Returns radiosity and irradiance at a point of the chart.
    fn light_at(&self, p: DVec2, light: &InterpolatedField) -> [Vec3; 2] {
        let [a, b, c] = self.corners;
        let place = DMat2::from_cols(b - a, c - a).inverse() * (p - a);
        let place = if place.is_finite() { place } else { DVec2::ZERO };
        let grid = &light.surface.face_grids[self.face as usize];
        let point: DVec3 = grid.point_at(place.x, place.y);
        light.light_at(self.face, point)
    }

    /// Returns radiosity and irradiance at `p`, linearly extrapolated beyond the chart's edge.
    fn extrapolated_light(&self, p: DVec2, light: &InterpolatedField) -> [Vec3; 2] {
        let edge = self.nearest_point(p);
        let at_edge = self.light_at(edge, light);
        let off = p - edge;
        let mirrored = self.nearest_point(edge - off.clamp_length_max(FILTER_RADIUS_PIXELS));
        if off == DVec2::ZERO || mirrored == edge {
            return at_edge;
        }
        let within = self.light_at(mirrored, light);
        [0, 1].map(|k| (2.0 * at_edge[k] - within[k]).max(Vec3::ZERO))
    }
}

/// Assignment of pixels to charts.
struct PixelOwners {
    size: u32,
    /// Face of the nearest chart and its distance in pixels.
    pixels: Vec<Option<(u32, f32)>>,
    /// Number of pixels read by bilinear sampling of two islands.
    conflicts: usize,
}

impl PixelOwners {
    fn new(charts: &UvCharts, size: u32) -> Self {
        let mut owners = Self {
            size,
            pixels: vec![None; size as usize * size as usize],
            conflicts: 0,
        };
        for (k, chart) in (0..).zip(&charts.corners) {
            if let Some(chart) = chart {
                owners.add_chart(&PixelChart::new(k, *chart, size), &charts.islands);
            }
        }
        owners
    }

    /// Assigns the pixels around a chart to it where it is the nearest.
    fn add_chart(&mut self, placed: &PixelChart, islands: &[u32]) {
        let [a, b, c] = placed.corners;
        let last = DVec2::splat(f64::from(self.size - 1));
        let low = (a.min(b).min(c) - GUTTER_PIXELS).ceil().clamp(DVec2::ZERO, last);
        let high = (a.max(b).max(c) + GUTTER_PIXELS).floor().clamp(DVec2::ZERO, last);
        let [[left, top], [right, bottom]] = [low, high].map(|p| p.as_uvec2().to_array());
        for (y, x) in (top..=bottom).flat_map(|y| (left..=right).map(move |x| (y, x))) {
            let p = DVec2::new(f64::from(x), f64::from(y));
            let off = placed.nearest_point(p).distance(p) as f32;
            if off > GUTTER_PIXELS as f32 {
                continue;
            }
            let pixel = &mut self.pixels[y as usize * self.size as usize + x as usize];
            let (other, before) = pixel.unwrap_or((placed.face, f32::INFINITY));
            let apart = islands[other as usize] != islands[placed.face as usize];
            self.conflicts += usize::from(apart && off.max(before) < FILTER_RADIUS_PIXELS as f32);
            if off < before {
                *pixel = Some((placed.face, off));
            }
        }
    }

    /// Evaluates the light at all assigned pixels.
    fn render_lightmap(&self, charts: &UvCharts, light: &InterpolatedField) -> LightmapImage {
        let size = self.size as usize;
        let lit = self.pixels.par_iter().enumerate().map(|(k, pixel)| {
            let p = DVec2::new((k % size) as f64, (k / size) as f64);
            let owner = pixel.and_then(|(k, _)| Some((k, charts.corners[k as usize]?)));
            owner.map_or([Vec3::ZERO; 2], |(k, chart)| {
                PixelChart::new(k, chart, self.size).extrapolated_light(p, light)
            })
        });
        LightmapImage {
            size: [self.size; 2],
            light: lit.collect(),
        }
    }
}
