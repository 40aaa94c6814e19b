//! Overlapping fronts: coplanar, with one orientation. Light that reaches one of them reaches the other, so
//! light that both reflect would count twice, and between white walls the solve would not converge. The
//! first face in the file receives and shoots the light; the others are covered by it.

use crate::face::MeshFace;
use crate::texel::Texel;
use glam::{Vec3, Vec4};
use std::collections::HashMap;
use std::ops::Range;

/// Distance below which planes are the same, and width below which overlaps are ignored (mesh units): a
/// file's coordinates have about six digits.
const SAME_PLANE_DISTANCE: f32 = 1e-5;
/// Maximum pairs that the search compares: a second's work.
const MAX_COMPARED_PAIRS: usize = 100_000_000;
/// Maximum pairs that are stored.
const MAX_KEPT_PAIRS: usize = 1 << 20;

/// Result of [`find_overlaps`].
#[derive(Debug, Default)]
pub struct Overlaps {
    /// Pairs of overlapping faces, lower index first, in order. A face that lies wholly under another
    /// one is in one pair only.
    pub pairs: Vec<[u32; 2]>,
    /// For each texel, true if its centre lies under an earlier front.
    pub covered: Vec<bool>,
}

/// Finds overlapping fronts among `faces`; `ranges[k]` are the `texels` of face k. Sweep and prune along one
/// axis.
pub fn find_overlaps(faces: &[MeshFace], texels: &[Texel], ranges: &[Range<usize>]) -> Overlaps {
    let mut search = OverlapSearch {
        faces,
        texels,
        ranges,
        result: Overlaps {
            covered: vec![false; texels.len()],
            ..Overlaps::default()
        },
    };
    let mut order = search.without_copies();
    let axis = search.sweep_axis(&order);
    order.sort_by(|a, b| search.lower_end(*a, axis).total_cmp(&search.lower_end(*b, axis)));
    search.sweep_faces(&order, axis);
    search.result.pairs.sort_unstable();
    search.result
}

struct OverlapSearch<'a> {
    faces: &'a [MeshFace],
    texels: &'a [Texel],
    ranges: &'a [Range<usize>],
    result: Overlaps,
}

impl OverlapSearch<'_> {
    /// Returns the faces with an area, without those that have the corners and the front of an earlier one.
    fn without_copies(&mut self) -> Vec<u32> {
        let mut first: HashMap<[[u32; 3]; 4], Vec<u32>> = HashMap::new();
        let mut order = Vec::with_capacity(self.faces.len());
        for (k, face) in (0..).zip(self.faces) {
            if face.normal == Vec3::ZERO {
                continue;
            }
            let same = first.entry(face.sorted_corner_bits()).or_default();
            let front = |j: &&u32| self.faces[**j as usize].normal.dot(face.normal) > 0.0;
            if let Some(j) = same.iter().find(front) {
                self.result.pairs.push([*j, k]);
                self.result.covered[self.ranges[k as usize].clone()].fill(true);
            } else {
                same.push(k);
                order.push(k);
            }
        }
        order
    }

    /// Returns the axis along which faces are shortest, relative to the extent of all.
    fn sweep_axis(&self, faces: &[u32]) -> usize {
        let mut all = [Vec3::INFINITY, Vec3::NEG_INFINITY];
        let mut sum = Vec3::ZERO;
        for k in faces {
            let [low, high] = bounding_box(&self.faces[*k as usize]);
            all = [all[0].min(low), all[1].max(high)];
            sum += high - low;
        }
        let share = sum / (all[1] - all[0]).max(Vec3::splat(SAME_PLANE_DISTANCE));
        (0..3).min_by(|a, b| share[*a].total_cmp(&share[*b])).unwrap_or(0)
    }

    fn lower_end(&self, k: u32, axis: usize) -> f32 {
        bounding_box(&self.faces[k as usize])[0][axis]
    }

    /// Compares each face, in ascending order along `axis`, with those that have not ended before it begins.
    /// A face that lies wholly under another is not compared again: the other covers all that it covers.
    fn sweep_faces(&mut self, order: &[u32], axis: usize) {
        let mut active: Vec<u32> = Vec::new();
        let mut compared_pairs = 0;
        for a in order {
            let start = self.lower_end(*a, axis);
            let ends = |b: &u32| bounding_box(&self.faces[*b as usize])[1][axis];
            active.retain(|b| ends(b) + SAME_PLANE_DISTANCE >= start);
            compared_pairs += active.len();
            if compared_pairs > MAX_COMPARED_PAIRS {
                return;
            }
            let mut n = 0;
            while n < active.len() && !self.is_covered(*a) {
                self.compare_pair(*a, active[n]);
                if self.is_covered(active[n]) {
                    active.swap_remove(n);
                } else {
                    n += 1;
                }
            }
            if !self.is_covered(*a) {
                active.push(*a);
            }
        }
    }

    fn is_covered(&self, k: u32) -> bool {
        let texels = self.ranges[k as usize].clone();
        self.result.covered[texels].iter().all(|covered| *covered)
    }

    fn compare_pair(&mut self, a: u32, b: u32) {
        let (first, later) = (a.min(b), a.max(b));
        let [over, under] = [first, later].map(|k| &self.faces[k as usize]);
        if !faces_overlap(over, under) {
            return;
        }
        if self.result.pairs.len() < MAX_KEPT_PAIRS {
            self.result.pairs.push([first, later]);
        }
        for k in self.ranges[later as usize].clone() {
            let point = self.texels[k].position;
            self.result.covered[k] |= over.holds_point(point);
        }
    }
}

fn bounding_box(face: &MeshFace) -> [Vec3; 2] {
    let [a, b, c, d] = face.corners;
    [a.min(b).min(c.min(d)), a.max(b).max(c.max(d))]
}

fn faces_overlap(a: &MeshFace, b: &MeshFace) -> bool {
    let same_side = a.normal.dot(b.normal) > 1.0 - SAME_PLANE_DISTANCE;
    let same_plane = (a.plane.w - b.plane.w).abs() <= SAME_PLANE_DISTANCE;
    let apart = |p: &MeshFace, q: &MeshFace| {
        p.edges
            .iter()
            .filter(|edge| edge.truncate() != Vec3::ZERO)
            .any(|edge: &Vec4| {
                q.corners
                    .iter()
                    .all(|corner| edge.truncate().dot(*corner) - edge.w <= SAME_PLANE_DISTANCE)
            })
    };
    same_side && same_plane && !apart(a, b) && !apart(b, a)
}
