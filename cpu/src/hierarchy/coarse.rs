//! Coarse receivers with links that are kept: over them light goes round until it is spent.

use crate::hierarchy::block::{Receivers, Spot};
use crate::hierarchy::cluster::Clusters;
use crate::hierarchy::light::{Glow, pull_up};
use crate::hierarchy::link::Link;
use crate::hierarchy::tree::Tree;
use crate::rows::lanes::Lane;
use crate::rows::receivers::LANES;
use common::mesh::Mesh;
use glam::Vec3;
use rayon::prelude::*;

/// A node less open than this receives as if it were so.
const LEAST_OPEN: f32 = 0.05;
/// No coarse node.
const NONE: u32 = u32::MAX;

/// A node's link to a block.
pub struct Kept {
    /// The node.
    pub node: u32,
    /// The link.
    pub link: Link,
}

/// A coarse node.
struct Place {
    node: u32,
    /// Its open area, and the share of its area that this is.
    area: f32,
    open: f32,
    reflectance: Vec3,
}

/// Coarse nodes, as receivers and as sources.
pub struct Coarse {
    /// What receives: nodes of the tree.
    pub receivers: Receivers,
    /// In the order of the blocks' lanes.
    places: Vec<Place>,
    /// Where each node of the tree is among them.
    index: Vec<u32>,
    /// They and all of which they are parts, these after their parts; and where each is.
    above: Vec<u32>,
    slot: Vec<u32>,
    /// Nodes beneath them whose glow is asked for.
    beneath: Vec<u32>,
    /// What is left of each one's light so that no more arrives than is sent.
    cap: Vec<f32>,
    /// Whether nodes shine evenly. Where two faces see little but each other, slopes, which reach beyond
    /// what they are drawn through, may send more than there is.
    pub flat: bool,
}

impl Coarse {
    /// Nodes that are `whole`; `area` is the open area of each texel.
    pub fn new(
        mesh: &Mesh,
        tree: &Tree,
        clusters: &Clusters,
        whole: impl Fn(u32) -> bool + Sync,
        area: &[f32],
    ) -> Self {
        let receivers = Receivers::new(mesh, &clusters.order, |f| {
            let nodes = tree.whole(f, &whole).into_iter();
            nodes
                .map(|k| {
                    let shooter = &tree.nodes[k as usize].shooter;
                    Spot {
                        face: f as u32,
                        target: k,
                        share: 1.0,
                        corners: shooter.corners,
                        centre: shooter.centre,
                    }
                })
                .collect()
        });
        let lanes = receivers.blocks.iter();
        let nodes = lanes.flat_map(|block| block.target[..block.count].to_vec());
        let places: Vec<Place> = nodes.map(|k| Place::new(mesh, tree, k, area)).collect();
        let mut index = vec![NONE; tree.nodes.len()];
        let mut above = Vec::new();
        let mut slot = vec![NONE; tree.nodes.len()];
        for (n, place) in (0..).zip(&places) {
            index[place.node as usize] = n;
            let mut k = place.node;
            while slot[k as usize] == NONE {
                slot[k as usize] = 0;
                above.push(k);
                k = tree.nodes[k as usize].parent;
            }
        }
        // Parts have higher numbers.
        above.sort_unstable_by(|a, b| b.cmp(a));
        for (n, k) in (0..).zip(&above) {
            slot[*k as usize] = n;
        }
        Self {
            cap: vec![1.0; places.len()],
            flat: false,
            receivers,
            places,
            index,
            above,
            slot,
            beneath: Vec::new(),
        }
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.places.len()
    }

    /// From now on the glow of whatever `kept` links come from is asked for.
    pub fn serve(&mut self, kept: &[Vec<Kept>]) {
        let nodes = kept.iter().flatten().map(|kept| kept.node);
        let beneath = |k: &u32| self.slot.get(*k as usize) == Some(&NONE);
        self.beneath = nodes.filter(beneath).collect();
        self.beneath.sort_unstable();
        self.beneath.dedup();
    }

    /// `sums` are what arrives where everything shines 1 W/m²: no more than that is let in.
    pub fn close(&mut self, sums: &[[Lane; 3]]) {
        let received = self.received(sums);
        for (cap, received) in self.cap.iter_mut().zip(received) {
            *cap = 1.0 / received.max_element().max(1.0);
        }
    }

