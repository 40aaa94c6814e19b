//! A file's own charts: where its triangles lie on a lightmap, if light can be laid there.

use common::scene::{Face, Scene};
use common::{Error, Result};
use glam::DVec2;
use std::collections::HashMap;

/// Overlaps that are thinner than this share of the square are none: a file's 16 bits round by half as much.
const SAME: f64 = 1.0 / 32768.0;

/// Of the surface's area: who has less of it and no place on the lightmap is not seen.
const UNSEEN: f64 = 1e-6;

/// What to do where light cannot be laid.
const UNWRAP: &str = "unwrap it again, as a lightmap, or leave --uv keep out";

/// The charts of a scene's faces; none of a lamp that stands for a light without a surface.
pub struct Charts {
    /// Their corners, the unit square being the picture: right and downwards.
    pub places: Vec<Option<[DVec2; 3]>>,
    /// Faces that share corners, on the surface and on the picture, have one number.
    pub islands: Vec<u32>,
}

impl Charts {
    /// Those of `scene`.
    ///
    /// Errors: a chart that leaves the unit square, that has no area, or that lies on another.
    pub fn new(scene: &Scene) -> Result<Self> {
        let place = |face: &Face| face.chart.map(|chart| chart.map(|p| p.as_dvec2()));
        let places: Vec<_> = scene.faces.iter().map(place).collect();
        let charts = Self {
            islands: islands(scene),
            places,
        };
        charts.check(scene)?;
        Ok(charts)
    }

    fn check(&self, scene: &Scene) -> Result<()> {
        let name = |k: usize| format!("face {} ({})", k + 1, scene.faces[k].name);
        let fail = |k: usize, message: String| {
            Err(Error::input(
                &scene.name,
                name(k),
                format!("{message}: {UNWRAP}"),
            ))
        };
        let all: f64 = scene.faces.iter().map(Face::area).sum();
        for (k, face) in scene.faces.iter().enumerate() {
            let Some(chart) = &self.places[k] else {
                continue;
            };
            let inside = |p: &DVec2| p.clamp(DVec2::ZERO, DVec2::ONE).distance(*p) <= SAME;
            if let Some(p) = chart.iter().find(|p| !inside(p)) {
                return fail(
                    k,
                    format!(
                        "reaches ({:.3}, {:.3}) in TEXCOORD_1, beyond the unit square",
                        p.x, p.y
                    ),
                );
            }
            if area(chart) == 0.0 && face.area() > UNSEEN * all {
                return fail(k, "has no area in TEXCOORD_1".into());
            }
        }
        if let Some([a, b]) = self.overlap() {
            let message = format!(
                "lies on {} in TEXCOORD_1, and light has one place only",
                name(a)
            );
            return fail(b, message);
        }
        Ok(())
    }

    /// Two charts that lie on each other. In rows, so that each of many is compared with few.
    fn overlap(&self) -> Option<[usize; 2]> {
        let placed = self.places.iter().enumerate();
        let placed = placed.filter_map(|(k, chart)| Some((k, (*chart)?)));
        let mut charts: Vec<(usize, [DVec2; 3])> = placed.collect();
        charts.sort_by(|a, b| low(&a.1).x.total_cmp(&low(&b.1).x));
        let count = (charts.len() as f64).sqrt().clamp(1.0, 1024.0);
        let row = |y: f64| (y.clamp(0.0, 1.0) * (count - 1.0)) as usize;
        let mut rows: Vec<Vec<(usize, [DVec2; 3])>> = vec![Vec::new(); count as usize];
        for (k, chart) in charts {
            let reached = row(low(&chart).y)..=row(high(&chart).y);
            for active in &mut rows[reached] {
                active.retain(|(_, other)| high(other).x > low(&chart).x);
                if let Some((other, _)) = active.iter().find(|(_, other)| overlap(other, &chart)) {
                    return Some([k.min(*other), k.max(*other)]);
                }
                active.push((k, chart));
            }
        }
        None
    }
}

fn low(chart: &[DVec2; 3]) -> DVec2 {
    chart[0].min(chart[1]).min(chart[2])
}

fn high(chart: &[DVec2; 3]) -> DVec2 {
    chart[0].max(chart[1]).max(chart[2])
}

/// Twice its area.
fn area([a, b, c]: &[DVec2; 3]) -> f64 {
    (*b - *a).perp_dot(*c - *a).abs()
}

/// Whether no line along an edge parts two triangles.
fn overlap(a: &[DVec2; 3], b: &[DVec2; 3]) -> bool {
    let extent = |of: &[DVec2; 3], axis: DVec2| {
        let along = of.map(|p| p.dot(axis));
        let [x, y, z] = along;
        [x.min(y).min(z), x.max(y).max(z)]
    };
    let deep = |from: DVec2, to: DVec2| {
        let axis = (to - from).perp().normalize_or_zero();
        let ([low, high], [other_low, other_high]) = (extent(a, axis), extent(b, axis));
        high.min(other_high) - low.max(other_low) > SAME
    };
    [a, b]
        .into_iter()
        .all(|of| (0..3).all(|k| deep(of[k], of[(k + 1) % 3])))
}

