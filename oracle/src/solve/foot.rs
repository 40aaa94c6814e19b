//! Sheets that stand on a face: where their feet are, and what tells them from the sides of a body.

use crate::judge::exact::clip;
use common::scene::Face;
use glam::DVec3;
use std::collections::HashMap;

/// What is closer than this share of a width touches.
pub const TOUCH: f64 = 1e-6;

/// Planes of which the normals have a larger cosine are along each other.
const ALONG: f64 = 0.9;

/// How faces lie that have a corner somewhere: their normals, and how many have each.
pub struct Corners(HashMap<[u64; 3], Vec<(DVec3, usize)>>);

impl Corners {
    /// Of faces with these normals.
    pub fn new(faces: &[Face], normals: &[DVec3]) -> Self {
        let mut found: HashMap<_, Vec<(DVec3, usize)>> = HashMap::new();
        for (face, own) in faces.iter().zip(normals) {
            for corner in face.outline() {
                let there = found.entry(key(*corner)).or_default();
                // Counted, not listed: many faces may lie on each other.
                let alike = |(other, _): &&mut (DVec3, usize)| {
                    is_parallel(*own, *other) && own.dot(*other) > 0.0
                };
                match there.iter_mut().find(alike) {
                    Some((_, count)) => *count += 1,
                    None => there.push((*own, 1)),
                }
            }
        }
        Self(found)
    }

    /// Whether what has this `foot` is a sheet, with the normals of what it stands on and its own. Of a body, which
    /// is dark within, a face in another plane begins where the foot ends; or, where its side is cut into many, more
    /// of that side at either end and no other side behind it.
    pub fn is_sheet(&self, foot: [DVec3; 2], [under, own]: [DVec3; 2]) -> bool {
        let at = foot.map(|end| self.0.get(&key(end)).map_or(&[][..], Vec::as_slice));
        let mut all = at.iter().copied().flatten();
        if all.any(|(other, _)| !is_along(under, *other) && !is_parallel(own, *other)) {
            return false;
        }
        let sides = |end: &[(DVec3, usize)], sign: f64| -> usize {
            let own = end
                .iter()
                .filter(|(other, _)| is_parallel(own, *other) && sign * own.dot(*other) > 0.0);
            own.map(|(_, count)| count).sum()
        };
        at.iter().all(|end| sides(end, -1.0) > 0) || at.iter().any(|end| sides(end, 1.0) == 1)
    }
}

fn key(corner: DVec3) -> [u64; 3] {
    // −0 is 0.
    (corner + 0.0).to_array().map(f64::to_bits)
}

fn is_along(a: DVec3, b: DVec3) -> bool {
    a.dot(b).abs() > ALONG
}

/// A body's faces may differ by little, a sheet's do not.
fn is_parallel(a: DVec3, b: DVec3) -> bool {
    a.cross(b).length() <= TOUCH
}

/// The edge by which `g` stands on `f`, no higher than `reach` above its plane, some of it within its outline.
pub fn foot(f: &Face, g: &Face, [normal, own]: [DVec3; 2], reach: f64) -> Option<[DVec3; 2]> {
    if is_along(normal, own) {
        return None;
    }
    let (c, d) = (f.outline(), g.outline());
    let low = |at: &DVec3| (-TOUCH * reach..=reach).contains(&normal.dot(*at - c[0]));
    let within = |edge: &[DVec3; 2]| {
        let left = (0..c.len()).fold(edge.to_vec(), |left, k| {
            let inward = normal.cross(c[(k + 1) % c.len()] - c[k]);
            clip(&left, c[k] + TOUCH * inward, inward)
        });
        let longest = left.iter().map(|p| p.distance(left[0])).fold(0.0, f64::max);
        longest > TOUCH * edge[0].distance(edge[1])
    };
    let edges = (0..d.len()).map(|k| [d[k], d[(k + 1) % d.len()]]);
    let mut standing = edges.filter(|edge| edge.iter().all(low));
    standing.find(within)
}
