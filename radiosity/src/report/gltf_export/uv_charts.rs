//! Charts of a scene's faces on a lightmap. Those of a scene file (TEXCOORD_1) are checked: inside the unit square, with
//! area, without overlap.

use crate::report::view::weld::DisjointSets;
use common::polygon::distinct_corners;
use common::scene::{Face, Scene};
use common::{Error, Result};
use glam::DVec2;
use std::collections::HashMap;

/// Overlaps thinner than this share of the unit square are ignored: 16-bit coordinates round by half as much.
const OVERLAP_TOLERANCE: f64 = 1.0 / 32768.0;

/// Faces below this share of the surface's area may lack area on the lightmap.
const MIN_AREA_SHARE: f64 = 1e-6;

/// Advice for charts that cannot hold light.
const UNWRAP_ADVICE: &str = "unwrap it again, as a lightmap, or leave --uv keep out";

/// Charts of a scene's faces; none for a face without area, or for a lamp that stands for a light without a surface.
pub struct UvCharts {
    /// Corners in the unit square, x to the right and y downwards; a triangle repeats its third.
    pub corners: Vec<Option<[DVec2; 4]>>,
    /// Island number per face: faces that share corners on the surface and in the chart have one number.
    pub islands: Vec<u32>,
}

impl UvCharts {
    /// Takes the file's own charts of `scene`.
    ///
    /// Errors: a chart leaves the unit square, has no area, or overlaps another.
    pub fn new(scene: &Scene) -> Result<Self> {
        let place = |face: &Face| {
            face.lightmap_corners
                .map(|[a, b, c]| [a, b, c, c].map(|p| p.as_dvec2()))
        };
        let places: Vec<_> = scene.faces.iter().map(place).collect();
        let charts = Self {
            islands: find_islands(scene),
            corners: places,
        };
        charts.check_charts(scene)?;
        Ok(charts)
    }

    fn check_charts(&self, scene: &Scene) -> Result<()> {
        let fail = |k: usize, message: String| {
            Err(Error::bad_input(
                &scene.name,
                scene.face_label(k),
                format!("{message}: {UNWRAP_ADVICE}"),
            ))
        };
        let all: f64 = scene.faces.iter().map(Face::area).sum();
        for (k, face) in scene.faces.iter().enumerate() {
            let Some(chart) = &self.corners[k] else {
                continue;
            };
            let inside = |p: &DVec2| p.clamp(DVec2::ZERO, DVec2::ONE).distance(*p) <= OVERLAP_TOLERANCE;
            if let Some(p) = chart.iter().find(|p| !inside(p)) {
                return fail(
                    k,
                    format!("reaches ({:.3}, {:.3}) in TEXCOORD_1, beyond the unit square", p.x, p.y),
                );
            }
            if doubled_area(chart) == 0.0 && face.area() > MIN_AREA_SHARE * all {
                return fail(k, "has no area in TEXCOORD_1".into());
            }
        }
        let placed = self.corners.iter().enumerate();
        let placed: Vec<_> = placed.filter_map(|(k, chart)| Some((k, (*chart)?))).collect();
        if let Some([a, b]) = find_overlap(&placed) {
            let message = format!(
                "lies on {} in TEXCOORD_1, and light has one place only",
                scene.face_label(a)
            );
            return fail(b, message);
        }
        Ok(())
    }
}

/// Returns two overlapping outlines within the unit square, if any: a sweep along x within rows.
pub fn find_overlap(outlines: &[(usize, [DVec2; 4])]) -> Option<[usize; 2]> {
    let mut charts = outlines.to_vec();
    charts.sort_by(|a, b| low_corner(&a.1).x.total_cmp(&low_corner(&b.1).x));
    let count = (charts.len() as f64).sqrt().clamp(1.0, 1024.0);
    let row = |y: f64| (y.clamp(0.0, 1.0) * (count - 1.0)) as usize;
    let mut rows: Vec<Vec<(usize, [DVec2; 4])>> = vec![Vec::new(); count as usize];
    for (k, chart) in charts {
        let reached = row(low_corner(&chart).y)..=row(high_corner(&chart).y);
        for active in &mut rows[reached] {
            active.retain(|(_, other)| high_corner(other).x > low_corner(&chart).x);
            if let Some((other, _)) = active.iter().find(|(_, other)| outlines_overlap(other, &chart)) {
                return Some([k.min(*other), k.max(*other)]);
            }
            active.push((k, chart));
        }
    }
    None
}

fn low_corner([a, b, c, d]: &[DVec2; 4]) -> DVec2 {
    a.min(*b).min(*c).min(*d)
}

fn high_corner([a, b, c, d]: &[DVec2; 4]) -> DVec2 {
    a.max(*b).max(*c).max(*d)
}

/// Returns twice the area of an outline.
fn doubled_area([a, b, c, d]: &[DVec2; 4]) -> f64 {
    (*c - *a).perp_dot(*d - *b).abs()
}

