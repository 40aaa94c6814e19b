//! Which faces are beside each other: what changes on one may do so by what the texels of the other are too
//! coarse for.

use super::sides::width_of;
use common::scene::Face;
use glam::DVec3;

/// Texels half as large on the faces beside those of which `finer` has halved them, where theirs are no
/// smaller than what those had: as where a body's top meets a wall that goes down into a gap.
pub fn beside(faces: &[Face], before: &[u32], finer: &mut [u32], may: impl Fn(usize) -> bool) {
    let boxes: Vec<[DVec3; 2]> = faces.iter().map(bounds).collect();
    let mut order: Vec<usize> = (0..faces.len()).collect();
    order.sort_by(|a, b| boxes[*a][0].x.total_cmp(&boxes[*b][0].x));
    let halved: Vec<bool> = (0..faces.len()).map(|f| finer[f] > before[f]).collect();
    let width = |f: usize| width_of(&faces[f]) / f64::from(before[f]);
    let widest = (0..faces.len()).map(width).fold(0.0, f64::max);
    for (k, a) in order.iter().enumerate() {
        let end = boxes[*a][1].x + widest;
        let next = order[k + 1..].iter();
        for b in next.take_while(|b| boxes[**b][0].x <= end) {
            for (f, g) in [(*a, *b), (*b, *a)] {
                let wants = halved[f] && !halved[g] && width(g) >= width(f) && may(g);
                if wants && apart(&boxes[f], &boxes[g]) <= width(g) && see(&faces[f], &faces[g]) {
                    finer[g] = 2 * before[g];
                }
            }
        }
    }
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
