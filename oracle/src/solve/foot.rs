//! Sheets that stand on a face: where their feet are, and what tells them from the sides of a body.

use super::near::TOUCH;
use crate::judge::exact::clip;
use common::scene::Face;
use glam::DVec3;
use std::collections::HashMap;

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

#[cfg(test)]
mod tests {
    use super::super::near::narrow;
    use super::*;
    use glam::Vec3;

    #[test]
    fn a_sheet_parts_what_it_stands_on_and_a_body_does_not() {
        let upright = |a: [f64; 2], b: [f64; 2], low: f64| {
            let at = |[x, z]: [f64; 2], y: f64| DVec3::new(x, y, z);
            let top = low + 1.0;
            let corners = [at(a, low), at(b, low), at(b, top), at(a, top)];
            Face::quad("sheet", corners, Vec3::ZERO, Vec3::ONE)
        };
        let corner = |x, z| DVec3::new(x, 0.0, z);
        let corners = [
            corner(0.0, 0.0),
            corner(0.0, 8.0),
            corner(8.0, 8.0),
            corner(8.0, 0.0),
        ];
        let floor = &Face::quad("floor", corners, Vec3::ZERO, Vec3::ONE);
        let told = |things: &[Face]| {
            let faces: Vec<Face> = [floor].into_iter().chain(things).cloned().collect();
            let mut told = Vec::new();
            let sides = vec![4; faces.len()];
            narrow(&faces, &sides, (8.0, 0.0), |f, width| told.push((f, width)));
            told
        };
        let [a, b, c] = [[3.0, 2.0], [5.0, 2.0], [5.0, 4.0]];
        // Of two sides or one, upon the floor or less than a texel above it; one end may be beyond the floor.
        assert_eq!(told(&[upright(a, b, 0.0)]), [(0, 0.5)]);
        let both = [upright(a, b, 0.5), upright(b, a, 0.5)];
        assert_eq!(told(&both), [(0, 0.5); 2]);
        assert_eq!(told(&[upright([5.0, 2.0], [9.0, 2.0], 0.0)]), [(0, 1.0)]);
        // Not high above it, nor below, nor along its edge, nor as a side of a body.
        assert!(told(&[upright(a, b, 2.5)]).is_empty());
        assert!(told(&[upright(a, b, -3.0)]).is_empty());
        assert!(told(&[upright([3.0, 0.0], [5.0, 0.0], 0.0)]).is_empty());
        assert!(told(&[upright(a, b, 0.0), upright(b, c, 0.0)]).is_empty());
        assert!(told(&[upright(a, b, 0.0), upright(b, [7.0, 2.01], 0.0)]).is_empty());
        // A triangle has three corners, of which one at the floor is no foot.
        let at = |x: f64, y: f64| DVec3::new(x, y, 2.0);
        let triangle = |corners| Face::triangle("sheet", corners, Vec3::ZERO, Vec3::ONE);
        let standing = triangle([at(3.0, 3.0), at(3.0, 0.0), at(5.0, 0.0)]);
        assert_eq!(told(&[standing]), [(0, 0.5)]);
        let on_its_tip = triangle([at(5.0, 3.0), at(3.0, 3.0), at(4.0, 0.0)]);
        assert!(told(&[on_its_tip]).is_empty());
        // A sheet of two sides may be cut; of one it may be the side of a body, but where it ends.
        let d = [6.0, 2.0];
        let cut = [
            upright([1.0, 2.0], a, 0.0),
            upright(a, b, 0.0),
            upright(b, d, 0.0),
        ];
        assert_eq!(told(&cut), [(0, 0.5), (0, 0.25)]);
        let behind = [
            upright(a, [1.0, 2.0], 0.0),
            upright(b, a, 0.0),
            upright(d, b, 0.0),
        ];
        assert_eq!(told(&[cut, behind].concat()).len(), 6);
    }
}
