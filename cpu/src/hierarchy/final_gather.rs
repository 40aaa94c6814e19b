//! Adaptive final gather (Lischinski et al. 1993): nodes gather level by level, down to the texels. Where the parts
//! of a node agree with the linear prediction from its neighbours, its texels are interpolated instead.

use crate::dense::open_area::Element;
use crate::hierarchy::block::{ReceiverBlock, Spot};
use crate::hierarchy::linear_radiosity::fit_linear;
use crate::hierarchy::linker::{BlockIrradiance, MAX_LINEAR_DEVIATION};
use crate::hierarchy::tree::TexelTree;
use glam::{Vec2, Vec3};
use std::collections::HashMap;
use std::ops::Range;

/// Largest radius of the first nodes that gather (the mesh is two units wide at most).
const MAX_FIRST_RADIUS: f32 = 0.18;

/// Texels that are partly or wholly covered by bodies.
pub struct CoveredTexels {
    /// Open spots of each node that is such a texel.
    spots: HashMap<u32, Vec<Spot>>,
    /// Nodes that contain such a texel.
    contains_covered: Vec<bool>,
}

impl CoveredTexels {
    /// Collects the open spots of the `covered` texels.
    pub fn new(tree: &TexelTree, covered: &[(u32, Element)]) -> Self {
        let elements: HashMap<u32, &Element> = covered.iter().map(|(k, e)| (*k, e)).collect();
        let mut spots = HashMap::with_capacity(covered.len());
        let mut contains_covered = vec![false; tree.nodes.len()];
        for leaf in &tree.leaves {
            let Some(element) = elements.get(&leaf.texel) else {
                continue;
            };
            let mut k = leaf.node as usize;
            spots.insert(leaf.node, open_spots(tree, leaf.node, element));
            while !contains_covered[k] {
                contains_covered[k] = true;
                k = tree.nodes[k].parent as usize;
            }
        }
        Self {
            spots,
            contains_covered,
        }
    }

    /// Returns the spots on which node `k` receives: the whole node, or the open parts of a texel.
    pub fn spots_of_node(&self, tree: &TexelTree, k: u32) -> Vec<Spot> {
        if let Some(spots) = self.spots.get(&k) {
            return spots.clone();
        }
        vec![Spot::of_node(tree, k)]
    }
}

/// Returns the open parts of a texel as spots.
fn open_spots(tree: &TexelTree, node: u32, element: &Element) -> Vec<Spot> {
    let quads = element.pieces.iter().flat_map(|piece| {
        let centre = piece.centre.as_vec3();
        let quads = piece.polygon.quad_pieces();
        quads.map(move |quad| (quad.map(|p| p.as_vec3()), centre))
    });
    quads
        .map(|(corners, centre)| {
            let [a, b, c, d] = corners;
            let area = (c - a).cross(d - b).length() * 0.5;
            Spot {
                face: tree.nodes[node as usize].face,
                target: node,
                share: (area / element.area as f32).min(1.0),
                corners,
                centre,
            }
        })
        .collect()
}

/// The selected receivers.
pub struct ReceiverSelection {
    /// Faces whose texels receive.
    pub faces: Range<usize>,
    /// Largest radius of the first nodes that gather.
    pub max_radius: f32,
}

impl ReceiverSelection {
    /// Selects the texels of `faces`.
    pub fn on_faces(faces: Range<usize>) -> Self {
        Self {
            faces,
            max_radius: MAX_FIRST_RADIUS,
        }
    }

    /// Starts with nodes no larger than `radius`, so that features of that size are not missed.
    pub fn limit_radius(self, radius: f32) -> Self {
        Self {
            max_radius: self.max_radius.min(radius),
            ..self
        }
    }
}

/// A final gather in progress.
pub struct FinalGather<'a> {
    tree: &'a TexelTree,
    covered: &'a CoveredTexels,
    /// 1/RMS of the reflected light, times the reflectance of each face.
    scale: &'a dyn Fn(u32) -> Vec3,
    threshold: f32,
    /// H of each node that has gathered.
    value: Vec<Vec3>,
    /// Nodes that a shadow edge crosses.
    crosses_shadow_edge: Vec<bool>,
    /// Nodes whose parts gather next, by face.
    parents: Vec<Vec<u32>>,
    /// The first nodes have gathered.
    begun: bool,
    /// H of each texel.
    texels: Vec<Vec3>,
}

impl<'a> FinalGather<'a> {
    /// Starts a gather at the selected faces of a mesh of `texels` texels. `scale` is 1/RMS of the reflected light
    /// times a face's reflectance; `threshold` is the deviation that counts as linear, over
    /// [`MAX_LINEAR_DEVIATION`].
    pub fn new(
        tree: &'a TexelTree,
        covered: &'a CoveredTexels,
        scale: &'a dyn Fn(u32) -> Vec3,
        threshold: f32,
        selection: &ReceiverSelection,
        texels: usize,
    ) -> Self {
        let first_nodes = |f: usize| match selection.faces.contains(&f) {
            true => tree.largest_nodes(f, |k| tree.nodes[k as usize].shooter.radius <= selection.max_radius),
            false => Vec::new(),
        };
        Self {
            tree,
            covered,
            scale,
            threshold,
            value: vec![Vec3::ZERO; tree.nodes.len()],
            crosses_shadow_edge: vec![false; tree.nodes.len()],
            parents: (0..tree.roots.len()).map(first_nodes).collect(),
            begun: false,
            texels: vec![Vec3::ZERO; texels],
        }
    }

