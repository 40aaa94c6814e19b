//! Coarse nodes: the receivers of stored links, and sources of all further bounces.

use crate::hierarchy::block::{ReceiverBlocks, Spot};
use crate::hierarchy::linear_radiosity::{LinearRadiosity, pull_nodes};
use crate::hierarchy::link::BlockLink;
use crate::hierarchy::tree::TexelTree;
use crate::rows::lane_points::LaneValues;
use crate::rows::receivers::LANE_COUNT;
use common::mesh::Mesh;
use glam::Vec3;
use rayon::prelude::*;

/// Least share of a node's area by which its irradiance is divided.
const MIN_REACHED_SHARE: f32 = 0.05;
/// Index of a node that is not coarse.
const NO_COARSE_NODE: u32 = u32::MAX;

/// A node's link to a block.
#[derive(Clone)]
pub struct StoredLink {
    /// Number of the node.
    pub node: u32,
    /// The link.
    pub link: BlockLink,
}

/// A coarse node.
struct CoarseNode {
    node: u32,
    /// Open area.
    area: f32,
    /// Area that others see, and the open share of it.
    source: (f32, f32),
    /// Share of the node's area that light reaches.
    reached: f32,
    reflectance: Vec3,
}

/// Coarse nodes as receivers and as sources.
pub struct CoarseNodes {
    /// The nodes as receivers.
    pub receivers: ReceiverBlocks,
    /// The nodes in the order of the blocks' lanes.
    nodes: Vec<CoarseNode>,
    /// Index of each node of the tree in `nodes`.
    index: Vec<u32>,
    /// The coarse nodes and their ancestors; ancestors follow their descendants.
    above: Vec<u32>,
    /// Index of each node of the tree in `above`.
    slot: Vec<u32>,
    /// Descendants of coarse nodes that are sources of links.
    beneath: Vec<u32>,
    /// Factor of each node's irradiance that keeps K from gaining energy.
    cap: Vec<f32>,
    /// Sources have no slope: between two faces that see little but each other, extrapolated slopes may gain energy. The
    /// radiosity of a node is then a mean of those of coarse nodes, so that K gains no more than the sums of its rows.
    pub constant_radiosity: bool,
}

