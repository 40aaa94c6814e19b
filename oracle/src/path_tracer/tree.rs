//! Bounding volume hierarchy over triangles, split at the median, in f64. It is independent of the solvers' one, so
//! that the tracer shares no intersection code with them.

use glam::DVec3;

/// Largest number of items of a leaf.
const MAX_LEAF_ITEMS: usize = 4;
/// Margin of the boxes as a share of the scene's extent, far more than rounding.
const BOX_MARGIN: f64 = 1e-9;

struct Node {
    low: DVec3,
    high: DVec3,
    /// Items of a leaf, else none.
    items: std::ops::Range<usize>,
    /// Index of the node after this one's subtree.
    next: usize,
}

/// Nodes in depth-first order.
pub struct BoxTree {
    nodes: Vec<Node>,
    order: Vec<usize>,
}

impl BoxTree {
    /// Builds the hierarchy over the boxes of items.
    pub fn new(boxes: &[[DVec3; 2]], extent: f64) -> Self {
        let mut tree = Self {
            nodes: Vec::new(),
            order: (0..boxes.len()).collect(),
        };
        tree.build_node(boxes, 0..boxes.len(), BOX_MARGIN * extent);
        tree
    }

    fn build_node(&mut self, boxes: &[[DVec3; 2]], items: std::ops::Range<usize>, margin: f64) {
        let of = |k: &usize| boxes[*k];
        let own = &mut self.order[items.clone()];
        let low = own.iter().fold(DVec3::INFINITY, |a, k| a.min(of(k)[0]));
        let high = own.iter().fold(DVec3::NEG_INFINITY, |a, k| a.max(of(k)[1]));
        let node = self.nodes.len();
        let leaf = items.len() <= MAX_LEAF_ITEMS;
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
            self.build_node(boxes, items.start..half, margin);
            self.build_node(boxes, half..items.end, margin);
        }
        self.nodes[node].next = self.nodes.len();
    }

    /// Calls `meet` for each item whose box the ray enters before `end`, which `meet` may reduce.
    pub fn visit_boxes(&self, origin: DVec3, along: DVec3, end: &mut f64, mut meet: impl FnMut(usize, &mut f64)) {
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
