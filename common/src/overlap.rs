//! Overlapping fronts: coplanar, with one orientation. Light that reaches one of them reaches the other, so
//! light that both reflect would count twice, and between white walls the solve would not converge. The
//! first face in the file receives and shoots the light; the others are covered by it.

use crate::face::MeshFace;
use crate::texel::Texel;
use glam::{Vec3, Vec4};
use std::collections::HashMap;
use std::ops::Range;

/// Distance below which planes are the same, width below which overlaps are ignored (mesh units), and largest 1 − cosine
/// between equal normals: a file's coordinates have about six digits.
const SAME_PLANE_DISTANCE: f32 = 1e-5;
/// Maximum pairs that the search compares: a second's work.
const MAX_COMPARED_PAIRS: usize = 100_000_000;
/// Maximum pairs that are stored, besides exact copies.
const MAX_KEPT_PAIRS: usize = 1 << 20;

/// Result of [`find_overlaps`].
#[derive(Debug)]
pub struct Overlaps {
    /// Pairs of overlapping faces, lower index first, in order. Once a face is wholly
    /// covered, no more of its pairs are listed.
    pub pairs: Vec<[u32; 2]>,
    /// For each texel, true if its centre lies under an earlier front.
    pub covered: Vec<bool>,
}

/// Finds overlapping fronts among `faces`; `ranges[k]` are the `texels` of face k. Sweep and prune along one axis: each
/// face, in ascending order, is compared with those that have not ended before it begins. Beyond
/// `MAX_COMPARED_PAIRS` overlaps are missed.
pub fn find_overlaps(faces: &[MeshFace], texels: &[Texel], ranges: &[Range<usize>]) -> Overlaps {
    let mut overlaps = Overlaps {
        pairs: Vec::new(),
        covered: vec![false; texels.len()],
    };
    let mut order = leave_out_copies(faces, ranges, &mut overlaps);
    let boxes: Vec<[Vec3; 2]> = faces.iter().map(bounding_box).collect();
    let axis = choose_sweep_axis(order.iter().map(|k| boxes[*k as usize]));
    let [low, high] = [0, 1].map(|end| {
        let boxes = &boxes;
        move |k: u32| boxes[k as usize][end][axis]
    });
    order.sort_by(|a, b| low(*a).total_cmp(&low(*b)));
    let is_covered = |overlaps: &Overlaps, k: u32| overlaps.covered[ranges[k as usize].clone()].iter().all(|c| *c);
    let mut active: Vec<u32> = Vec::new();
    let mut compared_pairs = 0;
    for a in order {
        active.retain(|b| high(*b) + SAME_PLANE_DISTANCE >= low(a));
        compared_pairs += active.len();
        if compared_pairs > MAX_COMPARED_PAIRS {
            break;
        }
        let mut n = 0;
        while n < active.len() && !is_covered(&overlaps, a) {
            let [first, later] = [a.min(active[n]), a.max(active[n])];
            let [over, under] = [first, later].map(|k| &faces[k as usize]);
            if faces_overlap(over, under) {
                if overlaps.pairs.len() < MAX_KEPT_PAIRS {
                    overlaps.pairs.push([first, later]);
                }
                for k in ranges[later as usize].clone() {
                    overlaps.covered[k] |= over.holds_point(texels[k].position);
                }
            }
            // A face of which all texels are covered carries no light: it is not compared again.
            if is_covered(&overlaps, active[n]) {
                active.swap_remove(n);
            } else {
                n += 1;
            }
        }
        if !is_covered(&overlaps, a) {
            active.push(a);
        }
    }
    overlaps.pairs.sort_unstable();
    overlaps
}

/// Returns the faces with an area, without those that have the corners and the front of an earlier one: these are
/// added to the overlaps.
fn leave_out_copies(faces: &[MeshFace], ranges: &[Range<usize>], overlaps: &mut Overlaps) -> Vec<u32> {
    let mut first: HashMap<[[u32; 3]; 4], Vec<u32>> = HashMap::new();
    let mut order = Vec::with_capacity(faces.len());
    for (k, face) in (0..).zip(faces).filter(|(_, face)| face.normal != Vec3::ZERO) {
        let same = first.entry(face.sorted_corner_bits()).or_default();
        let front = |j: &&u32| faces[**j as usize].normal.dot(face.normal) > 0.0;
        if let Some(j) = same.iter().find(front) {
            overlaps.pairs.push([*j, k]);
            overlaps.covered[ranges[k as usize].clone()].fill(true);
        } else {
            same.push(k);
            order.push(k);
        }
    }
    order
}

/// Returns the axis along which boxes are shortest, relative to the extent of all.
fn choose_sweep_axis(boxes: impl Iterator<Item = [Vec3; 2]>) -> usize {
    let (mut all, mut sum) = ([Vec3::INFINITY, Vec3::NEG_INFINITY], Vec3::ZERO);
    for [low, high] in boxes {
        all = [all[0].min(low), all[1].max(high)];
        sum += high - low;
    }
    let share = sum / (all[1] - all[0]).max(Vec3::splat(SAME_PLANE_DISTANCE));
    (0..3).min_by(|a, b| share[*a].total_cmp(&share[*b])).unwrap_or(0)
}

fn bounding_box(face: &MeshFace) -> [Vec3; 2] {
    let [a, b, c, d] = face.corners;
    [a.min(b).min(c.min(d)), a.max(b).max(c.max(d))]
}

fn faces_overlap(a: &MeshFace, b: &MeshFace) -> bool {
    let same_side = a.normal.dot(b.normal) > 1.0 - SAME_PLANE_DISTANCE;
    let same_plane = (a.plane.w - b.plane.w).abs() <= SAME_PLANE_DISTANCE;
    let apart = |p: &MeshFace, q: &MeshFace| {
        let beyond = |edge: Vec4, corner: &Vec3| edge.truncate().dot(*corner) - edge.w <= SAME_PLANE_DISTANCE;
        let mut edges = p.edges.iter().filter(|edge| edge.truncate() != Vec3::ZERO);
        edges.any(|edge| q.corners.iter().all(|corner| beyond(*edge, corner)))
    };
    same_side && same_plane && !apart(a, b) && !apart(b, a)
}
