//! Renders the lightmap on charts.
//!
//! A pixel gets the light at its centre. Pixels beside a chart are extrapolated from it (gutter), so that bilinear
//! sampling up to the chart's edge does not mix charts. All others repeat the nearest of these (dilation), so that
//! coarser filters find no black.

use super::uv_charts::UvCharts;
use crate::report::picture::weighted_percentile;
use crate::report::view::interpolation::InterpolatedField;
use common::polygon::distinct_corners;
use common::scene::Scene;
use common::texel::texel_count;
use glam::{DMat2, DVec2, DVec3, Vec3};
use rayon::prelude::*;
use std::collections::VecDeque;

/// Minimum and maximum pixels per side of the lightmap.
pub const LIGHTMAP_SIDE_RANGE: [u32; 2] = [64, 2048];
/// Pixels per texel and side.
const PIXELS_PER_TEXEL: f64 = 2.0;
/// Share of the chart area with that resolution; the rest are slivers, which would need any number of pixels.
const RESOLVED_AREA_SHARE: f64 = 0.95;
/// Distance from a chart, in pixels, within which bilinear sampling inside the chart reads pixels.
const FILTER_RADIUS_PIXELS: f64 = std::f64::consts::SQRT_2;
/// Width of the gutter around a chart in pixels: viewers may use a wider filter than bilinear.
const GUTTER_PIXELS: f64 = 4.0;

/// Lightmap picture.
pub struct LightmapImage {
    /// Pixels per side.
    pub side: u32,
    /// Radiosity B and irradiance H per pixel, row-major from the upper left, W/m².
    pub light: Vec<[Vec3; 2]>,
    /// True for pixels whose centre lies on a chart.
    pub covered: Vec<bool>,
}

/// Renders the lightmap on `charts` of the scene's own, and a note on charts that are too close.
pub fn render_own_charts(charts: &UvCharts, light: &InterpolatedField) -> (LightmapImage, Option<String>) {
    let [_, largest] = LIGHTMAP_SIDE_RANGE;
    let mut owners = PixelOwners::new(charts, own_chart_side(charts, light));
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
    (owners.render_lightmap(charts, light), note)
}

/// Renders the lightmap of this `side` on `charts`.
pub fn render_charts(charts: &UvCharts, side: u32, light: &InterpolatedField) -> LightmapImage {
    PixelOwners::new(charts, side).render_lightmap(charts, light)
}

/// Returns the pixels per unit of length that are finer than the texels.
pub fn texel_density(scene: &Scene, light: &InterpolatedField) -> f64 {
    let grids = scene.faces.iter().zip(&light.surface.face_grids);
    let mut wanted: Vec<(f64, f64)> = grids
        .filter_map(|(face, grid)| {
            let area = face.area();
            let side = (area / f64::from(texel_count(grid.size))).sqrt();
            (side > 0.0).then_some((PIXELS_PER_TEXEL / side, area))
        })
        .collect();
    weighted_percentile(&mut wanted, RESOLVED_AREA_SHARE).unwrap_or(1.0)
}

