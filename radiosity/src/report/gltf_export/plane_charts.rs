//! Divides a scene's faces into charts: connected faces that are coplanar or form a smooth surface, projected onto the
//! plane of the largest.

use super::uv_charts::find_overlap;
use crate::report::view::weld::MIN_COPLANAR_COSINE;
use common::polygon::distinct_corners;
use common::scene::{Face, Scene};
use glam::{DVec2, DVec3};
use std::collections::{HashMap, HashSet, VecDeque};

/// Minimum cosine between the normals of a chart's faces and its plane's: the projection shortens by at most this.
const MIN_CHART_COSINE: f64 = 0.7;
/// Minimum cosine between the normals of smooth neighbours that have no normals at their corners.
const MIN_SMOOTH_COSINE: f64 = 0.9;
/// Number of a chart's longest edges along which it may be laid.
const MAX_LAID_EDGES: usize = 24;
/// Overlaps are looked for whenever the number of a chart's faces has doubled, from this on.
const FIRST_CHECKED_FACES: usize = 16;

/// Connected faces and their projection.
pub struct PlaneChart {
    /// Faces of the scene.
    pub faces: Vec<u32>,
    /// Width and height of the projection, scene units; the width is not the smaller one.
    pub extent: DVec2,
    axes: [DVec3; 2],
    low: DVec2,
}

impl PlaneChart {
    /// Projects onto the plane of the first face, in any direction within it.
    fn on_first_plane(scene: &Scene, faces: Vec<u32>) -> Self {
        let normal = unit_normal(&scene.faces[faces[0] as usize]);
        let u = normal.any_orthonormal_vector();
        Self {
            faces,
            extent: DVec2::ZERO,
            axes: [u, normal.cross(u)],
            low: DVec2::ZERO,
        }
    }

    /// Lays the chart so that its bounding rectangle is small.
    fn new(scene: &Scene, faces: Vec<u32>) -> Self {
        let mut chart = Self::on_first_plane(scene, faces);
        let outlines: Vec<[DVec2; 4]> = chart.project_faces(scene).collect();
        let edges = outlines.iter().flat_map(|corners| {
            let corners = distinct_corners(corners);
            let next = corners.iter().cycle().skip(1);
            corners.iter().zip(next).map(|(a, b)| *b - *a)
        });
        let mut edges: Vec<DVec2> = edges.collect();
        edges.sort_by(|a, b| b.length_squared().total_cmp(&a.length_squared()));
        edges.truncate(MAX_LAID_EDGES);
        let points: HashSet<[u64; 2]> = outlines
            .as_flattened()
            .iter()
            .map(|p| p.to_array().map(f64::to_bits))
            .collect();
        let bounds = |way: DVec2| {
            let turned = points.iter().map(|p| {
                let p = DVec2::from(p.map(f64::from_bits));
                DVec2::new(p.dot(way), p.dot(way.perp()))
            });
            let none = [DVec2::INFINITY, DVec2::NEG_INFINITY];
            let [low, high] = turned.fold(none, |[low, high], p| [low.min(p), high.max(p)]);
            (way, low, high - low)
        };
        let ways = edges.iter().filter_map(|edge| edge.try_normalize());
        let laid = ways
            .map(bounds)
            .min_by(|a, b| a.2.element_product().total_cmp(&b.2.element_product()));
        let (mut way, mut low, mut extent) = laid.unwrap_or_else(|| bounds(DVec2::X));
        if extent.x < extent.y {
            (way, low, extent) = (
                way.perp(),
                DVec2::new(low.y, -low.x - extent.x),
                DVec2::new(extent.y, extent.x),
            );
        }
        let [x, y] = chart.axes;
        chart.axes = [way, way.perp()].map(|w| x * w.x + y * w.y);
        (chart.low, chart.extent) = (low, extent);
        chart
    }

    /// Returns the place of a point on the chart, from 0 to the extent.
    pub fn project_point(&self, p: DVec3) -> DVec2 {
        DVec2::from(self.axes.map(|axis| p.dot(axis))) - self.low
    }

    fn project_faces<'a>(&'a self, scene: &'a Scene) -> impl Iterator<Item = [DVec2; 4]> + 'a {
        let corners = |k: &u32| scene.faces[*k as usize].corners.map(|p| self.project_point(p));
        self.faces.iter().map(corners)
    }

    /// Keeps the faces before the first that overlaps one of them; returns whether that are all.
    fn drop_overlaps(&mut self, scene: &Scene) -> bool {
        let before = self.faces.len();
        let low = self.project_faces(scene).flatten().fold(DVec2::INFINITY, DVec2::min);
        let high = self
            .project_faces(scene)
            .flatten()
            .fold(DVec2::NEG_INFINITY, DVec2::max);
        let size = (high - low).max_element().max(f64::MIN_POSITIVE);
        let places = self
            .project_faces(scene)
            .map(|corners| corners.map(|p| (p - low) / size));
        let mut places: Vec<(usize, [DVec2; 4])> = places.enumerate().collect();
        while let Some([a, b]) = find_overlap(&places) {
            places.truncate(a.max(b));
        }
        self.faces.truncate(places.len());
        self.faces.len() == before
    }
}

