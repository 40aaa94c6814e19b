//! Coarse receivers with links that are kept: over them light goes round until it is spent.

use crate::hierarchy::block::{Receivers, Spot};
use crate::hierarchy::light::{Glow, pull};
use crate::hierarchy::link::Link;
use crate::hierarchy::tree::Tree;
use crate::rows::lanes::Lane;
use crate::rows::receivers::LANES;
use common::mesh::Mesh;
use glam::Vec3;
use rayon::prelude::*;

/// A node's link to a block.
pub struct Kept {
    /// The node.
    pub node: u32,
    /// The link.
    pub link: Link,
}

/// Coarse nodes as receivers.
pub struct Coarse {
    /// What receives: nodes of the tree.
    pub receivers: Receivers,
    /// Of each block's lanes.
    open: Vec<Lane>,
}

impl Coarse {
    /// Nodes of at most that radius; `area` is the open area of each texel.
    pub fn new(mesh: &Mesh, tree: &Tree, radius: f32, area: &[f32]) -> Self {
        let receivers = Receivers::new(mesh, |f| {
            let nodes = tree.within(f, radius).into_iter();
            nodes
                .map(|k| {
                    let shooter = &tree.nodes[k as usize].shooter;
                    Spot {
                        target: k,
                        share: 1.0,
                        corners: shooter.corners,
                        centre: shooter.centre,
                    }
                })
                .collect()
        });
        let share = |k: u32| {
            let open: f32 = tree
                .leaves(k)
                .iter()
                .map(|leaf| area[leaf.texel as usize])
                .sum();
            let all = tree.nodes[k as usize].shooter.area;
            if all > 0.0 {
                (open / all).min(1.0)
            } else {
                1.0
            }
        };
        let open = receivers
            .blocks
            .iter()
            .map(|block| block.target.map(share))
            .collect();
        Self { receivers, open }
    }

    /// What the nodes' texels receive where they are open, as `sums` of the blocks' lanes have it: at
    /// a node its own, elsewhere along the slope of its parent.
    pub fn spread(&self, tree: &Tree, area: &[f32], sums: &[[Lane; 3]]) -> Vec<Vec3> {
        let mut texels = vec![Vec3::ZERO; area.len()];
        let mut nodes = Vec::new();
        for ((block, sums), open) in self.receivers.blocks.iter().zip(sums).zip(&self.open) {
            for l in 0..block.count {
                let own = Vec3::new(sums[0][l], sums[1][l], sums[2][l]);
                let value = own / open[l].max(LEAST_OPEN);
                for leaf in tree.leaves(block.target[l]) {
                    texels[leaf.texel as usize] = value;
                }
                nodes.push((block.target[l], value));
            }
        }
        let glow = pull(tree, area, &texels);
        for (k, value) in nodes {
            let node = &tree.nodes[k as usize];
            let [x, y] = glow[node.parent as usize].slope;
            // Half as much to each side at most: what falls to nothing is not extrapolated.
            let [a, b] = [value * 0.5, value * 1.5];
            let (low, high) = (a.min(b), a.max(b));
            for leaf in tree.leaves(k) {
                let d = tree.nodes[leaf.node as usize].place - node.place;
                texels[leaf.texel as usize] = (value + x * d.x + y * d.y).clamp(low, high);
            }
        }
        texels
    }
}

/// A node less open than this receives as if it were so.
const LEAST_OPEN: f32 = 0.05;

/// What all blocks receive of `glow`.
pub fn exchange(kept: &[Vec<Kept>], glow: &[Glow]) -> Vec<[Lane; 3]> {
    kept.par_iter()
        .map(|links| {
            let mut sums = [[0.0; LANES]; 3];
            for kept in links {
                kept.link.add(&glow[kept.node as usize], &mut sums);
            }
            sums
        })
        .collect()
}