impl CoarseNodes {
    /// Selects the largest nodes that are `coarse`; `areas` are the open area of each texel and its
    /// area under preceding fronts.
    pub fn new(mesh: &Mesh, tree: &TexelTree, coarse: impl Fn(u32) -> bool + Sync, areas: [&[f32]; 2]) -> Self {
        let receivers = ReceiverBlocks::new(mesh, |f| {
            let nodes = tree.largest_nodes(f, &coarse).into_iter();
            nodes.map(|k| Spot::of_node(tree, k)).collect()
        });
        let lanes = receivers.blocks.iter();
        let nodes = lanes.flat_map(|block| block.target[..block.count].to_vec());
        let nodes: Vec<CoarseNode> = nodes.map(|k| CoarseNode::new(mesh, tree, k, areas)).collect();
        let mut index = vec![NO_COARSE_NODE; tree.nodes.len()];
        let mut above = Vec::new();
        let mut slot = vec![NO_COARSE_NODE; tree.nodes.len()];
        for (n, coarse) in (0..).zip(&nodes) {
            index[coarse.node as usize] = n;
            let mut k = coarse.node;
            while slot[k as usize] == NO_COARSE_NODE {
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
            cap: vec![1.0; nodes.len()],
            constant_radiosity: false,
            receivers,
            nodes,
            index,
            above,
            slot,
            beneath: Vec::new(),
        }
    }

    /// Returns the number of coarse nodes.
    pub fn node_count(&self) -> usize {
        self.nodes.len()
    }

    /// Prepares the sources of `links`, so that [`Self::fit_sources`] sets their radiosity.
    pub fn prepare_sources(&mut self, links: &[Vec<StoredLink>]) {
        let nodes = links.iter().flatten().map(|stored| stored.node);
        let beneath = |k: &u32| self.slot.get(*k as usize) == Some(&NO_COARSE_NODE);
        self.beneath = nodes.filter(beneath).collect();
        self.beneath.sort_unstable();
        self.beneath.dedup();
    }

    /// Limits each node's irradiance so that a uniform radiosity of 1 W/m², which gives `sums`, causes 1 W/m² at most.
    pub fn limit_gain(&mut self, sums: &[[LaneValues; 3]]) {
        let received = self.received_irradiance(sums);
        for (cap, received) in self.cap.iter_mut().zip(received) {
            *cap /= received.max_element().max(1.0);
        }
    }

    /// Returns H of the nodes' open parts from the `sums` of the blocks' lanes.
    pub fn received_irradiance(&self, sums: &[[LaneValues; 3]]) -> Vec<Vec3> {
        let blocks = self.receivers.blocks.iter().zip(sums);
        let lanes =
            blocks.flat_map(|(block, sums)| (0..block.count).map(|l| Vec3::new(sums[0][l], sums[1][l], sums[2][l])));
        let nodes = self.nodes.iter().zip(&self.cap);
        let share = |(h, (coarse, cap)): (Vec3, (&CoarseNode, &f32))| h * *cap / coarse.reached.max(MIN_REACHED_SHARE);
        lanes.zip(nodes).map(share).collect()
    }

    /// Returns ρH of each node.
    pub fn reflected_radiosity(&self, received: &[Vec3]) -> Vec<Vec3> {
        let nodes = received.iter().zip(&self.nodes);
        nodes.map(|(h, coarse)| *h * coarse.reflectance).collect()
    }

    /// Returns Σ |v| A over the nodes' open area, of the largest channel.
    pub fn total_power(&self, values: &[Vec3]) -> f64 {
        let nodes = values.iter().zip(&self.nodes);
        let parts = nodes.map(|(v, coarse)| v.abs().as_dvec3() * f64::from(coarse.area));
        parts.sum::<glam::DVec3>().max_element()
    }

    /// Returns Σ (1 − ρ) |H| A over the nodes' open area, of the largest channel.
    pub fn absorbed_power(&self, received: &[Vec3]) -> f64 {
        let nodes = received.iter().zip(&self.nodes);
        let absorbed = nodes.map(|(h, coarse)| *h * (Vec3::ONE - coarse.reflectance));
        self.total_power(&absorbed.collect::<Vec<_>>())
    }

    /// Sets the radiosity of all prepared sources from `values` of the coarse nodes (pull, then push). Coarse nodes
    /// and their descendants have the slope of the coarse node's parent.
    pub fn fit_sources(&self, tree: &TexelTree, values: &[Vec3], sources: &mut [LinearRadiosity]) {
        if self.constant_radiosity {
            self.average_nodes(tree, values, sources);
        } else {
            self.fit_nodes(tree, values, sources);
        }
        for k in &self.beneath {
            let node = &tree.nodes[*k as usize];
            let mut over = node.parent;
            while self.index[over as usize] == NO_COARSE_NODE {
                over = tree.nodes[over as usize].parent;
            }
            let d = node.face_position - tree.nodes[over as usize].face_position;
            let own = sources[over as usize];
            let [x, y] = own.slope;
            sources[*k as usize] = LinearRadiosity {
                mean: own.mean + x * d.x + y * d.y,
                ..own
            };
        }
    }

    /// Fits mean and slope of the coarse nodes and their ancestors.
    fn fit_nodes(&self, tree: &TexelTree, values: &[Vec3], sources: &mut [LinearRadiosity]) {
        let part = |k: u32| {
            let n = self.index[k as usize];
            (n != NO_COARSE_NODE).then(|| self.nodes[n as usize].as_source(values[n as usize]))
        };
        let slot = |k: u32| self.slot[k as usize] as usize;
        pull_nodes(tree, &self.above, slot, part, sources);
        for coarse in &self.nodes {
            let parent = tree.nodes[coarse.node as usize].parent;
            sources[coarse.node as usize].slope = sources[parent as usize].slope;
        }
    }

    /// Sets the coarse nodes and their ancestors to the mean over the area that others see, without slope.
    fn average_nodes(&self, tree: &TexelTree, values: &[Vec3], sources: &mut [LinearRadiosity]) {
        let mut sums = vec![(0.0, Vec3::ZERO); self.above.len()];
        for (n, k) in self.above.iter().enumerate() {
            let (index, children) = (self.index[*k as usize], tree.nodes[*k as usize].children.clone());
            let (area, light) = if index == NO_COARSE_NODE {
                let parts = children.map(|child| sums[self.slot[child as usize] as usize]);
                parts.fold((0.0, Vec3::ZERO), |sum, part| (sum.0 + part.0, sum.1 + part.1))
            } else {
                let (area, value) = self.nodes[index as usize].as_source(values[index as usize]);
                (area, value * area)
            };
            sums[n] = (area, light);
            sources[*k as usize] = LinearRadiosity {
                mean: if area > 0.0 { light / area } else { Vec3::ZERO },
                ..LinearRadiosity::default()
            };
        }
    }

    /// Interpolates `values` of the nodes at their texels, with the slope of each node's parent.
    pub fn spread_to_texels(&self, tree: &TexelTree, values: &[Vec3], texels: usize) -> Vec<Vec3> {
        let mut sources = vec![LinearRadiosity::default(); tree.nodes.len()];
        self.fit_sources(tree, values, &mut sources);
        let mut spread = vec![Vec3::ZERO; texels];
        for (coarse, value) in self.nodes.iter().zip(values) {
            let centre = tree.nodes[coarse.node as usize].face_position;
            let [x, y] = sources[coarse.node as usize].slope;
            // The change is limited to half of the value, so that extrapolation cannot change its sign.
            let [a, b] = [*value * 0.5, *value * 1.5];
            let (low, high) = (a.min(b), a.max(b));
            for leaf in tree.leaves_of(coarse.node) {
                let d = tree.nodes[leaf.node as usize].face_position - centre;
                let sloped = *value + x * d.x + y * d.y;
                spread[leaf.texel as usize] = sloped.clamp(low, high);
            }
        }
        spread
    }
}

impl CoarseNode {
    fn new(mesh: &Mesh, tree: &TexelTree, node: u32, areas: [&[f32]; 2]) -> Self {
        let leaves = tree.leaves_of(node);
        let [open, dark] = areas.map(|area| leaves.iter().map(|leaf| area[leaf.texel as usize]).sum::<f32>());
        let (source, all) = (source_area(open, dark), tree.nodes[node as usize].shooter.area);
        Self {
            node,
            reflectance: tree.mean_reflectance(mesh, node),
            area: open,
            source,
            reached: if all > 0.0 { (source.0 / all).min(1.0) } else { 1.0 },
        }
    }

