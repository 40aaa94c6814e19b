//! The one hierarchy of boxes over the faces, which the CPU and the GPU traverse alike.

use crate::constants::OUTLINE;
use crate::mesh::{Mesh, MeshFace};
use glam::{Vec3, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::cwbvh::{CwBvh, builder::build_cwbvh};
use std::time::Duration;

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
        let mut build_time = Duration::ZERO;
        let tree = build_cwbvh(&boxes, BvhBuildParams::very_slow_build(), &mut build_time);
        let faces = tree
            .primitive_indices
            .iter()
            .map(|k| index[*k as usize])
            .collect();
        Self { tree, faces }
    }

    /// Levels of nodes.
    pub fn depth(&self) -> u32 {
        let mut level: Vec<u32> = if self.tree.nodes.is_empty() {
            Vec::new()
        } else {
            vec![0]
        };
        let mut depth = 0;
        while !level.is_empty() {
            depth += 1;
            level = level
                .iter()
                .map(|k| &self.tree.nodes[*k as usize])
                .flat_map(|node| (0..node.imask.count_ones()).map(|i| node.child_base_idx + i))
                .collect();
        }
        depth
    }
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
