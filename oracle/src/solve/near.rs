//! Which faces are beside each other: what changes on one may do so by what the texels of the other are too
//! coarse for.

use super::foot::{Corners, TOUCH, foot};
use common::scene::Face;
use glam::DVec3;

/// It covers what it faces: the cosine between them is this at most.
const FACING: f64 = -0.9;

/// A face's normal; 0 without an area.
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
    let corners = Corners::new(faces, &normals);
    near(faces, sides, |f, g, apart| {
        if apart > texel(f) {
            return;
        }
        let both = [normals[f], normals[g]];
        let smaller = least.max(widths[f].min(widths[g]) / across);
        if smaller < texel(f)
            && let Some(gap) = gap(&faces[f], &faces[g], both, texel(f))
        {
            tell(f, smaller.max(gap));
        }
        if let Some([a, b]) = foot(&faces[f], &faces[g], both, texel(f))
            && corners.is_sheet([a, b], both)
        {
            tell(f, least.max(2.0 * a.distance(b) / across));
        }
    });
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

    /// A floor of 8 with a grid of plates above it, and one beside it at either end.
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
        let beside = [square([-3.5, 1.0, 0.0], 2.5), square([9.0, 1.0, 0.0], 0.5)];
        std::iter::once(square([0.0; 3], 8.0))
            .chain(plates)
            .chain(beside)
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
        assert_eq!(wanted.len(), 2 * 402);
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
