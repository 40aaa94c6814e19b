//! The one hierarchy of boxes over the faces, which the CPU and the GPU traverse alike.

use crate::constants::{OUTLINE, RAY_STACK};
use crate::mesh::{Mesh, MeshFace};
use glam::{Vec3, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::bvh2_to_cwbvh::bvh2_to_cwbvh;
use obvhs::ploc::PlocBuilder;

/// Boxes over the faces that have an area.
pub struct Bvh {
    /// The tree: eight quantised boxes a node.
    pub tree: CwBvh,
    /// The face of each primitive of the tree.
    pub faces: Vec<u32>,
}

impl Bvh {
    /// Builds it.
    pub fn new(mesh: &Mesh) -> Self {
        let index: Vec<u32> = (0..mesh.faces.len() as u32)
            .filter(|k| mesh.faces[*k as usize].normal != Vec3::ZERO)
            .collect();
        let boxes: Vec<Aabb> = index
            .iter()
            .map(|k| bounds(&mesh.faces[*k as usize]))
            .collect();
        let tree = build(&boxes);
        let faces = tree
            .primitive_indices
            .iter()
            .map(|k| index[*k as usize])
            .collect();
        Self { tree, faces }
    }

    /// Levels of nodes.
    pub fn depth(&self) -> u32 {
        depth(&self.tree)
    }
}

/// As obvhs builds it, unless it gets too deep for its traversal, which then would lose nodes: boxes
/// that hold one another, as of the triangles of a star, are better left where they were put first.
fn build(boxes: &[Aabb]) -> CwBvh {
    let parameters = BvhBuildParams::very_slow_build();
    let indices = (0..boxes.len() as u32).collect::<Vec<_>>();
    let first = PlocBuilder::with_capacity(boxes.len()).build(
        parameters.ploc_search_distance,
        boxes,
        indices,
        parameters.sort_precision,
        parameters.search_depth_threshold,
    );
    let mut better = first.clone();
    ReinsertionOptimizer::default().run(&mut better, parameters.reinsertion_batch_ratio, None);
    let leaf = parameters.max_prims_per_leaf.clamp(1, 3);
    let tree = bvh2_to_cwbvh(&better, leaf, true, false);
    if depth(&tree) < RAY_STACK {
        return tree;
    }
    bvh2_to_cwbvh(&first, leaf, true, false)
}

fn depth(tree: &CwBvh) -> u32 {
    let mut level: Vec<u32> = if tree.nodes.is_empty() {
        Vec::new()
    } else {
        vec![0]
    };
    let mut depth = 0;
    while !level.is_empty() {
        depth += 1;
        level = level
            .iter()
            .map(|k| &tree.nodes[*k as usize])
            .flat_map(|node| (0..node.imask.count_ones()).map(|i| node.child_base_idx + i))
            .collect();
    }
    depth
}

fn bounds(face: &MeshFace) -> Aabb {
    let mut aabb = Aabb::empty();
    for corner in face.corners {
        aabb.extend(corner.into());
    }
    // The outline's margin, and room for the rounding of the nodes' quantised boxes.
    let margin = Vec3A::splat(4.0 * OUTLINE);
    aabb.min -= margin;
    aabb.max += margin;
    aabb
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Face, Scene};
    use glam::DVec3;

    #[test]
    fn boxes_that_hold_one_another_make_no_deep_tree() {
        // A star as ears are cut from it: triangles from its first corner to ever farther ones.
        let at = |k: u32| {
            let (y, x) = (f64::from(k) * std::f64::consts::TAU / 1000.0).sin_cos();
            DVec3::new(x, y, 0.0) * if k % 2 == 0 { 1.0 } else { 0.5 }
        };
        let face = |k| Face::triangle("", [at(0), at(k), at(k + 1)], Vec3::ZERO, Vec3::ZERO);
        let nested = |k: u32| {
            let side = f64::from(k + 1);
            let corners = [
                DVec3::ZERO,
                DVec3::X * side,
                DVec3::new(side, side, 1e-3 * side),
            ];
            Face::triangle("", corners, Vec3::ZERO, Vec3::ZERO)
        };
        for faces in [
            (1..999).map(face).collect(),
            (0..1000).map(nested).collect::<Vec<_>>(),
        ] {
            let scene = Scene {
                faces,
                ..Scene::default()
            };
            let bvh = Bvh::new(&Mesh::uniform(&scene, 1, 1).unwrap());
            assert!(bvh.depth() < RAY_STACK, "{}", bvh.depth());
        }
    }
}
