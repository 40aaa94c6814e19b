//! From nodes down to texels: where light is even the nodes' own tells that of their texels; else each
//! part receives for itself (the final gather of Lischinski et al. 1993, only where it is needed).

use crate::hierarchy::block::{Block, Spot};
use crate::hierarchy::light::fit;
use crate::hierarchy::tree::Tree;
use crate::hierarchy::world::EVEN;
use crate::matrix::open::Element;
use crate::rows::lanes::Lane;
use glam::{Vec2, Vec3};
use std::collections::HashMap;
use std::ops::Range;

/// Nodes with which it begins are no larger (the mesh is two units wide at most).
const FIRST: f32 = 0.18;

/// Where bodies stand: texels of which a part is covered, or all.
pub struct Feet {
    /// By node.
    spots: HashMap<u32, Vec<Spot>>,
    /// Nodes that hold such a texel.
    cut: Vec<bool>,
}

impl Feet {
    /// Of the texels' open parts.
    pub fn new(tree: &Tree, feet: &[(u32, Element)]) -> Self {
        let elements: HashMap<u32, &Element> = feet.iter().map(|(k, e)| (*k, e)).collect();
        let mut of_node = HashMap::with_capacity(feet.len());
        let mut cut = vec![false; tree.nodes.len()];
        for leaf in &tree.leaves {
            let Some(element) = elements.get(&leaf.texel) else {
                continue;
            };
            let mut k = leaf.node as usize;
            of_node.insert(leaf.node, spots(tree, leaf.node, element));
            while !cut[k] {
                cut[k] = true;
                k = tree.nodes[k].parent as usize;
            }
        }
        Self {
            spots: of_node,
            cut,
        }
    }

    /// What receives for node `k`: all of it, or the open parts of a texel.
    pub fn of_node(&self, tree: &Tree, k: u32) -> Vec<Spot> {
        if let Some(spots) = self.spots.get(&k) {
            return spots.clone();
        }
        let node = &tree.nodes[k as usize];
        vec![Spot {
            face: node.face,
            target: k,
            share: 1.0,
            corners: node.shooter.corners,
            centre: node.shooter.centre,
        }]
    }
}