    /// What the nodes receive where they are open, as `sums` of the blocks' lanes have it.
    pub fn received(&self, sums: &[[Lane; 3]]) -> Vec<Vec3> {
        let blocks = self.receivers.blocks.iter().zip(sums);
        let lanes = blocks.flat_map(|(block, sums)| {
            (0..block.count).map(|l| Vec3::new(sums[0][l], sums[1][l], sums[2][l]))
        });
        let places = self.places.iter().zip(&self.cap);
        let share =
            |(h, (place, cap)): (Vec3, (&Place, &f32))| h * *cap / place.open.max(LEAST_OPEN);
        lanes.zip(places).map(share).collect()
    }

    /// What the nodes reflect of what they receive.
    pub fn reflected(&self, received: &[Vec3]) -> Vec<Vec3> {
        let places = received.iter().zip(&self.places);
        places.map(|(h, place)| *h * place.reflectance).collect()
    }

    /// Σ |v| A over the nodes' open area, of the channel that has most.
    pub fn power(&self, values: &[Vec3]) -> f64 {
        let places = values.iter().zip(&self.places);
        let parts = places.map(|(v, place)| v.abs().as_dvec3() * f64::from(place.area));
        parts.sum::<glam::DVec3>().max_element()
    }

    /// The glow of all nodes that are served, from `values` at the coarse ones: these slope as the nodes
    /// do of which they are parts, and so does what is beneath them.
    pub fn glow(&self, tree: &Tree, values: &[Vec3], glows: &mut [Glow]) {
        let part = |k: u32| {
            let n = self.index[k as usize];
            (n != NONE).then(|| (self.places[n as usize].area, values[n as usize]))
        };
        let slot = |k: u32| self.slot[k as usize] as usize;
        pull_up(tree, &self.above, slot, part, glows);
        for place in &self.places {
            let parent = tree.nodes[place.node as usize].parent;
            glows[place.node as usize].slope = glows[parent as usize].slope;
        }
        if self.flat {
            for k in &self.above {
                glows[*k as usize].slope = [Vec3::ZERO; 2];
            }
        }
        for k in &self.beneath {
            let node = &tree.nodes[*k as usize];
            let mut over = node.parent;
            while self.index[over as usize] == NONE {
                over = tree.nodes[over as usize].parent;
            }
            let d = node.place - tree.nodes[over as usize].place;
            let own = glows[over as usize];
            let [x, y] = own.slope;
            glows[*k as usize] = Glow {
                mean: own.mean + x * d.x + y * d.y,
                ..own
            };
        }
    }

    /// What the nodes' texels have where they are open: at a node's centre its own, elsewhere along the
    /// slope of the node of which it is a part.
    pub fn spread(&self, tree: &Tree, values: &[Vec3], texels: usize) -> Vec<Vec3> {
        let mut glows = vec![Glow::default(); tree.nodes.len()];
        self.glow(tree, values, &mut glows);
        let mut spread = vec![Vec3::ZERO; texels];
        for (place, value) in self.places.iter().zip(values) {
            let centre = tree.nodes[place.node as usize].place;
            let [x, y] = glows[place.node as usize].slope;
            // Half as much to each side at most: what falls to nothing is not extrapolated.
            let [a, b] = [*value * 0.5, *value * 1.5];
            let (low, high) = (a.min(b), a.max(b));
            for leaf in tree.leaves(place.node) {
                let d = tree.nodes[leaf.node as usize].place - centre;
                let sloped = *value + x * d.x + y * d.y;
                spread[leaf.texel as usize] = sloped.clamp(low, high);
            }
        }
        spread
    }
}

impl Place {
    fn new(mesh: &Mesh, tree: &Tree, node: u32, area: &[f32]) -> Self {
        let leaves = tree.leaves(node).iter();
        let open: f32 = leaves.map(|leaf| area[leaf.texel as usize]).sum();
        let all = tree.nodes[node as usize].shooter.area;
        Self {
            node,
            reflectance: tree.reflectance(mesh, node),
            area: open,
            open: if all > 0.0 {
                (open / all).min(1.0)
            } else {
                1.0
            },
        }
    }
}

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
