//! Welds the border nodes of touching coplanar faces, so that the interpolation has no step there.
//!
//! Faces with equal normals and touching borders are neighbours. On a common border each face gets the other's
//! nodes: coinciding nodes are merged, any other becomes a hanging node that both faces use as a knot. Both then
//! interpolate linearly between the same knots of equal value.

use crate::report::view::face_grid::FaceGrid;
use glam::DVec3;

/// Points closer than this coincide (mesh units): some roundings of an f32 coordinate.
pub const WELD_DISTANCE: f64 = 1e-5;
/// Minimum cosine (1.1°) between the normals of neighbours: nearly planar quads are split into triangles that
/// differ by less.
pub const MIN_COPLANAR_COSINE: f64 = 0.9998;

/// Neighbour's node on an edge of a face.
#[derive(Clone, Copy, Debug)]
pub struct EdgeKnot {
    /// Share of the edge's length from its first corner.
    pub s: f64,
    /// Value slot.
    pub slot: u32,
}

/// Assignment of nodes to shared values.
#[derive(Clone, Debug)]
pub struct WeldedNodes {
    /// Value slot of each node: the first node that coincides with it.
    pub slots: Vec<u32>,
    /// Hanging nodes in order of s; edge k of face f is entry 4f + k.
    pub hanging: Vec<Vec<EdgeKnot>>,
}

/// Returns the pairs of faces whose bounding boxes touch and whose normals' cosine is at least `least(a, b)`
/// (above 1: never).
pub fn find_neighbours(grids: &[FaceGrid], least: impl Fn(u32, u32) -> f64) -> Vec<(u32, u32)> {
    let boxes: Vec<[DVec3; 2]> = grids.iter().map(padded_bounds).collect();
    let mut order: Vec<u32> = (0..grids.len() as u32)
        .filter(|k| grids[*k as usize].normal != DVec3::ZERO)
        .collect();
    order.sort_by(|a, b| boxes[*a as usize][0].x.total_cmp(&boxes[*b as usize][0].x));
    let mut pairs = Vec::new();
    for (at, &a) in order.iter().enumerate() {
        let [low, high] = boxes[a as usize];
        let normal = grids[a as usize].normal;
        for &b in &order[at + 1..] {
            let other = boxes[b as usize];
            if other[0].x > high.x {
                break;
            }
            let touch = other[0].cmple(high).all() && other[1].cmpge(low).all();
            if touch && grids[b as usize].normal.dot(normal) >= least(a, b) {
                pairs.push((a, b));
            }
        }
    }
    pairs
}

/// Returns the bounding box of a face, enlarged by the tolerance.
fn padded_bounds(grid: &FaceGrid) -> [DVec3; 2] {
    let low = grid.corners.into_iter().reduce(DVec3::min).unwrap_or_default();
    let high = grid.corners.into_iter().reduce(DVec3::max).unwrap_or_default();
    [low - WELD_DISTANCE, high + WELD_DISTANCE]
}

/// Returns the share of edge `k` at which a point lies, if it lies on that edge.
pub fn position_on_edge(grid: &FaceGrid, k: usize, point: DVec3) -> Option<f64> {
    let [a, b] = grid.edge_ends(k);
    let along = b - a;
    let s = ((point - a).dot(along) / along.length_squared()).clamp(0.0, 1.0);
    ((a + along * s).distance_squared(point) <= WELD_DISTANCE * WELD_DISTANCE).then_some(s)
}

/// Welds the borders of `pairs`.
pub fn weld_borders(grids: &[FaceGrid], nodes: usize, pairs: &[(u32, u32)]) -> WeldedNodes {
    let mut foreign: Vec<Vec<(f64, u32)>> = vec![Vec::new(); 4 * grids.len()];
    for &(a, b) in pairs {
        collect_border_nodes(grids, a, b, &mut foreign);
        collect_border_nodes(grids, b, a, &mut foreign);
    }
    let mut union = DisjointSets((0..nodes as u32).collect());
    let mut hanging: Vec<Vec<EdgeKnot>> = vec![Vec::new(); foreign.len()];
    for (edge, knots) in foreign.into_iter().enumerate().filter(|(_, knots)| !knots.is_empty()) {
        hanging[edge] = merge_edge_nodes(&grids[edge / 4], edge % 4, knots, &mut union);
    }
    let slots: Vec<u32> = (0..nodes as u32).map(|node| union.find_root(node)).collect();
    for knot in hanging.iter_mut().flatten() {
        knot.slot = slots[knot.slot as usize];
    }
    WeldedNodes { slots, hanging }
}

/// Collects the border nodes of face `a` that lie on edges of face `b`.
fn collect_border_nodes(grids: &[FaceGrid], a: u32, b: u32, foreign: &mut [Vec<(f64, u32)>]) {
    let (from, to) = (&grids[a as usize], &grids[b as usize]);
    let [low, high] = padded_bounds(to);
    for (_, node) in (0..from.edge_count()).flat_map(|k| from.edge_nodes(k)) {
        let point = from.node_position(node);
        if point.cmplt(low).any() || point.cmpgt(high).any() {
            continue;
        }
        for k in 0..to.edge_count() {
            if let Some(s) = position_on_edge(to, k, point) {
                foreign[4 * b as usize + k].push((s, from.node_index(node) as u32));
            }
        }
    }
}

/// Merges coinciding nodes of an edge; returns the foreign nodes without a coinciding own node as hanging nodes.
fn merge_edge_nodes(grid: &FaceGrid, k: usize, foreign: Vec<(f64, u32)>, union: &mut DisjointSets) -> Vec<EdgeKnot> {
    let own = grid
        .edge_nodes(k)
        .map(|(s, node)| (s, grid.node_index(node) as u32, true));
    let mut knots: Vec<(f64, u32, bool)> = own
        .chain(foreign.into_iter().map(|(s, node)| (s, node, false)))
        .collect();
    knots.sort_by(|a, b| a.0.total_cmp(&b.0));
    let [a, b] = grid.edge_ends(k);
    let near = WELD_DISTANCE / a.distance(b).max(WELD_DISTANCE);
    let mut hanging = Vec::new();
    for cluster in knots.chunk_by(|a, b| b.0 - a.0 <= near) {
        for knot in cluster {
            union.join_sets(cluster[0].1, knot.1);
        }
        if !cluster.iter().any(|knot| knot.2) {
            hanging.push(EdgeKnot {
                s: cluster[0].0,
                slot: cluster[0].1,
            });
        }
    }
    hanging
}

/// Union–find over numbers; the lowest of a set names it, so the result is independent of the order of joining.
pub struct DisjointSets(pub Vec<u32>);

impl DisjointSets {
    /// Returns the lowest number of the set of `k`.
    pub fn find_root(&mut self, mut k: u32) -> u32 {
        while self.0[k as usize] != k {
            self.0[k as usize] = self.0[self.0[k as usize] as usize];
            k = self.0[k as usize];
        }
        k
    }

    /// Joins the sets of two numbers.
    pub fn join_sets(&mut self, a: u32, b: u32) {
        let (a, b) = (self.find_root(a), self.find_root(b));
        self.0[a.max(b) as usize] = a.min(b);
    }
}
