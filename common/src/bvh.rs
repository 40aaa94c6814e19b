//! Bounding volume hierarchy over the faces, which the CPU and the GPU traverse.

use crate::constants::OUTLINE_MARGIN;
use crate::mesh::{Mesh, MeshFace};
use glam::{Vec3, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::bvh2_to_cwbvh::bvh2_to_cwbvh;
use obvhs::ploc::PlocBuilder;
use obvhs::splits::split_aabbs_precise;
use obvhs::triangle::Triangle;

/// Boxes of triangles are split where they are larger than this multiple of the mean area of a face.
const SPLIT_AREA: f32 = 4.0;
/// Boxes are split where that divides their surface by more than this: those of thin triangles, not of others.
const SPLIT_GAIN: f32 = 1.8;
/// Rounds of splitting, each of which may double the number of boxes.
const SPLIT_ROUNDS: u32 = 3;
/// Places at which a split is tried.
const SPLIT_PLACES: u32 = 12;

/// A compressed wide BVH (Ylitie et al. 2017) over the faces that have an area.
pub struct Bvh {
    /// The tree: eight quantised boxes per node.
    pub tree: CwBvh,
    /// Face of each primitive of the tree; a thin triangle has several.
    pub faces: Vec<u32>,
}

impl Bvh {
    /// Builds the BVH of a mesh.
    pub fn new(mesh: &Mesh) -> Self {
        Self::over(&mesh.faces)
    }

    /// Builds the BVH of `faces`.
    pub fn over(faces: &[MeshFace]) -> Self {
        let has_area = |k: &u32| faces[*k as usize].normal != Vec3::ZERO;
        let index: Vec<u32> = (0..faces.len() as u32).filter(has_area).collect();
        let (boxes, index) = split_boxes(faces, index);
        let tree = build_tree(&boxes);
        let faces = tree.primitive_indices.iter().map(|k| index[*k as usize]).collect();
        Self { tree, faces }
    }

    /// Returns the number of levels of nodes.
    pub fn tree_depth(&self) -> u32 {
        let mut level: Vec<u32> = (0..self.tree.nodes.len().min(1) as u32).collect();
        let mut depth = 0;
        while !level.is_empty() {
            depth += 1;
            let nodes = level.iter().map(|k| &self.tree.nodes[*k as usize]);
            let children = nodes.flat_map(|node| (0..node.imask.count_ones()).map(|i| node.child_base_idx + i));
            level = children.collect();
        }
        depth
    }
}

/// Builds the tree as [`obvhs::cwbvh::builder::build_cwbvh`] does, without its check of the binary tree's depth.
/// Nested boxes, as of a star's triangles, make the binary tree deep, but only the wide tree is traversed.
fn build_tree(boxes: &[Aabb]) -> CwBvh {
    let parameters = BvhBuildParams::very_slow_build();
    let binary = build_binary_tree(boxes, &parameters);
    let leaf = parameters.max_prims_per_leaf.clamp(1, 3);
    bvh2_to_cwbvh(&binary, leaf, true, false)
}

/// Builds the binary tree over `boxes`, with one reinsertion.
pub fn build_binary_tree(boxes: &[Aabb], parameters: &BvhBuildParams) -> Bvh2 {
    let mut binary = PlocBuilder::with_capacity(boxes.len()).build(
        parameters.ploc_search_distance,
        boxes,
        (0..boxes.len() as u32).collect::<Vec<_>>(),
        parameters.sort_precision,
        parameters.search_depth_threshold,
    );
    ReinsertionOptimizer::default().run(&mut binary, parameters.reinsertion_batch_ratio, None);
    binary
}

/// Returns boxes around the `faces` of `index`, and the face of each. Thin triangles, whose boxes are nearly empty, have
/// several.
fn split_boxes(faces: &[MeshFace], mut index: Vec<u32>) -> (Vec<Aabb>, Vec<u32>) {
    let corners = |k: &u32| faces[*k as usize].corners;
    let mut boxes: Vec<Aabb> = index.iter().map(|k| box_around(corners(k), 0.0)).collect();
    let area = |[a, b, c, d]: [Vec3; 4]| 0.5 * f64::from((c - a).cross(d - b).length());
    let mean = index.iter().map(|k| area(corners(k))).sum::<f64>() / index.len().max(1) as f64;
    let is_triangle = |k: &usize| corners(&index[*k])[2] == corners(&index[*k])[3];
    let places: Vec<usize> = (0..index.len()).filter(is_triangle).collect();
    let triangle = |k: &usize| {
        let [v0, v1, v2, _] = corners(&index[*k]).map(Vec3A::from);
        Triangle { v0, v1, v2 }
    };
    let triangles: Vec<Triangle> = places.iter().map(triangle).collect();
    let mut split: Vec<Aabb> = places.iter().map(|k| boxes[*k]).collect();
    let mut of_triangle: Vec<u32> = (0..triangles.len() as u32).collect();
    let least = SPLIT_AREA * mean as f32;
    let (gain, rounds, tried) = (SPLIT_GAIN, SPLIT_ROUNDS, SPLIT_PLACES);
    split_aabbs_precise(
        &mut split,
        &mut of_triangle,
        &triangles,
        least,
        0.0,
        gain,
        1.0,
        rounds,
        tried,
    );
    for (n, (part, triangle)) in split.into_iter().zip(of_triangle).enumerate() {
        let place = places[triangle as usize];
        if n < places.len() {
            boxes[place] = part;
        } else {
            boxes.push(part);
            index.push(index[place]);
        }
    }
    // The outline's margin, and a margin for the rounding of the nodes' quantised boxes.
    boxes.iter_mut().for_each(|aabb| pad_box(aabb, 4.0 * OUTLINE_MARGIN));
    (boxes, index)
}

/// Widens a box by `margin` on every side.
fn pad_box(aabb: &mut Aabb, margin: f32) {
    let margin = Vec3A::splat(margin);
    aabb.min -= margin;
    aabb.max += margin;
}

/// Returns the box around `points`, wider by `margin` on every side.
pub fn box_around(points: impl IntoIterator<Item = Vec3>, margin: f32) -> Aabb {
    let mut aabb = Aabb::empty();
    for point in points {
        aabb.extend(point.into());
    }
    pad_box(&mut aabb, margin);
    aabb
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::constants::RAY_STACK_LEVELS;
    use crate::import::{ImportOptions, load_scene};
    use crate::scene::{Face, Scene};
    use glam::DVec3;
    use std::fmt::Write;

    #[test]
    fn nested_boxes_make_a_shallow_tree() {
        // A star of a thousand corners, divided into a fan of triangles with nested boxes.
        let mut text = String::new();
        for k in 0..1000 {
            let (y, x) = (f64::from(k) * std::f64::consts::TAU / 1000.0).sin_cos();
            let r = if k % 2 == 0 { 1.0 } else { 0.5 };
            writeln!(text, "v {} {} 0", r * x, r * y).unwrap();
        }
        text += "f";
        (1..=1000).for_each(|k| write!(text, " {k}").unwrap());
        let file = std::env::temp_dir().join(format!("star-{}.obj", std::process::id()));
        std::fs::write(&file, text + "\n").unwrap();
        let scene = load_scene(&file, &ImportOptions::default());
        std::fs::remove_file(&file).unwrap();
        let bvh = Bvh::new(&Mesh::uniform(&scene.unwrap(), 1, 1).unwrap());
        assert!(bvh.tree_depth() < RAY_STACK_LEVELS, "{}", bvh.tree_depth());
    }

    /// The boxes of a thin triangle across a room hold all of it and are together much smaller than one box around it; a wide
    /// triangle and a quad keep one box each.
    #[test]
    fn boxes_of_thin_triangles_are_split() {
        let p = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
        let triangle = |corners| Face::triangle("face", corners, Vec3::ONE, Vec3::ZERO);
        let [o, x, y] = [DVec3::ZERO, DVec3::X, DVec3::Y];
        let mut faces = vec![
            Face::quad("face", [o, x, x + y, y], Vec3::ONE, Vec3::ZERO),
            triangle([o, p(1.0, 1.0, 1.0), p(0.01, 0.0, 0.0)]),
            triangle([o, x, p(0.0, 0.0, 1.0)]),
        ];
        // Small faces, beside which the others are large.
        faces.extend(vec![triangle([o, 0.05 * x, 0.05 * y]); 100]);
        let scene = Scene {
            faces,
            ..Scene::default()
        };
        let mesh = Mesh::uniform(&scene, 1, 1).unwrap();
        let (boxes, index) = split_boxes(&mesh.faces, (0..mesh.faces.len() as u32).collect());
        let of_face = |f: u32| {
            boxes
                .iter()
                .zip(&index)
                .filter(move |(_, k)| **k == f)
                .map(|(aabb, _)| aabb)
        };
        assert_eq!([0, 1, 2, 3].map(|f| of_face(f).count()), [1, 8, 1, 1]);
        let [a, b, c, _] = mesh.faces[1].corners;
        for k in 0..1000 {
            let [s, t] = [k % 10, k / 10].map(|n| n as f32);
            let point = Vec3A::from(a + (b - a) * (t / 99.0) + (c - b) * (s / 9.0 * t / 99.0));
            let holds = |aabb: &Aabb| point.cmpge(aabb.min).all() && point.cmple(aabb.max).all();
            assert!(of_face(1).any(holds), "{point}");
        }
        let surface: f32 = of_face(1).map(Aabb::half_area).sum();
        let whole = box_around(mesh.faces[1].corners, 0.0).half_area();
        assert!(surface < 0.2 * whole, "{surface} of {whole}");
    }
}
