//! Welds the border nodes of neighbouring faces that form one surface, so that the interpolation has no step there.
//!
//! Faces with touching borders and similar normals are neighbours. On a common border each face gets the other's
//! nodes: coinciding nodes are merged, any other becomes a hanging node that both faces use as a knot. Both then
//! interpolate linearly between the same knots of equal value.

use crate::report::view::face_grid::FaceGrid;
use common::scene::Face;
use glam::DVec3;
use std::collections::HashMap;

/// Points closer than this coincide (mesh units): some roundings of an f32 coordinate.
pub const WELD_DISTANCE: f64 = 1e-5;
/// Minimum cosine (1.1°) between normals of one plane: nearly planar quads are split into triangles that differ by less.
pub const MIN_COPLANAR_COSINE: f64 = 0.9998;
/// Minimum cosine (40°) between the normals of two faces that approximate one curved surface.
const MIN_CURVED_COSINE: f64 = 0.766;
/// Minimum cosine (2°) between shading normals that are equal up to rounding.
const EQUAL_NORMAL_COSINE: f32 = 0.9994;

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

/// Returns whether two faces with a common edge form one smooth surface: by their normals, or by the shading normals
/// at common corners where the file has them.
fn is_smooth(faces: [&Face; 2], cosine: f64) -> bool {
    let [a, b] = faces;
    let (Some(first), Some(second)) = (a.corner_normals, b.corner_normals) else {
        return cosine >= MIN_CURVED_COSINE;
    };
    let own = a.corners.iter().zip(first);
    let shared = own.flat_map(|(p, n)| {
        let other = b.corners.iter().zip(second);
        other.filter(move |(q, _)| p == *q).map(move |(_, m)| n.dot(m))
    });
    match shared.fold(f32::INFINITY, f32::min) {
        // No common corner: one face divides the other's edge.
        f32::INFINITY => cosine >= MIN_CURVED_COSINE,
        least => cosine >= MIN_COPLANAR_COSINE || least >= EQUAL_NORMAL_COSINE,
    }
}

/// Returns the pairs of faces that touch, form one surface and may be welded by `welds(a, b)`.
pub fn find_neighbours(faces: &[Face], grids: &[FaceGrid], welds: impl Fn(u32, u32) -> bool) -> Vec<(u32, u32)> {
    let joins = |a: u32, b: u32| {
        let cosine = grids[a as usize].normal.dot(grids[b as usize].normal);
        let is_surface = match (faces.get(a as usize), faces.get(b as usize)) {
            (Some(a), Some(b)) => is_smooth([a, b], cosine),
            _ => cosine >= MIN_CURVED_COSINE,
        };
        is_surface && welds(a, b)
    };
    let (mut pairs, lone) = pair_equal_edges(grids, joins);
    let boxes: HashMap<u32, [DVec3; 2]> = lone.iter().map(|k| (*k, padded_bounds(&grids[*k as usize]))).collect();
    let mut order = lone;
    order.sort_by(|a, b| boxes[a][0].x.total_cmp(&boxes[b][0].x));
    for (at, &a) in order.iter().enumerate() {
        let [low, high] = boxes[&a];
        let others = order[at + 1..].iter().take_while(|b| boxes[*b][0].x <= high.x);
        let touches = |b: &u32| boxes[b][0].cmple(high).all() && boxes[b][1].cmpge(low).all();
        pairs.extend(
            others
                .filter(|b| touches(b) && joins(a, **b))
                .map(|b| (a.min(*b), a.max(*b))),
        );
    }
    pairs.sort_unstable();
    pairs.dedup();
    pairs
}

/// Returns the pairs of faces that have an edge with the same two corners and that `joins` accepts, and the faces with
/// another edge.
fn pair_equal_edges(grids: &[FaceGrid], joins: impl Fn(u32, u32) -> bool) -> (Vec<(u32, u32)>, Vec<u32>) {
    let mut edges: Vec<([[u64; 3]; 2], u32)> = Vec::new();
    for (face, grid) in (0..).zip(grids).filter(|(_, grid)| grid.normal != DVec3::ZERO) {
        // Adding 0 makes −0 to 0.
        let ends = |k: usize| grid.edge_ends(k).map(|p| p.to_array().map(|x| (x + 0.0).to_bits()));
        edges.extend((0..grid.edge_count()).map(|k| {
            let [a, b] = ends(k);
            ([a.min(b), a.max(b)], face)
        }));
    }
    edges.sort_unstable();
    let (mut pairs, mut lone) = (Vec::new(), Vec::new());
    for group in edges.chunk_by(|a, b| a.0 == b.0) {
        if group.len() == 1 {
            lone.push(group[0].1);
        }
        for (k, (_, a)) in group.iter().enumerate() {
            let others = group[k + 1..].iter().map(|(_, b)| *b);
            pairs.extend(others.filter(|b| a != b && joins(*a, *b)).map(|b| (*a, b)));
        }
    }
    lone.sort_unstable();
    lone.dedup();
    (pairs, lone)
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
