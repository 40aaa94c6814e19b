//! An input polygon → planar convex faces: a quad stays a quad if it can, the rest becomes
//! triangles.

use glam::DVec3;

/// A polygon with more corners than this is refused: cutting ears takes n³ steps at worst.
pub const MAX_CORNERS: usize = 1024;

/// Rounding to six significant digits, as most writers do, moves a coordinate x by up to
/// 5e-6·|x|: corners of a planar quad may lie this share of their coordinates apart.
const DIGITS: f64 = 1e-5;

/// Far from the origin the above would pass any bend: at most this share of the diagonal.
const BEND: f64 = 1e-4;

/// Sine of a corner that counts as straight: rounding of f64 coordinates, not of their text.
const STRAIGHT: f64 = 1e-9;

/// Twice the area of a corner's triangle that counts as none, per square of the polygon's size.
const FLAT: f64 = 1e-12;

/// What a polygon becomes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Piece {
    /// Planar and convex.
    Quad([DVec3; 4]),
    /// Any three corners, on a line or not.
    Triangle([DVec3; 3]),
}

/// What was odd about a polygon.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Remark {
    /// All corners lie on a line.
    NoArea,
    /// A corner equals the one before it.
    Repeated,
    /// A quad whose diagonals do not meet.
    NonPlanar,
    /// A quad with a corner pointing inwards.
    NonConvex,
    /// Five corners or more.
    Polygon,
}

/// The faces of a polygon of at most [`MAX_CORNERS`] finite corners, one at least.
pub fn split(corners: &[DVec3]) -> (Vec<Piece>, Vec<Remark>) {
    let distinct = without_repeats(corners);
    let mut remarks = Vec::new();
    if distinct.len() < corners.len() && corners.len() > 3 {
        remarks.push(Remark::Repeated);
    }
    let no_area = on_a_line(&distinct);
    if no_area {
        remarks.push(Remark::NoArea);
    }
    let pieces = match *distinct.as_slice() {
        _ if corners.len() == 3 => vec![Piece::Triangle([corners[0], corners[1], corners[2]])],
        [] => Vec::new(),
        [a] => vec![Piece::Triangle([a, a, a])],
        [a, b] => vec![Piece::Triangle([a, b, b])],
        [a, b, c] => vec![Piece::Triangle([a, b, c])],
        [a, b, c, d] if no_area => vec![Piece::Quad([a, b, c, d])],
        [a, b, c, d] => {
            let quad = [a, b, c, d];
            if !is_planar(&quad) {
                remarks.push(Remark::NonPlanar);
            } else if smallest_turn(&quad) < -STRAIGHT {
                remarks.push(Remark::NonConvex);
            } else {
                return (vec![Piece::Quad(quad)], remarks);
            }
            triangles(&distinct)
        }
        [a, b, .., z] if no_area => vec![Piece::Triangle([a, b, z])],
        _ => {
            remarks.push(Remark::Polygon);
            triangles(&distinct)
        }
    };
    (pieces, remarks)
}

/// The planar, strictly convex quad that two triangles form over a common edge. Its first corner
/// is the first triangle's.
pub fn join(first: [DVec3; 3], second: [DVec3; 3]) -> Option<[DVec3; 4]> {
    let shared = |k: usize| {
        let edge = (first[(k + 1) % 3], first[k]);
        (0..3)
            .find(|m| (second[*m], second[(m + 1) % 3]) == edge)
            .map(|m| second[(m + 2) % 3])
    };
    let (after, apex) = (0..3).find_map(|k| Some((k, shared(k)?)))?;
    let [a, b, c] = first;
    let quad = match after {
        0 => [a, apex, b, c],
        1 => [a, b, apex, c],
        _ => [a, b, c, apex],
    };
    // A corner of 180° would make the quad a triangle with a vertex too many.
    (is_planar(&quad) && smallest_turn(&quad) > 1e-6).then_some(quad)
}

/// Of equal neighbours the first stays; a corner between equal ones is a spike and goes.
fn without_repeats(corners: &[DVec3]) -> Vec<DVec3> {
    let mut distinct: Vec<DVec3> = Vec::with_capacity(corners.len());
    for corner in corners {
        match distinct.as_slice() {
            [.., last] if last == corner => {}
            [.., before, _] if before == corner => {
                distinct.pop();
            }
            _ => distinct.push(*corner),
        }
    }
    // The same where the end meets the beginning.
    loop {
        match distinct.as_slice() {
            [first, .., last] if first == last => distinct.pop(),
            [first, _, .., before, _] if first == before => distinct.pop(),
            [_, second, .., last] if second == last && distinct.len() > 2 => {
                Some(distinct.remove(0))
            }
            _ => return distinct,
        };
    }
}