/// A corner of the surface, at its place on the picture.
type Corner = ([u64; 3], [u32; 2]);

fn islands(scene: &Scene) -> Vec<u32> {
    let mut island: Vec<u32> = (0..scene.faces.len() as u32).collect();
    let mut first: HashMap<Corner, u32> = HashMap::new();
    for (k, face) in (0..).zip(&scene.faces) {
        for (p, place) in face.corners.iter().zip(face.chart.iter().flatten()) {
            let corner = (
                p.to_array().map(f64::to_bits),
                place.to_array().map(f32::to_bits),
            );
            let other = *first.entry(corner).or_insert(k);
            let [a, b] = [root(&mut island, k), root(&mut island, other)];
            island[a.max(b) as usize] = a.min(b);
        }
    }
    for k in 0..island.len() as u32 {
        island[k as usize] = root(&mut island, k);
    }
    island
}

fn root(island: &mut [u32], mut k: u32) -> u32 {
    while island[k as usize] != k {
        island[k as usize] = island[island[k as usize] as usize];
        k = island[k as usize];
    }
    k
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DVec3, Vec2, Vec3};

    /// Triangles side by side on the surface, with these charts.
    fn scene(charts: &[[[f32; 2]; 3]]) -> Scene {
        let triangle = |(k, chart): (usize, &[[f32; 2]; 3])| {
            let x = DVec3::X * (2 * k) as f64;
            let corners = [x, x + DVec3::X, x + DVec3::Y];
            Face {
                chart: Some(chart.map(Vec2::from)),
                ..Face::triangle("t", corners, Vec3::ZERO, Vec3::ONE)
            }
        };
        Scene {
            name: "s.glb".into(),
            faces: charts.iter().enumerate().map(triangle).collect(),
            ..Scene::default()
        }
    }

    fn refusal(charts: &[[[f32; 2]; 3]]) -> String {
        let refused = Charts::new(&scene(charts)).err();
        refused.map_or(String::new(), |error| error.to_string())
    }

    const LOWER: [[f32; 2]; 3] = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
    const UPPER: [[f32; 2]; 3] = [[1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];

    #[test]
    fn charts_that_touch_are_apart() {
        assert_eq!(refusal(&[LOWER, UPPER]), "");
        // A corner on another's edge, as rounded to 16 bits.
        let off = 1.0 / 65535.0;
        let along = [[0.5 - off, 0.5 - off], [1.0, 0.0], [1.0, 0.5]];
        assert_eq!(refusal(&[LOWER, along]), "");
    }

    #[test]
    fn light_without_a_place_of_its_own_is_refused() {
        let cases = [
            (vec![LOWER, LOWER], "face 2 (t): lies on face 1 (t)"),
            (
                vec![UPPER, LOWER, [[0.4, 0.4], [0.9, 0.4], [0.4, 0.9]]],
                "lies on",
            ),
            // One within the other, and two that cross without a corner in common.
            (vec![LOWER, [[0.1, 0.1], [0.2, 0.1], [0.1, 0.2]]], "lies on"),
            (
                vec![
                    [[0.4, 0.0], [0.6, 0.0], [0.5, 1.0]],
                    [[0.0, 0.4], [1.0, 0.4], [0.0, 0.6]],
                ],
                "lies on",
            ),
            (
                vec![[[0.0, 0.0], [1.1, 0.0], [0.0, 1.0]]],
                "reaches (1.100, 0.000)",
            ),
            (vec![[[0.0, 0.0], [f32::NAN, 0.0], [0.0, 1.0]]], "reaches"),
            (vec![LOWER, [[1.0, 1.0]; 3]], "face 2 (t): has no area"),
        ];
        for (charts, told) in cases {
            let refused = refusal(&charts);
            assert!(
                refused.contains(told) && refused.contains("s.glb"),
                "{refused} {told}"
            );
        }
    }

    #[test]
    fn what_shares_corners_on_both_is_one_island() {
        let mut scene = scene(&[LOWER, UPPER, [[0.0; 2]; 3]]);
        scene.faces.pop();
        let apart = islands(&scene);
        assert_eq!(apart, [0, 1]);
        // The second triangle where it continues the first.
        let [a, b, c] = [DVec3::ZERO, DVec3::X, DVec3::Y];
        scene.faces[1].corners = [b, b + c, c, c];
        assert_eq!(islands(&scene), [0, 0]);
        scene.faces[1].corners = [b + a, b + c, c, c].map(|p| p + DVec3::Z);
        assert_eq!(islands(&scene), [0, 1]);
    }
}