/// Returns whether two convex outlines overlap: no edge is a separating axis.
fn outlines_overlap(a: &[DVec2; 4], b: &[DVec2; 4]) -> bool {
    let extent = |of: &[DVec2; 4], axis: DVec2| {
        let along = of.map(|p| p.dot(axis));
        let least = along.into_iter().fold(f64::INFINITY, f64::min);
        [least, along.into_iter().fold(f64::NEG_INFINITY, f64::max)]
    };
    let deep = |from: DVec2, to: DVec2| {
        let axis = (to - from).perp().normalize_or_zero();
        let ([low, high], [other_low, other_high]) = (extent(a, axis), extent(b, axis));
        high.min(other_high) - low.max(other_low) > OVERLAP_TOLERANCE
    };
    [a, b].into_iter().map(distinct_corners).all(|of| {
        let next = of.iter().cycle().skip(1);
        of.iter().zip(next).all(|(from, to)| deep(*from, *to))
    })
}

/// Bits of a surface corner and of its chart corner.
type Corner = ([u64; 3], [u32; 2]);

/// Numbers the islands of connected charts by union–find; the lowest face names an island.
fn find_islands(scene: &Scene) -> Vec<u32> {
    let count = scene.faces.len() as u32;
    let mut islands = DisjointSets((0..count).collect());
    let mut first: HashMap<Corner, u32> = HashMap::new();
    for (k, face) in (0..).zip(&scene.faces) {
        for (p, place) in face.corners.iter().zip(face.lightmap_corners.iter().flatten()) {
            let corner = (p.to_array().map(f64::to_bits), place.to_array().map(f32::to_bits));
            islands.join_sets(k, *first.entry(corner).or_insert(k));
        }
    }
    (0..count).map(|k| islands.find_root(k)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DVec3, Vec2, Vec3};

    /// Builds a scene of separate triangles with the given charts.
    fn charted_scene(charts: &[[[f32; 2]; 3]]) -> Scene {
        let triangle = |(k, chart): (usize, &[[f32; 2]; 3])| {
            let x = DVec3::X * (2 * k) as f64;
            let corners = [x, x + DVec3::X, x + DVec3::Y];
            Face {
                lightmap_corners: Some(chart.map(Vec2::from)),
                ..Face::triangle("t", corners, Vec3::ZERO, Vec3::ONE)
            }
        };
        Scene {
            name: "s.glb".into(),
            faces: charts.iter().enumerate().map(triangle).collect(),
            ..Scene::default()
        }
    }

    fn refusal_message(charts: &[[[f32; 2]; 3]]) -> String {
        let refused = UvCharts::new(&charted_scene(charts)).err();
        refused.map_or(String::new(), |error| error.to_string())
    }

    const LOWER_TRIANGLE: [[f32; 2]; 3] = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
    const UPPER_TRIANGLE: [[f32; 2]; 3] = [[1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];

    #[test]
    fn touching_charts_do_not_overlap() {
        assert_eq!(refusal_message(&[LOWER_TRIANGLE, UPPER_TRIANGLE]), "");
        // A corner on another chart's edge, rounded to 16 bits.
        let off = 1.0 / 65535.0;
        let along = [[0.5 - off, 0.5 - off], [1.0, 0.0], [1.0, 0.5]];
        assert_eq!(refusal_message(&[LOWER_TRIANGLE, along]), "");
    }

    #[test]
    fn unusable_charts_are_refused() {
        let cases = [
            (vec![LOWER_TRIANGLE, LOWER_TRIANGLE], "face 2 (t): lies on face 1 (t)"),
            (
                vec![UPPER_TRIANGLE, LOWER_TRIANGLE, [[0.4, 0.4], [0.9, 0.4], [0.4, 0.9]]],
                "lies on",
            ),
            // One inside the other, and two that cross without a common corner.
            (vec![LOWER_TRIANGLE, [[0.1, 0.1], [0.2, 0.1], [0.1, 0.2]]], "lies on"),
            (
                vec![
                    [[0.4, 0.0], [0.6, 0.0], [0.5, 1.0]],
                    [[0.0, 0.4], [1.0, 0.4], [0.0, 0.6]],
                ],
                "lies on",
            ),
            (vec![[[0.0, 0.0], [1.1, 0.0], [0.0, 1.0]]], "reaches (1.100, 0.000)"),
            (vec![[[0.0, 0.0], [f32::NAN, 0.0], [0.0, 1.0]]], "reaches"),
            (vec![LOWER_TRIANGLE, [[1.0, 1.0]; 3]], "face 2 (t): has no area"),
        ];
        for (charts, expected) in cases {
            let refused = refusal_message(&charts);
            assert!(
                refused.contains(expected) && refused.contains("s.glb"),
                "{refused} {expected}"
            );
        }
    }

    #[test]
    fn faces_sharing_corners_on_surface_and_chart_are_one_island() {
        let mut scene = charted_scene(&[LOWER_TRIANGLE, UPPER_TRIANGLE, [[0.0; 2]; 3]]);
        scene.faces.pop();
        let apart = find_islands(&scene);
        assert_eq!(apart, [0, 1]);
        // The second triangle where it continues the first.
        let [a, b, c] = [DVec3::ZERO, DVec3::X, DVec3::Y];
        scene.faces[1].corners = [b, b + c, c, c];
        assert_eq!(find_islands(&scene), [0, 0]);
        scene.faces[1].corners = [b + a, b + c, c, c].map(|p| p + DVec3::Z);
        assert_eq!(find_islands(&scene), [0, 1]);
    }
}
