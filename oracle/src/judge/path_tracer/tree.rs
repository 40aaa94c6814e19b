//! Boxes around triangles, halved at their middle until few are left: which of them a ray may meet.
//! Its own, in f64, so that the tracer shares no intersection with the solvers that it judges.

use glam::DVec3;

/// Items of a leaf.
const LEAF: usize = 4;
/// Boxes grow by this share of the extent, far more than rounding.
const MARGIN: f64 = 1e-9;

struct Node {
    low: DVec3,
    high: DVec3,
    /// Items of a leaf, else none.
    items: std::ops::Range<usize>,
    /// The node after this one and all below it.
    next: usize,
}

/// Nodes in depth-first order.
pub struct Tree {
    nodes: Vec<Node>,
    order: Vec<usize>,
}

impl Tree {
    /// Around the boxes of items.
    pub fn new(boxes: &[[DVec3; 2]], extent: f64) -> Self {
        let mut tree = Self {
            nodes: Vec::new(),
            order: (0..boxes.len()).collect(),
        };
        tree.split(boxes, 0..boxes.len(), MARGIN * extent);
        tree
    }

    fn split(&mut self, boxes: &[[DVec3; 2]], items: std::ops::Range<usize>, margin: f64) {
        let of = |k: &usize| boxes[*k];
        let own = &mut self.order[items.clone()];
        let low = own.iter().fold(DVec3::INFINITY, |a, k| a.min(of(k)[0]));
        let high = own.iter().fold(DVec3::NEG_INFINITY, |a, k| a.max(of(k)[1]));
        let node = self.nodes.len();
        let leaf = items.len() <= LEAF;
        self.nodes.push(Node {
            low: low - margin,
            high: high + margin,
            items: if leaf { items.clone() } else { 0..0 },
            next: 0,
        });
        if !leaf {
            let axis = (high - low).max_position();
            let middle = |k: &usize| of(k)[0][axis] + of(k)[1][axis];
            own.sort_by(|a, b| middle(a).total_cmp(&middle(b)));
            let half = items.start + items.len() / 2;
            self.split(boxes, items.start..half, margin);
            self.split(boxes, half..items.end, margin);
        }
        self.nodes[node].next = self.nodes.len();
    }

    /// Tells `meet` of each item whose box the ray enters before `end`, which it may bring nearer.
    pub fn walk(
        &self,
        origin: DVec3,
        along: DVec3,
        end: &mut f64,
        mut meet: impl FnMut(usize, &mut f64),
    ) {
        let inverse = 1.0 / along;
        let mut k = 0;
        while let Some(node) = self.nodes.get(k) {
            let [a, b] = [node.low, node.high].map(|side| (side - origin) * inverse);
            let enters = a.min(b).max_element().max(0.0);
            let leaves = a.max(b).min_element();
            if enters > leaves || enters > *end {
                k = node.next;
                continue;
            }
            for item in &self.order[node.items.clone()] {
                meet(*item, end);
            }
            k += 1;
        }
    }
}
