//! Packs charts into a square lightmap.
//!
//! The pixels of two charts lie [`CHART_GAP_PIXELS`] apart, and the light of a chart continues into its half of the gap:
//! bilinear sampling of the picture and of its next two mip levels reads no other chart.

use super::lightmap_image::LIGHTMAP_SIDE_RANGE;
use super::plane_charts::{PlaneChart, divide_scene};
use super::uv_charts::UvCharts;
use common::scene::Scene;
use common::{Error, Result};
use glam::DVec2;
use guillotiere::{Rectangle, SimpleAtlasAllocator, size2};

/// Pixels between two charts: a pixel of the second mip level covers four.
const CHART_GAP_PIXELS: u32 = 4;
/// Pixels per side of a lightmap, about, below which gaps would take much of it.
const MIN_PACKED_SIDE: u32 = 256;
/// Share of the lightmap that a first attempt fills.
const FIRST_FILL_SHARE: f64 = 0.96;
/// Growth of the lightmap's side from attempt to attempt.
const SIDE_GROWTH: f64 = 1.02;
/// Part of the pixels per length that is kept when the charts do not fit.
const DENSITY_DECAY: f64 = 0.9;

/// Pixels per length at which all charts are as small as can be, as a share of those of the smallest lightmap.
const MIN_DENSITY_SHARE: f64 = 1e-3;

/// Charts of a scene, placed on a lightmap.
pub struct PackedCharts {
    /// Charts.
    pub charts: UvCharts,
    /// Pixels per side of the lightmap.
    pub side: u32,
    /// Pixels per unit of length.
    pub density: f64,
}

/// Divides a scene into charts and packs them with the `asked` pixels per unit of length, else with `enough` of them
/// or as many as a small lightmap holds. If the largest lightmap does not hold them, they are fewer.
///
/// Errors: the charts are too many for one lightmap.
pub fn pack_scene(scene: &Scene, asked: Option<f64>, enough: f64) -> Result<PackedCharts> {
    let charts = divide_scene(scene);
    let [_, most] = LIGHTMAP_SIDE_RANGE;
    let total: f64 = charts.iter().map(|chart| chart.extent.element_product()).sum();
    let [least, largest] = [MIN_PACKED_SIDE, most].map(|side| f64::from(side) / total.sqrt().max(f64::MIN_POSITIVE));
    let mut density = asked.unwrap_or(enough.max(least)).min(largest);
    loop {
        if let Some((places, side)) = pack_charts(&charts, density) {
            return Ok(PackedCharts {
                charts: place_faces(scene, &charts, &places, side, density),
                side,
                density,
            });
        }
        density *= DENSITY_DECAY;
        // Charts do not become smaller than two pixels.
        if density < least * MIN_DENSITY_SHARE {
            let message = format!(
                "the scene has {} parts, too many for a lightmap of {most}×{most} pixels: join its vertices, or make it smaller",
                charts.len()
            );
            return Err(Error::bad_input(&scene.name, "", message));
        }
    }
}

/// Returns the intervals between the pixels of a chart. What is longer than the largest lightmap is as long as it: with its
/// gap it does not fit.
fn chart_intervals(chart: &PlaneChart, density: f64) -> [u32; 2] {
    let [_, most] = LIGHTMAP_SIDE_RANGE;
    // A side of whole pixels may be longer by rounding.
    (chart.extent * density - 1e-6)
        .ceil()
        .clamp(DVec2::ONE, DVec2::splat(f64::from(most)))
        .as_uvec2()
        .to_array()
}

/// Packs charts, the highest or the largest first, into the smallest square that is found; none if the largest square is
/// too small.
fn pack_charts(charts: &[PlaneChart], density: f64) -> Option<(Vec<Rectangle>, u32)> {
    let [_, most] = LIGHTMAP_SIDE_RANGE;
    let boxes: Vec<[u32; 2]> = charts
        .iter()
        .map(|chart| chart_intervals(chart, density).map(|n| n + 1 + CHART_GAP_PIXELS))
        .collect();
    let order: Vec<usize> = (0..charts.len()).collect();
    let mut orders = [order.clone(), order];
    orders[0].sort_by_key(|k| std::cmp::Reverse([boxes[*k][1], boxes[*k][0]]));
    orders[1].sort_by_key(|k| std::cmp::Reverse(boxes[*k].iter().product::<u32>()));
    let area: f64 = boxes.iter().map(|[w, h]| f64::from(*w) * f64::from(*h)).sum();
    let longest = boxes.iter().map(|[w, _]| *w).max()?;
    let mut side = ((area / FIRST_FILL_SHARE).sqrt().ceil() as u32)
        .max(longest)
        .next_multiple_of(4);
    while side <= most {
        for order in &orders {
            let mut atlas = SimpleAtlasAllocator::new(size2(side as i32, side as i32));
            let mut places = vec![Rectangle::zero(); charts.len()];
            let fits = order.iter().all(|k| {
                let [w, h] = boxes[*k].map(|n| n as i32);
                let place = atlas.allocate(size2(w, h));
                places[*k] = place.unwrap_or_default();
                place.is_some()
            });
            if fits {
                return Some((places, side));
            }
        }
        side = ((f64::from(side) * SIDE_GROWTH) as u32 + 1).next_multiple_of(4);
    }
    None
}

/// Places the corners of all faces; a chart's outermost corners lie on pixel centres.
fn place_faces(scene: &Scene, charts: &[PlaneChart], places: &[Rectangle], side: u32, density: f64) -> UvCharts {
    let mut placed = UvCharts {
        corners: vec![None; scene.faces.len()],
        islands: vec![0; scene.faces.len()],
    };
    for (island, (chart, place)) in (0..).zip(charts.iter().zip(places)) {
        let intervals = DVec2::from(chart_intervals(chart, density).map(f64::from));
        let scale = intervals / chart.extent.max(DVec2::splat(f64::MIN_POSITIVE));
        let half = f64::from(CHART_GAP_PIXELS) / 2.0 + 0.5;
        let first = DVec2::new(f64::from(place.min.x), f64::from(place.min.y)) + half;
        for face in &chart.faces {
            let corners = scene.faces[*face as usize].corners;
            let at = |p| (first + (chart.project_point(p) * scale).min(intervals)) / f64::from(side);
            placed.corners[*face as usize] = Some(corners.map(at));
            placed.islands[*face as usize] = island;
        }
    }
    placed
}