fn unit_normal(face: &Face) -> DVec3 {
    face.vector_area().normalize_or_zero()
}

/// Divides all faces with an area into charts.
pub fn divide_scene(scene: &Scene) -> Vec<PlaneChart> {
    let edges = SharedEdges::new(scene);
    let mut order: Vec<u32> = (0..scene.faces.len() as u32).collect();
    let area = |k: &u32| scene.faces[*k as usize].area();
    order.sort_by(|a, b| area(b).total_cmp(&area(a)));
    let mut taken: Vec<bool> = scene.faces.iter().map(|f| unit_normal(f) == DVec3::ZERO).collect();
    let mut charts = Vec::new();
    for seed in order {
        if !taken[seed as usize] {
            let chart = grow_chart(scene, &edges, seed, &mut taken);
            charts.push(PlaneChart::new(scene, chart.faces));
        }
    }
    charts
}

/// Grows a chart from a face, breadth first, and marks its faces as `taken`.
fn grow_chart(scene: &Scene, edges: &SharedEdges, seed: u32, taken: &mut [bool]) -> PlaneChart {
    let normal = unit_normal(&scene.faces[seed as usize]);
    let mut chart = PlaneChart::on_first_plane(scene, vec![seed]);
    let mut queue = VecDeque::from([seed]);
    let mut reached = vec![seed];
    taken[seed as usize] = true;
    let mut checked = FIRST_CHECKED_FACES;
    let mut is_whole = true;
    while let Some(face) = queue.pop_front().filter(|_| is_whole) {
        for other in edges.neighbours_of(scene, face) {
            let turned = unit_normal(&scene.faces[other as usize]).dot(normal);
            if !taken[other as usize] && turned >= MIN_CHART_COSINE {
                taken[other as usize] = true;
                reached.push(other);
                chart.faces.push(other);
                queue.push_back(other);
            }
        }
        if chart.faces.len() >= checked {
            checked = 2 * chart.faces.len();
            is_whole = chart.drop_overlaps(scene);
        }
    }
    chart.drop_overlaps(scene);
    for face in &reached {
        taken[*face as usize] = false;
    }
    for face in &chart.faces {
        taken[*face as usize] = true;
    }
    chart
}

/// Edges of all faces by their ends, to find the faces beside an edge.
struct SharedEdges {
    /// Corner numbers of each face; corners at one position have one number.
    corners: Vec<[u32; 4]>,
    /// Ends of an edge, face, and number of the edge within it, sorted.
    edges: Vec<([u32; 2], u32, u8)>,
}

impl SharedEdges {
    fn new(scene: &Scene) -> Self {
        let mut numbers: HashMap<[u64; 3], u32> = HashMap::new();
        let mut number = |p: &DVec3| {
            let next = numbers.len() as u32;
            // −0 and 0 are one position.
            *numbers.entry((*p + 0.0).to_array().map(f64::to_bits)).or_insert(next)
        };
        let corners: Vec<[u32; 4]> = scene
            .faces
            .iter()
            .map(|f| f.corners.each_ref().map(&mut number))
            .collect();
        let mut edges = Vec::new();
        for (k, face) in (0..).zip(&scene.faces) {
            let count = face.outline().len();
            let own = corners[k as usize];
            edges.extend((0..count).map(|i| ([own[i], own[(i + 1) % count]], k, i as u8)));
        }
        edges.sort_unstable();
        Self { corners, edges }
    }

    /// Returns the faces that continue a face across one of its edges.
    fn neighbours_of(&self, scene: &Scene, k: u32) -> Vec<u32> {
        let (face, own) = (&scene.faces[k as usize], self.corners[k as usize]);
        let count = face.outline().len();
        let mut found = Vec::new();
        for i in 0..count {
            let j = (i + 1) % count;
            let ends = [own[j], own[i]];
            let first = self.edges.partition_point(|(edge, ..)| *edge < ends);
            for (_, other, at) in self.edges[first..].iter().take_while(|(edge, ..)| *edge == ends) {
                let beside = &scene.faces[*other as usize];
                let from = usize::from(*at);
                let to = (from + 1) % beside.outline().len();
                if is_continued((face, [i, j]), (beside, [to, from])) {
                    found.push(*other);
                }
            }
        }
        found
    }
}

