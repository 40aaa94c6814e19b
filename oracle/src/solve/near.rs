//! Which faces are beside each other: what changes on one may do so by what the texels of the other are too
//! coarse for.

use common::scene::Face;
use glam::DVec3;
use std::collections::HashMap;

/// It covers what it faces: the cosine between them is this at most.
const FACING: f64 = -0.9;

/// What is closer than this share of a width touches.
const TOUCH: f64 = 1e-6;

fn normal_of(face: &Face) -> DVec3 {
    face.vector_area().normalize_or_zero()
}

/// The longest side of a face.
pub fn width_of(face: &Face) -> f64 {
    let c = &face.corners;
    let edges = (0..c.len()).map(|k| c[k].distance(c[(k + 1) % c.len()]));
    edges.fold(0.0, f64::max)
}

/// Texels half as large on the faces beside those of which `finer` has halved them, where theirs are no
/// smaller than what those had: as where a body's top meets a wall that goes down into a gap.
pub fn beside(faces: &[Face], before: &[u32], finer: &mut [u32], may: impl Fn(usize) -> bool) {
    let halved: Vec<bool> = (0..faces.len()).map(|f| finer[f] > before[f]).collect();
    let widths: Vec<f64> = faces.iter().map(width_of).collect();
    let width = |f: usize| widths[f] / f64::from(before[f]);
    near(faces, before, |f, g, apart| {
        let wants = halved[f] && !halved[g] && width(g) >= width(f) && may(g);
        if wants && apart <= width(g) && see(&faces[f], &faces[g]) {
            finer[g] = 2 * before[g];
        }
    });
}

/// Tells of each face how wide its texels may be where another is closer than one of them. If that covers it in
/// part: as the gap, or so that `across` of them reach across the smaller face. If it is a sheet that stands on it:
/// so that half as many reach along the foot; a texel on both sides of it shines as the mean of the two, which may
/// be light and shadow. But no less than `least`.
pub fn narrow(
    faces: &[Face],
    sides: &[u32],
    (across, least): (f64, f64),
    mut tell: impl FnMut(usize, f64),
) {
    let widths: Vec<f64> = faces.iter().map(width_of).collect();
    let texel = |f: usize| widths[f] / f64::from(sides[f]);
    let normals: Vec<DVec3> = faces.iter().map(normal_of).collect();
    let corners = Corners::of(faces, &normals);
    near(faces, sides, |f, g, apart| {
        if apart > texel(f) {
            return;
        }
        let both = [normals[f], normals[g]];
        let least_here = least.max(widths[f].min(widths[g]) / across);
        if least_here < texel(f)
            && let Some(gap) = gap(&faces[f], &faces[g], both, texel(f))
        {
            tell(f, least_here.max(gap));
        }
        if let Some([a, b]) = foot(&faces[f], &faces[g], both, texel(f))
            && corners.is_sheet([a, b], both)
        {
            tell(f, least.max(2.0 * a.distance(b) / across));
        }
    });
}

/// How faces lie that have a corner somewhere: their normals, and how many have each.
struct Corners(HashMap<[u64; 3], Vec<(DVec3, usize)>>);