    /// Returns the spots that gather next, by face; none when all texels are done.
    pub fn next_spots(&self) -> Option<Vec<Vec<Spot>>> {
        let nodes = |parents: &Vec<u32>| -> Vec<Spot> {
            let parts = parents.iter().flat_map(|p| self.receiving_nodes(*p));
            parts.flat_map(|k| self.covered.spots_of_node(self.tree, k)).collect()
        };
        let spots: Vec<Vec<Spot>> = self.parents.iter().map(nodes).collect();
        spots.iter().any(|spots| !spots.is_empty()).then_some(spots)
    }

    /// Returns the nodes that gather for `p`: first itself, then its parts.
    fn receiving_nodes(&self, p: u32) -> Range<u32> {
        if self.begun {
            self.tree.nodes[p as usize].children.clone()
        } else {
            p..p + 1
        }
    }

    /// Takes the irradiance of the spots' blocks and selects the nodes that gather next.
    pub fn take_irradiance(&mut self, blocks: &[ReceiverBlock], lit: &[BlockIrradiance]) {
        for (block, lit) in blocks.iter().zip(lit) {
            for l in 0..block.count {
                let k = block.target[l] as usize;
                let own = Vec3::new(lit.sums[0][l], lit.sums[1][l], lit.sums[2][l]);
                self.value[k] += own * block.share[l];
                self.crosses_shadow_edge[k] |= lit.crosses_shadow_edge;
            }
        }
        let parents = std::mem::take(&mut self.parents);
        let next = |mut parents: Vec<u32>| {
            let mut next = Vec::new();
            for p in parents.drain(..) {
                self.refine_node(p, &mut next);
            }
            next
        };
        self.parents = parents.into_iter().map(next).collect();
        self.begun = true;
    }

    /// Interpolates the texels of `p`, or appends its parts to the nodes that gather `next`.
    fn refine_node(&mut self, p: u32, next: &mut Vec<u32>) {
        let parts = self.receiving_nodes(p);
        if self.begun && self.is_linear(p) {
            self.fill_texels(p);
            return;
        }
        for k in parts {
            if self.tree.nodes[k as usize].children.is_empty() {
                let texel = self.tree.leaves_of(k)[0].texel;
                self.texels[texel as usize] = self.value[k as usize];
            } else {
                next.push(k);
            }
        }
    }

    /// Returns true if the parts of node `p` agree with the linear prediction from it and its siblings.
    fn is_linear(&self, p: u32) -> bool {
        let node = &self.tree.nodes[p as usize];
        let parts = node.children.clone();
        let shadow = parts.clone().any(|k| self.crosses_shadow_edge[k as usize]);
        if shadow || self.covered.contains_covered[p as usize] || parts.is_empty() {
            return false;
        }
        // A whole face has no siblings: equal parts do not imply equal texels. Nor do parts along one side across it.
        if node.level == 0 || !node.divides_both_sides {
            return false;
        }
        if !self.has_light(p) && parts.clone().all(|k| !self.has_light(k)) {
            return true;
        }
        // Siblings that have not gathered, or are dark, predict nothing: the node's four parts alone lie on a plane by
        // chance.
        let mut siblings = self.tree.nodes[node.parent as usize].children.clone();
        if !siblings.all(|k| self.has_light(k)) {
            return false;
        }
        let slope = self.fit_slope(node.parent);
        let scale = (self.scale)(node.face);
        let off = parts.map(|k| {
            let d = self.tree.nodes[k as usize].face_position - node.face_position;
            let change = self.value[k as usize] - self.value[p as usize];
            ((change - linear_change(slope, d)) * scale).abs().max_element()
        });
        off.fold(0.0, f32::max) <= MAX_LINEAR_DEVIATION * self.threshold
    }

    fn has_light(&self, k: u32) -> bool {
        self.value[k as usize] != Vec3::ZERO
    }

    /// Fits a slope to the parts of node `p`.
    fn fit_slope(&self, p: u32) -> [Vec3; 2] {
        let parts: Vec<u32> = self.tree.nodes[p as usize].children.clone().collect();
        fit_linear(self.tree, p, &parts, |k| self.value[k as usize]).slope
    }

    /// Interpolates the texels of node `p` with the slope of its parts.
    fn fill_texels(&mut self, p: u32) {
        let slope = self.fit_slope(p);
        for k in self.tree.nodes[p as usize].children.clone() {
            let value = self.value[k as usize];
            for leaf in self.tree.leaves_of(k) {
                let d = self.tree.nodes[leaf.node as usize].face_position - self.tree.nodes[k as usize].face_position;
                let sloped = value + linear_change(slope, d);
                // Occluded light may be negative: extrapolation keeps the sign.
                let positive = value.cmpge(Vec3::ZERO);
                let (above, below) = (sloped.max(Vec3::ZERO), sloped.min(Vec3::ZERO));
                self.texels[leaf.texel as usize] = Vec3::select(positive, above, below);
            }
        }
    }

    /// Returns H of every texel, the mean over its area.
    pub fn into_texels(self) -> Vec<Vec3> {
        self.texels
    }
}

/// Returns the change along `slope` over the offset `d`.
fn linear_change(slope: [Vec3; 2], d: Vec2) -> Vec3 {
    slope[0] * d.x + slope[1] * d.y
}