/// Returns whether two faces are coplanar or smooth across an edge, given by its two corners in each of them.
fn is_continued((a, at_a): (&Face, [usize; 2]), (b, at_b): (&Face, [usize; 2])) -> bool {
    let cosine = unit_normal(a).dot(unit_normal(b));
    let is_smooth = || match (&a.corner_normals, &b.corner_normals) {
        (Some(a), Some(b)) => (0..2).all(|k| a[at_a[k]] == b[at_b[k]]),
        (None, None) => cosine >= MIN_SMOOTH_COSINE,
        _ => false,
    };
    cosine >= MIN_COPLANAR_COSINE || (cosine > 0.0 && is_smooth())
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    fn scene_of(faces: &[[DVec3; 4]]) -> Scene {
        let quad = |corners: &[DVec3; 4]| Face::quad("q", *corners, Vec3::ZERO, Vec3::ONE);
        Scene {
            faces: faces.iter().map(quad).collect(),
            ..Scene::default()
        }
    }

    /// Returns a quad of a strip between two angles on a circle about z, 1 high.
    fn strip_quad(from: f64, to: f64, low: f64) -> [DVec3; 4] {
        let p = |angle: f64, z: f64| DVec3::new(angle.cos(), angle.sin(), z);
        [p(from, low), p(to, low), p(to, low + 1.0), p(from, low + 1.0)]
    }

    #[test]
    fn coplanar_and_smooth_neighbours_share_charts_and_creases_divide_them() {
        let p = DVec3::new;
        let floor = |x: f64| [p(x, 0., 0.), p(x + 1., 0., 0.), p(x + 1., 1., 0.), p(x, 1., 0.)];
        let wall = [p(0., 0., 0.), p(0., 0., 1.), p(1., 0., 1.), p(1., 0., 0.)];
        let charts = divide_scene(&scene_of(&[floor(0.), floor(1.), floor(2.), wall, floor(4.)]));
        let sizes: Vec<usize> = charts.iter().map(|chart| chart.faces.len()).collect();
        assert_eq!(sizes.iter().sum::<usize>(), 5);
        assert_eq!(sizes.iter().max(), Some(&3));
        assert_eq!(charts.len(), 3);
        let step = std::f64::consts::TAU / 36.0;
        let round: Vec<_> = (0..36)
            .map(|k| strip_quad(f64::from(k) * step, f64::from(k + 1) * step, 0.0))
            .collect();
        let charts = divide_scene(&scene_of(&round));
        // A chart turns by 45° to both sides.
        assert!((4..=6).contains(&charts.len()), "{}", charts.len());
    }

    #[test]
    fn faces_that_overlap_in_the_projection_are_in_several_charts() {
        let p = DVec3::new;
        let floor = [p(0., 0., 0.), p(1., 0., 0.), p(1., 1., 0.), p(0., 1., 0.)];
        let beside = [p(1., 0., 0.), p(2., 0., 0.), p(2., 1., 0.), p(1., 1., 0.)];
        let charts = divide_scene(&scene_of(&[floor, beside, beside]));
        assert_eq!(charts.len(), 2);
        // A strip of a coil, whose turns lie above each other.
        let coil: Vec<_> = (0..48)
            .map(|k| {
                let p = |k: i32, r: f64| {
                    let angle = f64::from(k) * std::f64::consts::TAU / 16.0;
                    DVec3::new(r * angle.cos(), r * angle.sin(), 0.01 * f64::from(k))
                };
                [p(k, 1.0), p(k, 2.0), p(k + 1, 2.0), p(k + 1, 1.0)]
            })
            .collect();
        let scene = scene_of(&coil);
        let charts = divide_scene(&scene);
        assert!((3..=6).contains(&charts.len()), "{}", charts.len());
        for chart in &charts {
            let places: Vec<_> = chart
                .project_faces(&scene)
                .map(|c| c.map(|p| p / 4.0))
                .enumerate()
                .collect();
            assert_eq!(find_overlap(&places), None);
        }
    }

    #[test]
    fn charts_are_laid_along_their_edges_and_not_mirrored() {
        let turn = |x: f64, y: f64| DVec3::new(0.8 * x - 0.6 * y, 0.6 * x + 0.8 * y, 2.0);
        let corners = [turn(0., 0.), turn(1., 0.), turn(1., 3.), turn(0., 3.)];
        let scene = scene_of(&[corners]);
        let chart = &divide_scene(&scene)[0];
        assert!(
            chart.extent.abs_diff_eq(DVec2::new(3.0, 1.0), 1e-12),
            "{}",
            chart.extent
        );
        let places = corners.map(|p| chart.project_point(p));
        for p in places {
            assert!(p.clamp(DVec2::ZERO, chart.extent).abs_diff_eq(p, 1e-12), "{p}");
        }
        assert!((places[1] - places[0]).perp_dot(places[2] - places[0]) > 0.0);
    }
}