/// Chooses the lightmap's side so that its pixels are finer than the texels.
fn own_chart_side(charts: &UvCharts, light: &InterpolatedField) -> u32 {
    let grids = light.surface.face_grids.iter();
    let placed = charts.corners.iter().zip(grids);
    let mut wanted: Vec<(f64, f64)> = placed
        .filter_map(|(chart, grid)| {
            let [a, b, c, _] = (*chart)?;
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
    corners: [DVec2; 4],
}

impl PixelChart {
    fn new(face: u32, chart: [DVec2; 4], size: u32) -> Self {
        Self {
            face,
            corners: chart.map(|p| p * f64::from(size) - 0.5),
        }
    }

    /// Returns the chart's point nearest to `p`.
    fn nearest_point(&self, p: DVec2) -> DVec2 {
        let [a, b, c, d] = self.corners;
        let turn = (c - a).perp_dot(d - b).signum();
        let corners = distinct_corners(&self.corners);
        let edges = || corners.iter().zip(corners.iter().cycle().skip(1));
        if edges().all(|(from, to)| (to - from).perp_dot(p - from) * turn >= 0.0) {
            return p;
        }
        let on = edges().map(|(from, to)| {
            let along = (p - from).dot(to - from) / (to - from).length_squared();
            let along = if along.is_finite() { along } else { 0.0 };
            from.lerp(*to, along.clamp(0.0, 1.0))
        });
        let distance = |point: &DVec2| point.distance_squared(p);
        let nearest = on.min_by(|a, b| distance(a).total_cmp(&distance(b)));
        nearest.unwrap_or(p)
    }

    /// Returns radiosity and irradiance at a point of the chart.
    fn light_at(&self, p: DVec2, light: &InterpolatedField) -> [Vec3; 2] {
        let grid = &light.surface.face_grids[self.face as usize];
        let area = |[i, j, k]: [usize; 3]| {
            let at = self.corners;
            (at[j] - at[i]).perp_dot(at[k] - at[i]).abs()
        };
        // A quad may have a straight corner.
        let halves = [[0, 1, 2], [0, 2, 3]];
        let half = halves[usize::from(area(halves[1]) > area(halves[0]))];
        let [a, b, c] = half.map(|k| self.corners[k]);
        let place = DMat2::from_cols(b - a, c - a).inverse() * (p - a);
        let place = if place.is_finite() { place } else { DVec2::ZERO };
        let [a, b, c] = half.map(|k| grid.corners[k]);
        let point: DVec3 = a + (b - a) * place.x + (c - a) * place.y;
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
        // Light that fades towards the edge does not vanish beyond it.
        [0, 1].map(|k| (2.0 * at_edge[k] - within[k]).max(at_edge[k] / 2.0))
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
        let [a, b, c, d] = placed.corners;
        let last = DVec2::splat(f64::from(self.size - 1));
        let low = (a.min(b).min(c).min(d) - GUTTER_PIXELS).ceil().clamp(DVec2::ZERO, last);
        let high = (a.max(b).max(c).max(d) + GUTTER_PIXELS)
            .floor()
            .clamp(DVec2::ZERO, last);
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

    /// Evaluates the light at all assigned pixels, and repeats it at all others.
    fn render_lightmap(&self, charts: &UvCharts, light: &InterpolatedField) -> LightmapImage {
        let size = self.size as usize;
        let lit = self.pixels.par_iter().enumerate().map(|(k, pixel)| {
            let p = DVec2::new((k % size) as f64, (k / size) as f64);
            let owner = pixel.and_then(|(k, _)| Some((k, charts.corners[k as usize]?)));
            owner.map_or([Vec3::ZERO; 2], |(k, chart)| {
                PixelChart::new(k, chart, self.size).extrapolated_light(p, light)
            })
        });
        let mut image = LightmapImage {
            side: self.size,
            light: lit.collect(),
            covered: self
                .pixels
                .iter()
                .map(|p| p.is_some_and(|(_, off)| off == 0.0))
                .collect(),
        };
        image.fill_from_nearest(self.pixels.iter().map(Option::is_some).collect());
        image
    }
}

impl LightmapImage {
    /// Copies the light of the nearest `filled` pixel to each of the others, breadth first.
    fn fill_from_nearest(&mut self, mut filled: Vec<bool>) {
        let side = self.side as usize;
        let mut queue: VecDeque<usize> = (0..filled.len()).filter(|k| filled[*k]).collect();
        while let Some(k) = queue.pop_front() {
            let (x, y) = (k % side, k / side);
            let beside = [
                (x > 0).then(|| k - 1),
                (x + 1 < side).then(|| k + 1),
                (y > 0).then(|| k - side),
                (y + 1 < side).then(|| k + side),
            ];
            for other in beside.into_iter().flatten() {
                if !std::mem::replace(&mut filled[other], true) {
                    self.light[other] = self.light[k];
                    queue.push_back(other);
                }
            }
        }
    }
}
