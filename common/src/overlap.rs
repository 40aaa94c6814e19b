//! Fronts that lie on each other: coplanar, facing the same way, overlapping. Whatever reaches one of
//! them reaches the other, so light that both reflect would count twice, and would have no limit
//! between white walls. The first in the file receives and shoots it; the others lie under it.

use crate::face::MeshFace;
use crate::texel::Texel;
use glam::{Vec3, Vec4};
use std::collections::HashMap;
use std::ops::Range;

/// Planes this close are one, and overlaps thinner than this are none (mesh units): a file's
/// coordinates carry about six digits.
const SAME: f32 = 1e-5;
/// Pairs that are looked at before the search gives up: a second's work.
const MOST: usize = 100_000_000;
/// Pairs that are kept.
const KEPT: usize = 1 << 20;

/// What is found.
#[derive(Debug, Default)]
pub struct Overlaps {
    /// Pairs of overlapping faces, lower index first, in order. Of faces that lie under another one
    /// as a whole, only one pair each.
    pub pairs: Vec<[u32; 2]>,
    /// Whether the centre of each texel lies under an earlier front.
    pub covered: Vec<bool>,
}

/// Looks for them among `faces`, of whose `texels` each face has one of the `ranges`.
pub fn overlaps(faces: &[MeshFace], texels: &[Texel], ranges: &[Range<usize>]) -> Overlaps {
    let mut search = Search {
        faces,
        texels,
        ranges,
        found: Overlaps {
            covered: vec![false; texels.len()],
            ..Overlaps::default()
        },
    };
    let mut order = search.without_copies();
    let axis = search.axis(&order);
    order.sort_by(|a, b| search.low(*a, axis).total_cmp(&search.low(*b, axis)));
    search.sweep(&order, axis);
    search.found.pairs.sort_unstable();
    search.found
}

struct Search<'a> {
    faces: &'a [MeshFace],
    texels: &'a [Texel],
    ranges: &'a [Range<usize>],
    found: Overlaps,
}

impl Search<'_> {
    /// The faces with an area, but for those that have the corners and the front of an earlier one.
    fn without_copies(&mut self) -> Vec<u32> {
        let mut first: HashMap<[[u32; 3]; 4], Vec<u32>> = HashMap::new();
        let mut order = Vec::with_capacity(self.faces.len());
        for (k, face) in (0..).zip(self.faces) {
            if face.normal == Vec3::ZERO {
                continue;
            }
            let same = first.entry(face.place()).or_default();
            let front = |j: &&u32| self.faces[**j as usize].normal.dot(face.normal) > 0.0;
            if let Some(j) = same.iter().find(front) {
                self.found.pairs.push([*j, k]);
                self.found.covered[self.ranges[k as usize].clone()].fill(true);
            } else {
                same.push(k);
                order.push(k);
            }
        }
        order
    }

    /// The axis along which faces are shortest, of the extent of all.
    fn axis(&self, faces: &[u32]) -> usize {
        let mut all = [Vec3::INFINITY, Vec3::NEG_INFINITY];
        let mut sum = Vec3::ZERO;
        for k in faces {
            let [low, high] = extent(&self.faces[*k as usize]);
            all = [all[0].min(low), all[1].max(high)];
            sum += high - low;
        }
        let share = sum / (all[1] - all[0]).max(Vec3::splat(SAME));
        (0..3)
            .min_by(|a, b| share[*a].total_cmp(&share[*b]))
            .unwrap_or(0)
    }

    fn low(&self, k: u32, axis: usize) -> f32 {
        extent(&self.faces[k as usize])[0][axis]
    }

    /// Faces in rising order along `axis`, each with those that have not ended before it begins. One
    /// that lies under another as a whole is asked no more: what it covers, the other covers.
    fn sweep(&mut self, order: &[u32], axis: usize) {
        let mut active: Vec<u32> = Vec::new();
        let mut looked = 0;
        for a in order {
            let start = self.low(*a, axis);
            let ends = |b: &u32| extent(&self.faces[*b as usize])[1][axis];
            active.retain(|b| ends(b) + SAME >= start);
            looked += active.len();
            if looked > MOST {
                return;
            }
            let mut n = 0;
            while n < active.len() && !self.buried(*a) {
                self.pair(*a, active[n]);
                if self.buried(active[n]) {
                    active.swap_remove(n);
                } else {
                    n += 1;
                }
            }
            if !self.buried(*a) {
                active.push(*a);
            }
        }
    }

    fn buried(&self, k: u32) -> bool {
        let texels = self.ranges[k as usize].clone();
        self.found.covered[texels].iter().all(|covered| *covered)
    }

    fn pair(&mut self, a: u32, b: u32) {
        let (first, later) = (a.min(b), a.max(b));
        let [over, under] = [first, later].map(|k| &self.faces[k as usize]);
        if !overlap(over, under) {
            return;
        }
        if self.found.pairs.len() < KEPT {
            self.found.pairs.push([first, later]);
        }
        for k in self.ranges[later as usize].clone() {
            let point = self.texels[k].position;
            self.found.covered[k] |= over.holds(point);
        }
    }
}

fn extent(face: &MeshFace) -> [Vec3; 2] {
    let [a, b, c, d] = face.corners;
    [a.min(b).min(c.min(d)), a.max(b).max(c.max(d))]
}

fn overlap(a: &MeshFace, b: &MeshFace) -> bool {
    let same_side = a.normal.dot(b.normal) > 1.0 - SAME;
    let same_plane = (a.plane.w - b.plane.w).abs() <= SAME;
    let apart = |p: &MeshFace, q: &MeshFace| {
        p.edges
            .iter()
            .filter(|edge| edge.truncate() != Vec3::ZERO)
            .any(|edge: &Vec4| {
                q.corners
                    .iter()
                    .all(|corner| edge.truncate().dot(*corner) - edge.w <= SAME)
            })
    };
    same_side && same_plane && !apart(a, b) && !apart(b, a)
}