fn spots(tree: &Tree, node: u32, element: &Element) -> Vec<Spot> {
    let quads = element.patches.iter().flat_map(|patch| {
        let centre = patch.centre.as_vec3();
        let quads = patch.polygon.quads();
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

/// What a block's lanes receive, and whether a shadow's edge crosses it.
#[derive(Clone)]
pub struct Lit {
    /// H.
    pub sums: [Lane; 3],
    /// Whether its spots may differ by much.
    pub edge: bool,
}

/// Who receives.
pub struct Receiving {
    /// These faces.
    pub faces: Range<usize>,
    /// First nodes of at most this radius.
    pub first: f32,
}

impl Receiving {
    /// The texels of `faces`.
    pub fn on(faces: Range<usize>) -> Self {
        Self {
            faces,
            first: FIRST,
        }
    }

    /// What varies within a ball of `radius` is not passed over.
    pub fn near(self, radius: f32) -> Self {
        Self {
            first: self.first.min(radius),
            ..self
        }
    }
}

/// The way down.
pub struct Descent<'a> {
    tree: &'a Tree,
    feet: &'a Feet,
    /// 1/RMS of the reflected light, times the reflectance of each face.
    scale: &'a dyn Fn(u32) -> Vec3,
    threshold: f32,
    /// H of each node that has received, and whether it may vary by much.
    value: Vec<Vec3>,
    edge: Vec<bool>,
    /// Nodes whose parts receive next, by face.
    parents: Vec<Vec<u32>>,
    begun: bool,
    texels: Vec<Vec3>,
}

impl<'a> Descent<'a> {
    /// To `texels` texels, each face of `receiving` by itself.
    pub fn new(
        tree: &'a Tree,
        feet: &'a Feet,
        scale: &'a dyn Fn(u32) -> Vec3,
        threshold: f32,
        receiving: &Receiving,
        texels: usize,
    ) -> Self {
        let within = |f: usize| match receiving.faces.contains(&f) {
            true => tree.within(f, receiving.first),
            false => Vec::new(),
        };
        Self {
            tree,
            feet,
            scale,
            threshold,
            value: vec![Vec3::ZERO; tree.nodes.len()],
            edge: vec![false; tree.nodes.len()],
            parents: (0..tree.roots.len()).map(within).collect(),
            begun: false,
            texels: vec![Vec3::ZERO; texels],
        }
    }

    /// The spots that receive next, by face; none: all texels have their light.
    pub fn spots(&self) -> Option<Vec<Vec<Spot>>> {
        let nodes = |parents: &Vec<u32>| -> Vec<Spot> {
            let parts = parents.iter().flat_map(|p| self.parts(*p));
            parts
                .flat_map(|k| self.feet.of_node(self.tree, k))
                .collect()
        };
        let spots: Vec<Vec<Spot>> = self.parents.iter().map(nodes).collect();
        spots.iter().any(|spots| !spots.is_empty()).then_some(spots)
    }

    /// What receives of node `p`: first itself, then its parts.
    fn parts(&self, p: u32) -> Range<u32> {
        if self.begun {
            self.tree.nodes[p as usize].children.clone()
        } else {
            p..p + 1
        }
    }

    /// Takes what the blocks of the spots received, and goes on where it is not even.
    pub fn take(&mut self, blocks: &[Block], lit: &[Lit]) {
        for (block, lit) in blocks.iter().zip(lit) {
            for l in 0..block.count {
                let k = block.target[l] as usize;
                let own = Vec3::new(lit.sums[0][l], lit.sums[1][l], lit.sums[2][l]);
                self.value[k] += own * block.share[l];
                self.edge[k] |= lit.edge;
            }
        }
        let parents = std::mem::take(&mut self.parents);
        let next = |mut parents: Vec<u32>| {
            let mut next = Vec::new();
            for p in parents.drain(..) {
                self.go_on(p, &mut next);
            }
            next
        };
        self.parents = parents.into_iter().map(next).collect();
        self.begun = true;
    }

    fn go_on(&mut self, p: u32, next: &mut Vec<u32>) {
        let parts = self.parts(p);
        if self.begun && self.is_even(p) {
            self.fill(p);
            return;
        }
        for k in parts {
            if self.tree.nodes[k as usize].children.is_empty() {
                let texel = self.tree.leaves(k)[0].texel;
                self.texels[texel as usize] = self.value[k as usize];
            } else {
                next.push(k);
            }
        }
    }

    /// Whether the parts of node `p` have what it, and its neighbours, predict.
    fn is_even(&self, p: u32) -> bool {
        let node = &self.tree.nodes[p as usize];
        let parts = node.children.clone();
        let shadow = parts.clone().any(|k| self.edge[k as usize]);
        if shadow || self.feet.cut[p as usize] || parts.is_empty() {
            return false;
        }
        // A whole face has no neighbours that tell: its parts may be alike and theirs not.
        if node.level == 0 {
            return false;
        }
        if !self.has(p) && parts.clone().all(|k| !self.has(k)) {
            return true;
        }
        // Nor has a part whose neighbours are larger and did not receive, or lie in the dark: of itself alone it would
        // be asked whether its four parts lie in a plane, and no more.
        let mut beside = self.tree.nodes[node.parent as usize].children.clone();
        if !beside.all(|k| self.has(k)) {
            return false;
        }
        let slope = self.slope(node.parent);
        let scale = (self.scale)(node.face);
        let off = parts.map(|k| {
            let d = self.tree.nodes[k as usize].place - node.place;
            let found = self.value[k as usize] - self.value[p as usize];
            ((found - along(slope, d)) * scale).abs().max_element()
        });
        off.fold(0.0, f32::max) <= EVEN * self.threshold
    }

    /// Whether a node has received light.
    fn has(&self, k: u32) -> bool {
        self.value[k as usize] != Vec3::ZERO
    }

    /// The slope of the parts of node `p`.
    fn slope(&self, p: u32) -> [Vec3; 2] {
        let parts: Vec<u32> = self.tree.nodes[p as usize].children.clone().collect();
        fit(self.tree, p, &parts, |k| self.value[k as usize]).slope
    }

    /// The texels of node `p` along the slope of its parts.
    fn fill(&mut self, p: u32) {
        let slope = self.slope(p);
        for k in self.tree.nodes[p as usize].children.clone() {
            let value = self.value[k as usize];
            for leaf in self.tree.leaves(k) {
                let d =
                    self.tree.nodes[leaf.node as usize].place - self.tree.nodes[k as usize].place;
                let sloped = value + along(slope, d);
                // Of what was taken away the sign is the other one.
                let light = value.cmpge(Vec3::ZERO);
                let (lit, taken) = (sloped.max(Vec3::ZERO), sloped.min(Vec3::ZERO));
                self.texels[leaf.texel as usize] = Vec3::select(light, lit, taken);
            }
        }
    }

    /// H of every texel, the mean over its area.
    pub fn texels(self) -> Vec<Vec3> {
        self.texels
    }
}

fn along(slope: [Vec3; 2], d: Vec2) -> Vec3 {
    slope[0] * d.x + slope[1] * d.y
}