impl Corners {
    fn of(faces: &[Face], normals: &[DVec3]) -> Self {
        let mut found: HashMap<_, Vec<(DVec3, usize)>> = HashMap::new();
        for (face, own) in faces.iter().zip(normals) {
            for corner in &face.corners {
                let there = found.entry(key(*corner)).or_default();
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
    fn is_sheet(&self, foot: [DVec3; 2], [under, own]: [DVec3; 2]) -> bool {
        let at = foot.map(|end| self.0.get(&key(end)).map_or(&[][..], Vec::as_slice));
        let mut all = at.iter().copied().flatten();
        if all.any(|(other, _)| !is_along(under, *other) && !is_parallel(own, *other)) {
            return false;
        }
        let has = |end: &[(DVec3, usize)], wanted: &dyn Fn(f64, usize) -> bool| {
            end.iter()
                .any(|(other, count)| is_parallel(own, *other) && wanted(own.dot(*other), *count))
        };
        at.iter().all(|end| has(end, &|along, _| along < 0.0))
            || (at.iter()).any(|end| has(end, &|along, count| along > 0.0 && count == 1))
    }
}

fn key(corner: DVec3) -> [u64; 3] {
    // −0 is 0.
    (corner + 0.0).to_array().map(f64::to_bits)
}

fn is_along(a: DVec3, b: DVec3) -> bool {
    a.dot(b).abs() > -FACING
}

/// A body's faces may differ by little, a sheet's do not.
fn is_parallel(a: DVec3, b: DVec3) -> bool {
    a.cross(b).length() <= TOUCH
}

/// The edge by which `g` stands on `f`, no higher than `reach` above its plane, some of it within its outline.
fn foot(f: &Face, g: &Face, [normal, own]: [DVec3; 2], reach: f64) -> Option<[DVec3; 2]> {
    if is_along(normal, own) {
        return None;
    }
    let (c, d) = (&f.corners, &g.corners);
    let low = |at: &DVec3| (-TOUCH * reach..=reach).contains(&normal.dot(*at - c[0]));
    let within = |[a, b]: &[DVec3; 2]| {
        // What is left of it, from 0 to 1, beyond each of the outline's edges.
        let (mut from, mut to) = (0.0_f64, 1.0_f64);
        for k in 0..c.len() {
            let edge = c[(k + 1) % c.len()] - c[k];
            let inside = |at: &DVec3| normal.dot(edge.cross(*at - c[k])) / edge.length_squared();
            let (start, end) = (inside(a) - TOUCH, inside(b) - TOUCH);
            if start.max(end) <= 0.0 {
                return false;
            }
            let crossing = start / (start - end);
            if start < 0.0 {
                from = from.max(crossing);
            } else if end < 0.0 {
                to = to.min(crossing);
            }
        }
        from + TOUCH < to
    };
    let edges = (0..d.len()).map(|k| [d[k], d[(k + 1) % d.len()]]);
    let mut standing = edges.filter(|edge| edge.iter().all(low));
    standing.find(within)
}

/// All pairs of faces, each both ways, whose boxes are less than a texel of one of them apart, and how far that
/// is.
fn near(faces: &[Face], sides: &[u32], mut pair: impl FnMut(usize, usize, f64)) {
    let boxes: Vec<[DVec3; 2]> = faces.iter().map(bounds).collect();
    let reach = |f: usize| width_of(&faces[f]) / f64::from(sides[f]);
    let reach: Vec<f64> = (0..faces.len()).map(reach).collect();
    // Each reaches as far as its own texels are wide: of a fine mesh in a coarse room few pairs are left.
    let from = |f: usize| boxes[f][0].x - reach[f];
    let mut order: Vec<usize> = (0..faces.len()).collect();
    order.sort_by(|a, b| from(*a).total_cmp(&from(*b)));
    for (k, a) in order.iter().enumerate() {
        let end = boxes[*a][1].x + reach[*a];
        let next = order[k + 1..].iter();
        for b in next.take_while(|b| from(**b) <= end) {
            let apart = apart(&boxes[*a], &boxes[*b]);
            if apart <= reach[*a].max(reach[*b]) {
                pair(*a, *b, apart);
                pair(*b, *a, apart);
            }
        }
    }
}

/// How far `g` is from `f`, which it faces from no farther than `reach`, above some of it.
fn gap(f: &Face, g: &Face, [n, m]: [DVec3; 2], reach: f64) -> Option<f64> {
    if n.dot(m) > FACING {
        return None;
    }
    let heights = g.corners.iter().map(|c| n.dot(*c - f.corners[0]));
    let (low, high) = heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), h| {
        (low.min(h), high.max(h))
    });
    let middle = |face: &Face| face.corners.iter().sum::<DVec3>() / face.corners.len() as f64;
    let aside = middle(g) - middle(f);
    let aside = (aside - n * n.dot(aside)).length();
    let far = 0.5 * (diagonal(f) + diagonal(g));
    (low <= reach && high > TOUCH * width_of(g) && aside <= far).then_some(low.max(0.0))
}

fn diagonal(face: &Face) -> f64 {
    let c = &face.corners;
    c[0].distance(c[2]).max(c[1].distance(c[c.len() - 1]))
}

fn bounds(face: &Face) -> [DVec3; 2] {
    let corners = face.corners.iter();
    let low = corners.clone().fold(DVec3::INFINITY, |low, c| low.min(*c));
    [
        low,
        corners.fold(DVec3::NEG_INFINITY, |high, c| high.max(*c)),
    ]
}

/// How far two boxes are from each other at least.
fn apart(a: &[DVec3; 2], b: &[DVec3; 2]) -> f64 {
    let gap = (a[0] - b[1]).max(b[0] - a[1]).max(DVec3::ZERO);
    gap.length()
}

/// Whether some of each lies before the other.
fn see(f: &Face, g: &Face) -> bool {
    let before = |f: &Face, g: &Face| {
        let normal = normal_of(f);
        let reach = TOUCH * width_of(g);
        g.corners
            .iter()
            .any(|c| normal.dot(*c - f.corners[0]) > reach)
    };
    before(f, g) && before(g, f)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    /// A floor of 8 with a grid of plates upon it, and texels as wide as each.
    fn plates(across: u32) -> Vec<Face> {
        let square = |at: [f64; 3], side: f64| {
            let [x, y, z] = at;
            let corner = |i: f64, j: f64| DVec3::new(x + i * side, y, z + j * side);
            let corners = [
                corner(0.0, 0.0),
                corner(0.0, 1.0),
                corner(1.0, 1.0),
                corner(1.0, 0.0),
            ];
            Face::quad("plate", corners, Vec3::ZERO, Vec3::ONE)
        };
        let side = 8.0 / f64::from(across);
        let places = (0..across).flat_map(|i| (0..across).map(move |j| [i, j].map(f64::from)));
        let plates = places.map(|[i, j]| square([i * side, 1.0, j * side], 0.5 * side));
        std::iter::once(square([0.0; 3], 8.0))
            .chain(plates)
            .collect()
    }

    #[test]
    fn whatever_is_within_a_texel_is_found_and_little_else() {
        let faces = plates(20);
        let sides = vec![4; faces.len()];
        let mut found = Vec::new();
        near(&faces, &sides, |f, g, apart| found.push((f, g, apart)));
        let boxes: Vec<[DVec3; 2]> = faces.iter().map(bounds).collect();
        let reach = |f: usize| width_of(&faces[f]) / 4.0;
        let all = (0..faces.len()).flat_map(|f| (0..faces.len()).map(move |g| (f, g)));
        let mut wanted: Vec<(usize, usize, f64)> = all
            .filter(|(f, g)| f != g)
            .map(|(f, g)| (f, g, apart(&boxes[f], &boxes[g])))
            .filter(|(f, g, apart)| *apart <= reach(*f).max(reach(*g)))
            .collect();
        // The floor's texels are 2 wide and reach every plate; those of plates reach no other.
        assert_eq!(wanted.len(), 2 * 400);
        let key = |a: &(usize, usize, f64)| (a.0, a.1);
        found.sort_by_key(key);
        wanted.sort_by_key(key);
        assert_eq!(found, wanted);
    }

    #[test]
    fn a_sheet_parts_what_it_stands_on_and_a_body_does_not() {
        let upright = |a: [f64; 2], b: [f64; 2], low: f64| {
            let at = |[x, z]: [f64; 2], y: f64| DVec3::new(x, y, z);
            let top = low + 1.0;
            let corners = [at(a, low), at(b, low), at(b, top), at(a, top)];
            Face::quad("sheet", corners, Vec3::ZERO, Vec3::ONE)
        };
        let floor = &plates(1)[0];
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
