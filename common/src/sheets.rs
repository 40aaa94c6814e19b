//! Sheets: faces that coincide with faces of opposite fronts, as thin walls are often modelled. Neither side occludes the
//! other.
//!
//! A side is a face, or two triangles that form a quad: the sides may be cut along different diagonals.

use crate::face::{CornerBits, MeshFace, corner_bits};
use crate::overlap::SAME_PLANE_DISTANCE;
use glam::Vec3;
use rayon::prelude::*;
use std::collections::HashMap;

/// Largest number of triangles at an edge of which pairs are searched: those of both sides of four walls.
const MAX_TRIANGLES_AT_EDGE: usize = 8;

/// One side of a sheet.
struct SheetSide {
    /// Its one or two faces.
    faces: [usize; 2],
    /// Its corners, in ascending order.
    corners: [CornerBits; 4],
}

/// An edge of a triangle.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct TriangleEdge {
    /// Its ends, in ascending order.
    ends: [CornerBits; 2],
    face: usize,
    /// Number of its first corner in the triangle.
    first: usize,
}

/// Joins sides with the same corners and opposite fronts to sheets: single faces first. Pairs of triangles that are left then
/// have the same corners only if they cut a quad along different diagonals.
pub fn join_sheets(faces: &mut [MeshFace]) {
    let whole = |faces: &[MeshFace], k: usize| SheetSide {
        faces: [k; 2],
        corners: faces[k].sorted_corner_bits(),
    };
    let singles = (0..faces.len()).map(|k| whole(faces, k)).collect();
    join_sides(faces, singles);
    let is_quad = |k: &usize| !faces[*k].two_sided && !faces[*k].is_triangle();
    let quads = (0..faces.len()).filter(is_quad).map(|k| whole(faces, k));
    let sides = quads.chain(pair_triangles(faces)).collect();
    join_sides(faces, sides);
}

/// Joins each side that no sheet has yet with the first of the same corners, if its front is opposite.
fn join_sides(faces: &mut [MeshFace], sides: Vec<SheetSide>) {
    let mut first: HashMap<[CornerBits; 4], [usize; 2]> = HashMap::new();
    for side in sides {
        let other = *first.entry(side.corners).or_insert(side.faces);
        let opposite = faces[other[0]].normal.dot(faces[side.faces[0]].normal) < 0.0;
        let all = [other, side.faces].into_iter().flatten();
        if opposite && all.clone().all(|k| !faces[k].two_sided) {
            let sheet = all.clone().map(|k| faces[k].sheet).min().unwrap_or_default();
            for k in all {
                (faces[k].sheet, faces[k].two_sided) = (sheet, true);
            }
        }
    }
}

/// Returns the quads of two triangles that no sheet has, of one plane and with fronts alike.
fn pair_triangles(faces: &[MeshFace]) -> Vec<SheetSide> {
    let is_free = |k: &usize| !faces[*k].two_sided && faces[*k].is_triangle() && faces[*k].normal != Vec3::ZERO;
    let mut edges: Vec<TriangleEdge> = (0..faces.len())
        .filter(is_free)
        .flat_map(|face| {
            (0..3).map(move |first| {
                let mut ends = [first, (first + 1) % 3].map(|c| corner_bits(faces[face].corners[c]));
                ends.sort_unstable();
                TriangleEdge { ends, face, first }
            })
        })
        .collect();
    edges.par_sort_unstable();
    let mut pairs = Vec::new();
    for at_edge in edges.chunk_by(|a, b| a.ends == b.ends) {
        if at_edge.len() > MAX_TRIANGLES_AT_EDGE {
            continue;
        }
        for (n, a) in at_edge.iter().enumerate() {
            pairs.extend(at_edge[n + 1..].iter().filter_map(|b| pair_at_edge(faces, a, b)));
        }
    }
    pairs
}

/// Returns the quad of two triangles at a common edge, if they form one.
fn pair_at_edge(faces: &[MeshFace], a: &TriangleEdge, b: &TriangleEdge) -> Option<SheetSide> {
    let [own, other] = [a, b].map(|edge| &faces[edge.face]);
    let alike = own.normal.dot(other.normal) > 1.0 - SAME_PLANE_DISTANCE;
    let corner = |edge: &TriangleEdge, n: usize| faces[edge.face].corners[(edge.first + n) % 3];
    let [from, to, apex, far] = [corner(a, 0), corner(a, 1), corner(a, 2), corner(b, 2)];
    if !alike || corner(b, 0) != to {
        return None;
    }
    let mut corners = [from, to, apex, far].map(corner_bits);
    corners.sort_unstable();
    Some(SheetSide {
        faces: [a.face, b.face],
        corners,
    })
}
