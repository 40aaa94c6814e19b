//! Which faces are beside each other: what changes on one may do so by what the texels of the other are too
//! coarse for.

use common::scene::Face;
use glam::DVec3;

/// It covers what it faces: the cosine between them is this at most.
const FACING: f64 = -0.9;

/// What is closer than this share of a width touches.
const TOUCH: f64 = 1e-6;

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

/// Tells of each face that another covers in part, closer than the width of a texel, how wide its texels
/// may be: as the gap, or so that `across` of them reach across the smaller face; but no less than `least`.
pub fn covered(
    faces: &[Face],
    sides: &[u32],
    (across, least): (f64, f64),
    mut tell: impl FnMut(usize, f64),
) {
    let widths: Vec<f64> = faces.iter().map(width_of).collect();
    let texel = |f: usize| widths[f] / f64::from(sides[f]);
    near(faces, sides, |f, g, apart| {
        let least = least.max(widths[f].min(widths[g]) / across);
        if least < texel(f)
            && apart <= texel(f)
            && let Some(gap) = gap(&faces[f], &faces[g], texel(f))
        {
            tell(f, least.max(gap));
        }
    });
}

/// Tells of each face on which a sheet stands, within its outline, how wide its texels may be: so that `across`
/// of them reach along the foot, but no less than `least`. A texel on both sides of it shines as the mean of the
/// two, which may be light and shadow.
pub fn parted(
    faces: &[Face],
    sides: &[u32],
    (across, least): (f64, f64),
    mut tell: impl FnMut(usize, f64),
) {
    let texel = |f: usize| width_of(&faces[f]) / f64::from(sides[f]);
    let mut feet: Vec<(usize, usize, [DVec3; 2])> = Vec::new();
    let mut joined: Vec<(usize, usize)> = Vec::new();
    near(faces, sides, |f, g, apart| {
        if apart <= texel(f)
            && let Some(foot) = foot(&faces[f], &faces[g], texel(f))
        {
            feet.push((f, g, foot));
        }
        if meet(&faces[f], &faces[g]) {
            joined.push((f, g));
        }
    });
    joined.sort_unstable();
    for (f, g, foot) in feet {
        let width = least.max(foot[0].distance(foot[1]) / across);
        let start = joined.partition_point(|pair| *pair < (g, 0));
        let mut others = joined[start..].iter().take_while(|pair| pair.0 == g);
        let alone = others.all(|(_, other)| !ends(&faces[*other], &faces[g], &faces[f], foot));
        if width < texel(f) && alone {
            tell(f, width);
        }
    }
}

/// The edge by which `g` stands on `f`, no higher than `reach` above its plane, some of it within its outline.
fn foot(f: &Face, g: &Face, reach: f64) -> Option<[DVec3; 2]> {
    let normal = f.vector_area().normalize_or_zero();
    if normal.dot(g.vector_area().normalize_or_zero()).abs() > -FACING {
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

/// Whether `other`, in another plane than `g` and `f`, begins where the foot of `g` on `f` ends: then `g` is a
/// side of a body.
fn ends(other: &Face, g: &Face, f: &Face, foot: [DVec3; 2]) -> bool {
    let normal = other.vector_area().normalize_or_zero();
    let along = |face: &Face| normal.dot(face.vector_area().normalize_or_zero()).abs() > -FACING;
    let close = TOUCH * foot[0].distance(foot[1]);
    let at = |c: &DVec3| foot.iter().any(|end| end.distance(*c) <= close);
    !along(g) && !along(f) && other.corners.iter().any(at)
}

/// Whether two faces have a corner in common.
fn meet(f: &Face, g: &Face) -> bool {
    let close = TOUCH * width_of(f).min(width_of(g));
    let at = |c: &DVec3| g.corners.iter().any(|d| d.distance(*c) <= close);
    f.corners.iter().any(at)
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
fn gap(f: &Face, g: &Face, reach: f64) -> Option<f64> {
    let [n, m] = [f, g].map(|face| face.vector_area().normalize_or_zero());
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
    (low <= reach && high > 1e-6 * width_of(g) && aside <= far).then_some(low.max(0.0))
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
        let normal = f.vector_area().normalize_or_zero();
        let reach = 1e-6 * width_of(g);
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
            parted(&faces, &sides, (4.0, 0.0), |f, width| told.push((f, width)));
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
    }
}
