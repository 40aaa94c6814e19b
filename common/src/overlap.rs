//! Fronts that lie on each other: coplanar, facing the same way, overlapping. Whatever reaches one of
//! them reaches the other, so light that both reflect would count twice, and would have no limit
//! between white walls. The first in the file receives and shoots it; the others lie under it.

use crate::mesh::{Mesh, MeshFace};
use glam::{Vec3, Vec4};
use std::collections::HashMap;

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

/// Looks for them in `mesh`, each of whose faces has its texels in `texels`.
pub fn overlaps(mesh: &Mesh, texels: &[std::ops::Range<usize>]) -> Overlaps {
    let mut search = Search {
        mesh,
        texels,
        found: Overlaps {
            covered: vec![false; mesh.texels.len()],
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
    mesh: &'a Mesh,
    texels: &'a [std::ops::Range<usize>],
    found: Overlaps,
}

impl Search<'_> {
    /// The faces with an area, but for those that have the corners and the front of an earlier one.
    fn without_copies(&mut self) -> Vec<u32> {
        let mut first: HashMap<[[u32; 3]; 4], Vec<u32>> = HashMap::new();
        let mut order = Vec::with_capacity(self.mesh.faces.len());
        for (k, face) in (0..).zip(&self.mesh.faces) {
            if face.normal == Vec3::ZERO {
                continue;
            }
            let same = first.entry(face.place()).or_default();
            let front = |j: &&u32| self.mesh.faces[**j as usize].normal.dot(face.normal) > 0.0;
            if let Some(j) = same.iter().find(front) {
                self.found.pairs.push([*j, k]);
                self.found.covered[self.texels[k as usize].clone()].fill(true);
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
            let [low, high] = extent(&self.mesh.faces[*k as usize]);
            all = [all[0].min(low), all[1].max(high)];
            sum += high - low;
        }
        let share = sum / (all[1] - all[0]).max(Vec3::splat(SAME));
        (0..3)
            .min_by(|a, b| share[*a].total_cmp(&share[*b]))
            .unwrap_or(0)
    }

    fn low(&self, k: u32, axis: usize) -> f32 {
        extent(&self.mesh.faces[k as usize])[0][axis]
    }

    /// Faces in rising order along `axis`, each with those that have not ended before it begins. One
    /// that lies under another as a whole is asked no more: what it covers, the other covers.
    fn sweep(&mut self, order: &[u32], axis: usize) {
        let mut active: Vec<u32> = Vec::new();
        let mut looked = 0;
        for a in order {
            let start = self.low(*a, axis);
            let ends = |b: &u32| extent(&self.mesh.faces[*b as usize])[1][axis];
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
        let texels = self.texels[k as usize].clone();
        self.found.covered[texels].iter().all(|covered| *covered)
    }

    fn pair(&mut self, a: u32, b: u32) {
        let (first, later) = (a.min(b), a.max(b));
        let [over, under] = [first, later].map(|k| &self.mesh.faces[k as usize]);
        if !overlap(over, under) {
            return;
        }
        if self.found.pairs.len() < KEPT {
            self.found.pairs.push([first, later]);
        }
        for k in self.texels[later as usize].clone() {
            let point = self.mesh.texels[k].position;
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Face, Scene};
    use approx::abs_diff_eq;
    use glam::DVec3;

    fn square(x: f64, z: f64, side: f64) -> Face {
        let p = |i: f64, j: f64| DVec3::new(x + i * side, j * side, z);
        let corners = [p(0.0, 0.0), p(1.0, 0.0), p(1.0, 1.0), p(0.0, 1.0)];
        Face::quad("", corners, Vec3::ZERO, Vec3::ZERO)
    }

    fn mesh(faces: Vec<Face>, texels: u32, cells: u32) -> Mesh {
        let scene = Scene {
            name: "squares".into(),
            faces,
            notes: Vec::new(),
        };
        Mesh::uniform(&scene, texels, cells).unwrap()
    }

    fn area(mesh: &Mesh, face: u32) -> f64 {
        let own = mesh.texels.iter().filter(|t| t.face == face);
        own.map(|t| f64::from(t.area)).sum::<f64>() * mesh.area_unit()
    }

    #[test]
    fn only_fronts_on_the_same_side_of_one_plane_overlap() {
        let faces = vec![
            square(0.0, 0.0, 1.0),
            square(1.0, 0.0, 1.0),             // shares an edge with 0
            square(0.25, 0.0, 0.5),            // inside 0
            square(0.25, 0.0, 0.5).reversed(), // touches from the other side
            square(0.25, 0.01, 0.5),           // above
        ];
        assert_eq!(mesh(faces, 1, 1).overlaps, [[0, 2]]);
    }

    #[test]
    fn what_lies_under_an_earlier_front_has_no_area() {
        let whole = square(0.0, 0.0, 1.0);
        let [a, b, c, d] = whole.corners;
        let half = |c| Face::triangle("", c, Vec3::ZERO, Vec3::ZERO);
        let halves = [half([a, b, c]), half([a, c, d])];
        let far = square(3.0, 0.0, 1.0);
        for (texels, cells) in [(1, 1), (8, 2), (8, 8)] {
            // The same corners from another one on, and the same square in two triangles.
            let mut turned = whole.clone();
            turned.corners.rotate_left(1);
            let faces = [&[whole.clone(), turned, far.clone()], &halves[..]].concat();
            let all = mesh(faces, texels, cells);
            let areas: Vec<f64> = (0..5).map(|k| area(&all, k)).collect();
            assert_eq!(areas[1..5], [0.0, 1.0, 0.0, 0.0], "{texels}, {cells}");
            assert!(abs_diff_eq!(areas[0], 1.0, epsilon = 1e-6));
            let buried = |k: usize| all.faces[k].normal == Vec3::ZERO;
            assert_eq!(
                [0, 1, 2, 3, 4].map(buried),
                [false, true, false, true, true]
            );
            // A square under two triangles.
            let faces = [&halves[..], &[whole.clone(), far.clone()]].concat();
            let all = mesh(faces, texels, cells);
            assert_eq!(area(&all, 2), 0.0, "{texels}, {cells}");
            assert!(abs_diff_eq!(
                area(&all, 0) + area(&all, 1),
                1.0,
                epsilon = 1e-6
            ));
        }
    }

    #[test]
    fn of_a_half_covered_face_the_cells_underneath_have_no_area() {
        let all = mesh(vec![square(0.0, 0.0, 1.0), square(0.5, 0.0, 1.0)], 8, 4);
        assert!(abs_diff_eq!(area(&all, 1), 0.5, epsilon = 1e-6));
        let shooting: f32 = all.cells.iter().map(|c| c.shooter.area).sum();
        let receiving: f32 = all.texels.iter().map(|t| t.area).sum();
        assert!(abs_diff_eq!(shooting, receiving, epsilon = 1e-6));
    }

    #[test]
    fn many_on_one_place_are_found_at_once() {
        // Ten thousand squares, each a little smaller than the one before.
        let faces = (0..10_000).map(|k| square(0.0, 0.0, 1.0 - f64::from(k) * 1e-5));
        let start = std::time::Instant::now();
        let all = mesh(faces.collect(), 1, 1);
        assert_eq!(all.overlaps.len(), 9_999);
        // Each with each would be 5e7 pairs of 100 ns.
        assert!(start.elapsed().as_secs_f64() < 1.0, "{:?}", start.elapsed());
    }
}