/// Whether rounding of the coordinates alone could explain the polygon's area.
fn on_a_line(corners: &[DVec3]) -> bool {
    let Some(origin) = corners.first() else {
        return true;
    };
    let magnitude = magnitude(corners);
    let longest = corners
        .iter()
        .map(|p| p.distance(*origin))
        .fold(0.0, f64::max);
    let largest = corners
        .windows(2)
        .map(|w| (w[0] - *origin).cross(w[1] - *origin).length())
        .fold(0.0, f64::max);
    largest <= 8.0 * f64::EPSILON * magnitude * longest
}

fn magnitude(corners: &[DVec3]) -> f64 {
    corners
        .iter()
        .map(|p| p.abs().max_element())
        .fold(0.0, f64::max)
}

/// Whether the diagonals pass each other within the rounding of the corners.
fn is_planar(quad: &[DVec3; 4]) -> bool {
    let [a, b, c, d] = *quad;
    let diagonal = a.distance(c).max(b.distance(d));
    let tolerance = (DIGITS * magnitude(quad)).clamp(DIGITS * diagonal, BEND * diagonal);
    vector_area(quad).normalize_or_zero().dot(b - a).abs() <= tolerance
}

/// Sine of the turn at the corner that turns least to the left (inwards: negative).
fn smallest_turn(quad: &[DVec3; 4]) -> f64 {
    // A quad that crosses itself evenly has no front.
    let Some(normal) = vector_area(quad).try_normalize() else {
        return f64::NEG_INFINITY;
    };
    (0..4)
        .map(|k| {
            let (before, after) = (quad[k] - quad[(k + 3) % 4], quad[(k + 1) % 4] - quad[k]);
            before.cross(after).dot(normal) / (before.length() * after.length())
        })
        .fold(f64::INFINITY, f64::min)
}

/// Newell: the sum of the triangles about the first corner.
fn vector_area(corners: &[DVec3]) -> DVec3 {
    corners
        .windows(2)
        .map(|w| (w[0] - corners[0]).cross(w[1] - corners[0]))
        .sum::<DVec3>()
        * 0.5
}

/// Cuts ears, beginning with corner 1: a convex polygon becomes the fan about corner 0. Triangles
/// without area are dropped; a polygon that crosses itself still loses a corner a step.
fn triangles(corners: &[DVec3]) -> Vec<Piece> {
    let normals = corners
        .windows(2)
        .map(|w| (w[0] - corners[0]).cross(w[1] - corners[0]));
    let normal = std::iter::once(vector_area(corners))
        .chain(normals)
        .find_map(DVec3::try_normalize)
        .unwrap_or(DVec3::ZERO);
    let reach = corners.iter().map(|p| p.distance_squared(corners[0]));
    let flat = FLAT * reach.fold(0.0, f64::max);
    let mut left = corners.to_vec();
    let mut cut = Vec::with_capacity(corners.len() - 2);
    let mut at = 1;
    while left.len() > 3 {
        let n = left.len();
        let candidates = || (0..n).map(|k| (at + k) % n);
        let ear = candidates().find(|k| is_ear(&left, *k, normal, flat));
        let k = ear
            .or_else(|| candidates().find(|k| turn(&left, *k, normal).abs() <= flat))
            .unwrap_or(at % n);
        cut.push([left[(k + n - 1) % n], left[k], left[(k + 1) % n]]);
        left.remove(k);
        at = k;
    }
    cut.push([left[0], left[1], left[2]]);
    let has_area = |[a, b, c]: &[DVec3; 3]| side(*a, *b, *c, normal).abs() > flat;
    if cut.iter().any(has_area) {
        cut.retain(has_area);
    }
    cut.into_iter().map(Piece::Triangle).collect()
}

/// Twice the area of corner k's triangle, negative if it points inwards.
fn turn(left: &[DVec3], k: usize, normal: DVec3) -> f64 {
    let n = left.len();
    side(left[(k + n - 1) % n], left[k], left[(k + 1) % n], normal)
}

fn side(a: DVec3, b: DVec3, c: DVec3, normal: DVec3) -> f64 {
    (b - a).cross(c - a).dot(normal)
}

/// Whether corner k's triangle lies inside the polygon: it has area and holds no other corner.
fn is_ear(left: &[DVec3], k: usize, normal: DVec3, flat: f64) -> bool {
    let n = left.len();
    let [a, b, c] = [left[(k + n - 1) % n], left[k], left[(k + 1) % n]];
    let inside = |p: DVec3| {
        side(a, b, p, normal) >= 0.0 && side(b, c, p, normal) >= 0.0 && side(c, a, p, normal) >= 0.0
    };
    turn(left, k, normal) > flat
        && !left
            .iter()
            .any(|p| *p != a && *p != b && *p != c && inside(*p))
}

#[cfg(test)]
mod tests;
