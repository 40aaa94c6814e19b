//! Overlapping fronts: coplanar, with one orientation. Light that reaches one of them reaches the other, so
//! light that both reflect would count twice, and between white walls the solve would not converge. One of them
//! receives and shoots the light (see [`MeshFace::precedes`]); the others are covered by it.

use crate::face::MeshFace;
use crate::texel::Texel;
use glam::{Vec3, Vec4};
use std::collections::HashMap;
use std::ops::Range;

/// Distance below which planes are the same, width below which overlaps are ignored (mesh units), and largest 1 − cosine
/// between equal normals: a file's coordinates have about six digits.
pub(crate) const SAME_PLANE_DISTANCE: f32 = 1e-5;
/// Maximum pairs that the search compares: a second's work.
const MAX_COMPARED_PAIRS: usize = 100_000_000;
/// Maximum pairs that are stored, besides exact copies.
const MAX_KEPT_PAIRS: usize = 1 << 20;

/// Result of [`find_overlaps`].
#[derive(Debug)]
pub struct Overlaps {
    /// Pairs of overlapping faces, in order; the first of a pair covers the second. Once a face is wholly
    /// covered, no more of its pairs are listed.
    pub pairs: Vec<[u32; 2]>,
    /// For each texel, true if its centre lies under a front that precedes its own.
    pub covered: Vec<bool>,
}

/// Finds overlapping fronts among `faces`; `ranges[k]` are the `texels` of face k. Sweep and prune: each face, in ascending
/// order of where it begins, is compared with those that have not ended before. Beyond `MAX_COMPARED_PAIRS` overlaps are
/// missed.
pub fn find_overlaps(faces: &[MeshFace], texels: &[Texel], ranges: &[Range<usize>]) -> Overlaps {
    let mut overlaps = Overlaps {
        pairs: Vec::new(),
        covered: vec![false; texels.len()],
    };
    let mut order = leave_out_copies(faces, ranges, &mut overlaps);
    let extents = choose_sweep(faces, &order);
    let [low, high] = [0, 1].map(|end| {
        let extents = &extents;
        move |k: u32| extents[k as usize][end]
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
            let [mut over, mut under] = [a, active[n]].map(|k| &faces[k as usize]);
            if under.precedes(over) {
                std::mem::swap(&mut over, &mut under);
            }
            if faces_overlap(over, under) {
                if overlaps.pairs.len() < MAX_KEPT_PAIRS {
                    overlaps.pairs.push([over.number, under.number]);
                }
                for k in ranges[under.number as usize].clone() {
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

/// Returns the faces with an area, without those that have the corners and the front of one that precedes
/// them: these are added to the overlaps.
fn leave_out_copies(faces: &[MeshFace], ranges: &[Range<usize>], overlaps: &mut Overlaps) -> Vec<u32> {
    let mut first: HashMap<[[u32; 3]; 4], Vec<u32>> = HashMap::new();
    let mut order = Vec::with_capacity(faces.len());
    let mut with_area: Vec<&MeshFace> = faces.iter().filter(|face| face.normal != Vec3::ZERO).collect();
    with_area.sort_by_key(|face| face.precedence());
    for face in with_area {
        let k = face.number;
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

/// Returns where each face begins and ends along one axis, or by its plane's distance: whichever compares the fewest pairs of
/// the faces in `order`. Coplanar faces lie apart along an axis, those of a curved surface on planes of their own.
fn choose_sweep(faces: &[MeshFace], order: &[u32]) -> Vec<[f32; 2]> {
    let boxes: Vec<[Vec3; 2]> = faces.iter().map(bounding_box).collect();
    let along = |axis: usize| boxes.iter().map(|ends| ends.map(|end| end[axis])).collect();
    let across_planes = || faces.iter().map(|face| [face.plane.w; 2]).collect();
    let sweeps: Vec<Vec<[f32; 2]>> = (0..3).map(along).chain([across_planes()]).collect();
    let least = sweeps.into_iter().min_by_key(|extents| count_meetings(extents, order));
    least.unwrap_or_default()
}

/// Returns how many pairs of the faces in `order` a sweep compares.
fn count_meetings(extents: &[[f32; 2]], order: &[u32]) -> u64 {
    let [lows, highs] = [0, 1].map(|end| {
        let mut values: Vec<f32> = order.iter().map(|k| extents[*k as usize][end]).collect();
        values.sort_unstable_by(f32::total_cmp);
        values
    });
    let (mut ended, mut meetings) = (0, 0);
    for (begun, low) in lows.iter().enumerate() {
        while ended < begun && highs[ended] + SAME_PLANE_DISTANCE < *low {
            ended += 1;
        }
        meetings += (begun - ended) as u64;
    }
    meetings
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Mesh;
    use crate::scene::{Face, Scene};
    use glam::DVec3;

    fn white_quad(corners: [[f64; 3]; 4]) -> Face {
        Face::quad("", corners.map(DVec3::from), Vec3::ZERO, Vec3::ONE)
    }

    /// Returns how many pairs the sweep of `faces` compares.
    fn count_compared_pairs(faces: Vec<Face>) -> u64 {
        let scene = Scene {
            faces,
            ..Scene::default()
        };
        let faces = Mesh::uniform(&scene, 1, 1).unwrap().faces;
        let order: Vec<u32> = (0..faces.len() as u32).collect();
        let extents = choose_sweep(&faces, &order);
        let meets = |[a, b]: [usize; 2]| {
            let [[low_a, high_a], [low_b, high_b]] = [extents[a], extents[b]];
            low_a <= high_b + SAME_PLANE_DISTANCE && low_b <= high_a + SAME_PLANE_DISTANCE
        };
        let pairs = (0..faces.len()).flat_map(|a| (0..a).map(move |b| [a, b]));
        let meetings = pairs.filter(|pair| meets(*pair)).count() as u64;
        assert_eq!(count_meetings(&extents, &order), meetings);
        meetings
    }

    /// Tiles of a floor lie on one plane, in rows; the facets of a ball lie on planes of their own, behind each other.
    #[test]
    fn sweep_compares_few_pairs() {
        let tile = |k: u32| {
            let (x, z) = (f64::from(k % 100), f64::from(k / 100));
            white_quad([[x, 0., z], [x, 0., z + 0.9], [x + 0.9, 0., z + 0.9], [x + 0.9, 0., z]])
        };
        let tiles: Vec<Face> = (0..200).map(tile).collect();
        assert_eq!(count_compared_pairs(tiles.clone()), 100);
        let facet = |k: u32| {
            let at = |n: u32, m: u32| {
                let [(across, up), (sin, cos)] = [(n, 0.15), (m, 0.3)].map(|(n, step)| (f64::from(n) * step).sin_cos());
                [3.0 + across * cos, 2.0 + up, 5.0 + across * sin]
            };
            let (n, m) = (1 + k / 20, k % 20);
            white_quad([at(n, m), at(n, m + 1), at(n + 1, m + 1), at(n + 1, m)])
        };
        let facets: Vec<Face> = (0..360).map(facet).collect();
        let all = count_compared_pairs([facets, tiles[..1].to_vec()].concat());
        assert!(all < 100, "{all}");
    }
}
