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

/// A compressed wide BVH (Ylitie et al. 2017) over the faces that have an area.
pub struct Bvh {
    /// The tree: eight quantised boxes per node.
    pub tree: CwBvh,
    /// Face of each primitive of the tree.
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
        let boxes: Vec<Aabb> = index.iter().map(|k| padded_box(&faces[*k as usize])).collect();
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

fn padded_box(face: &MeshFace) -> Aabb {
    // The outline's margin, and a margin for the rounding of the nodes' quantised boxes.
    box_around(face.corners, 4.0 * OUTLINE_MARGIN)
}

/// Returns the box around `points`, wider by `margin` on every side.
pub fn box_around(points: impl IntoIterator<Item = Vec3>, margin: f32) -> Aabb {
    let mut aabb = Aabb::empty();
    for point in points {
        aabb.extend(point.into());
    }
    let margin = Vec3A::splat(margin);
    aabb.min -= margin;
    aabb.max += margin;
    aabb
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::constants::RAY_STACK_LEVELS;
    use crate::import::{ImportOptions, load_scene};
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
}
