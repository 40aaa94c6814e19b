//! Nodes shared by coplanar faces that touch, so that the interpolation has no step there.
//!
//! Faces whose fronts look the same way and whose borders touch are neighbours. On a shared
//! border each gets the other's nodes: one node where two coincide, else a hanging node that
//! both use as a knot. Both then interpolate linearly between the same knots of equal value.

use crate::show::view::patch::Patch;
use glam::DVec3;

/// Points closer than this are one (mesh units): some roundings of an f32 coordinate.
pub const TOLERANCE: f64 = 1e-5;
/// Cosine of the largest angle (1.1°) between the normals of neighbours: nearly planar quads are
/// split into triangles that differ by less.
pub const COSINE: f64 = 0.9998;

/// A node of a neighbour on an edge of a face.
#[derive(Clone, Copy, Debug)]
pub struct Knot {
    /// Share of the edge's length, from its first corner.
    pub s: f64,
    /// The value that it takes.
    pub slot: u32,
}

/// Which nodes share a value.
#[derive(Clone, Debug)]
pub struct Joints {
    /// The value of each node.
    pub slots: Vec<u32>,
    /// How many values.
    pub count: usize,
    /// Hanging nodes by rising s, edge k of face f at 4f + k.
    pub hanging: Vec<Vec<Knot>>,
}

/// Pairs of faces whose bounding boxes touch and whose normals' cosine is at least what `least`
/// asks of these two (more than 1: never).
pub fn neighbours(patches: &[Patch], least: impl Fn(u32, u32) -> f64) -> Vec<(u32, u32)> {
    let boxes: Vec<[DVec3; 2]> = patches.iter().map(bounds).collect();
    let mut order: Vec<u32> = (0..patches.len() as u32)
        .filter(|k| patches[*k as usize].normal != DVec3::ZERO)
        .collect();
    order.sort_by(|a, b| boxes[*a as usize][0].x.total_cmp(&boxes[*b as usize][0].x));
    let mut pairs = Vec::new();
    for (at, &a) in order.iter().enumerate() {
        let [low, high] = boxes[a as usize];
        let normal = patches[a as usize].normal;
        for &b in &order[at + 1..] {
            let other = boxes[b as usize];
            if other[0].x > high.x {
                break;
            }
            let touch = other[0].cmple(high).all() && other[1].cmpge(low).all();
            if touch && patches[b as usize].normal.dot(normal) >= least(a, b) {
                pairs.push((a, b));
            }
        }
    }
    pairs
}

fn bounds(patch: &Patch) -> [DVec3; 2] {
    let low = patch
        .corners
        .into_iter()
        .reduce(DVec3::min)
        .unwrap_or_default();
    let high = patch
        .corners
        .into_iter()
        .reduce(DVec3::max)
        .unwrap_or_default();
    [low - TOLERANCE, high + TOLERANCE]
}

/// Where on edge `k` a point lies, if it does.
pub fn on_edge(patch: &Patch, k: usize, point: DVec3) -> Option<f64> {
    let [a, b] = patch.edge(k);
    let along = b - a;
    let s = ((point - a).dot(along) / along.length_squared()).clamp(0.0, 1.0);
    ((a + along * s).distance_squared(point) <= TOLERANCE * TOLERANCE).then_some(s)
}

/// Joins the borders of `pairs`; without pairs every face stands alone.
pub fn weld(patches: &[Patch], nodes: usize, pairs: &[(u32, u32)]) -> Joints {
    let mut foreign: Vec<Vec<(f64, u32)>> = vec![Vec::new(); 4 * patches.len()];
    for &(a, b) in pairs {
        collect(patches, a, b, &mut foreign);
        collect(patches, b, a, &mut foreign);
    }
    let mut union = Union((0..nodes as u32).collect());
    let mut hanging: Vec<Vec<Knot>> = vec![Vec::new(); foreign.len()];
    for (edge, knots) in foreign
        .into_iter()
        .enumerate()
        .filter(|(_, knots)| !knots.is_empty())
    {
        hanging[edge] = merge(&patches[edge / 4], edge % 4, knots, &mut union);
    }
    let (slots, count) = union.slots();
    for knot in hanging.iter_mut().flatten() {
        knot.slot = slots[knot.slot as usize];
    }
    Joints {
        slots,
        count,
        hanging,
    }
}

/// Notes the border nodes of face `a` that lie on edges of face `b`.
fn collect(patches: &[Patch], a: u32, b: u32, foreign: &mut [Vec<(f64, u32)>]) {
    let (from, to) = (&patches[a as usize], &patches[b as usize]);
    let [low, high] = bounds(to);
    for (_, node) in (0..from.edges()).flat_map(|k| from.border(k)) {
        let point = from.position(node);
        if point.cmplt(low).any() || point.cmpgt(high).any() {
            continue;
        }
        for k in 0..to.edges() {
            if let Some(s) = on_edge(to, k, point) {
                foreign[4 * b as usize + k].push((s, from.index(node) as u32));
            }
        }
    }
}

/// Joins what coincides on an edge; what coincides with no node of the edge's own hangs.
fn merge(patch: &Patch, k: usize, foreign: Vec<(f64, u32)>, union: &mut Union) -> Vec<Knot> {
    let own = patch
        .border(k)
        .map(|(s, node)| (s, patch.index(node) as u32, true));
    let mut knots: Vec<(f64, u32, bool)> = own
        .chain(foreign.into_iter().map(|(s, node)| (s, node, false)))
        .collect();
    knots.sort_by(|a, b| a.0.total_cmp(&b.0));
    let [a, b] = patch.edge(k);
    let near = TOLERANCE / a.distance(b).max(TOLERANCE);
    let mut hanging = Vec::new();
    for cluster in knots.chunk_by(|a, b| b.0 - a.0 <= near) {
        for knot in cluster {
            union.join(cluster[0].1, knot.1);
        }
        if !cluster.iter().any(|knot| knot.2) {
            hanging.push(Knot {
                s: cluster[0].0,
                slot: cluster[0].1,
            });
        }
    }
    hanging
}

/// Sets of nodes; the lowest names the set, so that nothing hangs on the order of joining.
struct Union(Vec<u32>);

impl Union {
    fn root(&mut self, mut k: u32) -> u32 {
        while self.0[k as usize] != k {
            let parent = self.0[k as usize];
            self.0[k as usize] = self.0[parent as usize];
            k = parent;
        }
        k
    }

    fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a.max(b) as usize] = a.min(b);
    }

    /// Consecutive numbers of the sets, and how many there are.
    fn slots(mut self) -> (Vec<u32>, usize) {
        let mut slots = vec![0; self.0.len()];
        let mut count = 0;
        for k in 0..self.0.len() as u32 {
            let root = self.root(k);
            // A root is the lowest of its set: its number is already known.
            if root == k {
                slots[k as usize] = count;
                count += 1;
            } else {
                slots[k as usize] = slots[root as usize];
            }
        }
        (slots, count as usize)
    }
}
