//! Traversal of the BVH of eight quantised boxes a node (Ylitie, Karras & Laine 2017), as the GPU does it.
//! The solvers of the CPU traverse the same nodes by `obvhs`, whose results the test compares.

pub use common::rays::safe_inverse;

use common::constants::RAY_STACK_LEVELS;
use glam::Vec3;
use obvhs::cwbvh::node::CwBvhNode;

/// A ray from `origin` that ends where its parameter is `reach`.
#[derive(Clone, Copy, Debug)]
pub struct BoxRay {
    /// Start.
    pub origin: Vec3,
    /// 1/direction.
    pub inverse: Vec3,
    /// Largest parameter.
    pub reach: f32,
}

/// Groups of children yet to visit.
pub struct Traversal<'a> {
    nodes: &'a [CwBvhNode],
    /// Number of the first child, and two bit masks: the hit ones over those that are nodes.
    waiting: Vec<[u32; 2]>,
    siblings: [u32; 2],
}

/// Returns the ray from `origin` to `origin` + `reach` × `direction`.
pub fn make_ray(origin: Vec3, direction: Vec3, reach: f32) -> BoxRay {
    BoxRay {
        origin,
        inverse: direction.map(safe_inverse),
        reach,
    }
}

/// Returns byte `k` of two words.
fn packed_byte(words: [u32; 2], k: u32) -> u32 {
    (words[(k >> 2) as usize] >> ((k & 3) * 8)) & 0xff
}

/// Returns the bounds of child `k` along one axis, near and far as the ray comes.
fn slab_interval([low, high]: [[u32; 2]; 2], k: u32, scale: f32, start: f32) -> [f32; 2] {
    let low = packed_byte(low, k) as f32 * scale + start;
    let high = packed_byte(high, k) as f32 * scale + start;
    [low.min(high), low.max(high)]
}

/// Starts at the root of `nodes`.
pub fn begin_traversal(nodes: &[CwBvhNode]) -> Traversal<'_> {
    Traversal {
        nodes,
        waiting: Vec::new(),
        siblings: [0, 0x101],
    }
}

impl Traversal<'_> {
    /// Takes the next node of the current group; its siblings wait.
    pub fn next_node(&mut self) -> u32 {
        let child = (self.siblings[1] >> 8).trailing_zeros();
        self.siblings[1] &= !(0x100 << child);
        let below = (self.siblings[1] & 0xff & ((1 << child) - 1)).count_ones();
        let node = self.siblings[0] + below;
        if self.siblings[1] >> 8 != 0 && self.waiting.len() < RAY_STACK_LEVELS as usize {
            self.waiting.push(self.siblings);
        }
        node
    }

    /// Returns the children that are nodes, a bit each.
    pub fn inner_children(&self, node: u32) -> u32 {
        u32::from(self.nodes[node as usize].imask)
    }

    /// Returns the children whose boxes the ray meets, a bit each.
    pub fn hit_children(&self, node: u32, ray: &BoxRay) -> u32 {
        let node = &self.nodes[node as usize];
        let exponents = Vec3::from(node.e.map(|e| f32::from_bits(u32::from(e) << 23)));
        let scale = exponents * ray.inverse;
        let start = (node.p - ray.origin) * ray.inverse;
        let axes = [
            [node.child_min_x, node.child_max_x],
            [node.child_min_y, node.child_max_y],
            [node.child_min_z, node.child_max_z],
        ];
        let bounds = axes.map(|axis| axis.map(words_of_bytes));
        let kinds = words_of_bytes(node.child_meta);
        let mut hits = 0;
        for k in 0..8 {
            let x = slab_interval(bounds[0], k, scale.x, start.x);
            let y = slab_interval(bounds[1], k, scale.y, start.y);
            let z = slab_interval(bounds[2], k, scale.z, start.z);
            let near = x[0].max(y[0]).max(z[0].max(0.0));
            let far = x[1].min(y[1]).min(z[1].min(ray.reach));
            if near <= far && packed_byte(kinds, k) != 0 {
                hits |= 1 << k;
            }
        }
        hits
    }

    /// Returns the primitives of a leaf, first and count: in unary over the offset of the first.
    pub fn leaf_primitives(&self, node: u32, child: u32) -> [u32; 2] {
        let node = &self.nodes[node as usize];
        let kind = packed_byte(words_of_bytes(node.child_meta), child);
        [node.primitive_base_idx + (kind & 31), (kind >> 5).count_ones()]
    }

    /// Continues with the hit children that are nodes, or with the groups that wait; false when none is left.
    pub fn continue_traversal(&mut self, node: u32, hits: u32) -> bool {
        let inner = self.inner_children(node);
        if hits & inner != 0 {
            let first = self.nodes[node as usize].child_base_idx;
            self.siblings = [first, (hits & inner) << 8 | inner];
            return true;
        }
        let Some(siblings) = self.waiting.pop() else {
            return false;
        };
        self.siblings = siblings;
        true
    }
}

/// Returns eight bytes as the two words that a shader reads.
fn words_of_bytes([a, b, c, d, e, f, g, h]: [u8; 8]) -> [u32; 2] {
    [[a, b, c, d], [e, f, g, h]].map(u32::from_le_bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use obvhs::BvhBuildParams;
    use obvhs::aabb::Aabb;
    use obvhs::cwbvh::builder::build_cwbvh;
    use obvhs::ray::Ray;
    use std::time::Duration;

    fn random(state: &mut u32) -> f32 {
        *state = common::sampling::pcg_hash(*state);
        *state as f32 / u32::MAX as f32
    }

    fn primitives_met(nodes: &[CwBvhNode], ray: &BoxRay) -> Vec<u32> {
        let mut traversal = begin_traversal(nodes);
        let mut met = Vec::new();
        loop {
            let node = traversal.next_node();
            let hits = traversal.hit_children(node, ray);
            let leaves = hits & !traversal.inner_children(node);
            for child in (0..8).filter(|k| leaves & (1 << k) != 0) {
                let [first, count] = traversal.leaf_primitives(node, child);
                met.extend(first..first + count);
            }
            if !traversal.continue_traversal(node, hits) {
                met.sort_unstable();
                return met;
            }
        }
    }

    #[test]
    fn traversal_meets_the_boxes_that_obvhs_meets() {
        let mut state = 7;
        let boxes: Vec<Aabb> = (0..300)
            .map(|_| {
                let low = Vec3::from([(); 3].map(|()| random(&mut state)));
                let size = Vec3::from([(); 3].map(|()| 0.1 * random(&mut state)));
                Aabb::new(low.into(), (low + size).into())
            })
            .collect();
        let mut time = Duration::ZERO;
        let tree = build_cwbvh(&boxes, BvhBuildParams::medium_build(), &mut time);
        for _ in 0..200 {
            let origin = Vec3::from([(); 3].map(|()| 3.0 * random(&mut state) - 1.0));
            let target = Vec3::from([(); 3].map(|()| random(&mut state)));
            let direction = target - origin;
            let mut expected = Vec::new();
            tree.ray_traverse_anyhit(Ray::new(origin.into(), direction.into(), 0.0, 1e9), |_, primitive| {
                expected.push(primitive as u32)
            });
            expected.sort_unstable();
            let met = primitives_met(&tree.nodes, &make_ray(origin, direction, 1e9));
            // A box that is only touched may count for one of them.
            let both = met.iter().filter(|k| expected.contains(k)).count();
            assert!(
                met.len() - both <= 1 && expected.len() - both <= 1,
                "{met:?} {expected:?}"
            );
        }
    }
}