    /// Returns the area that others see, and the mean over it of a radiosity of the open part.
    fn as_source(&self, radiosity: Vec3) -> (f32, Vec3) {
        let (area, open) = self.source;
        (area, radiosity * open)
    }
}

/// Returns the area that others see of an `open` one and one under preceding fronts, which is `dark`, and the open share of
/// it.
pub fn source_area(open: f32, dark: f32) -> (f32, f32) {
    let area = open + dark;
    (area, if dark > 0.0 { open / area } else { 1.0 })
}

/// Gathers the `radiosity` of the sources over `links` at each block.
pub fn gather_over_links(links: &[Vec<StoredLink>], radiosity: &[LinearRadiosity]) -> Vec<[LaneValues; 3]> {
    links
        .par_iter()
        .map(|links| {
            let mut sums = [[0.0; LANE_COUNT]; 3];
            for stored in links {
                stored.link.add_irradiance(&radiosity[stored.node as usize], &mut sums);
            }
            sums
        })
        .collect()
}

/// Sums the amounts of the irradiance over each of `links` at each block.
pub fn sum_link_amounts(links: &[Vec<StoredLink>], radiosity: &[LinearRadiosity]) -> Vec<[LaneValues; 3]> {
    let amounts = |links: &Vec<StoredLink>| {
        let mut sums = [[0.0; LANE_COUNT]; 3];
        for stored in links {
            let mut own = [[0.0; LANE_COUNT]; 3];
            stored.link.add_irradiance(&radiosity[stored.node as usize], &mut own);
            for (sum, own) in sums.as_flattened_mut().iter_mut().zip(own.as_flattened()) {
                *sum += own.abs();
            }
        }
        sums
    };
    links.par_iter().map(amounts).collect()
}

/// Adds two fields value by value.
pub fn add_fields(a: &[Vec3], b: &[Vec3]) -> Vec<Vec3> {
    a.iter().zip(b).map(|(a, b)| *a + *b).collect()
}
