//! Splits input polygons into planar convex faces: a planar convex quad stays a quad, other polygons are cut into
//! triangles by ear clipping. The builder splits every face of a file by it.

use glam::DVec3;

/// Largest number of corners of a polygon: ear clipping takes n³ steps at worst.
pub const MAX_CORNERS: usize = 1024;

/// Distance between the diagonals of a planar quad, as a share of its largest coordinate. Most writers
/// round to six significant digits, which moves a coordinate x by up to 5e-6·|x|.
const PLANARITY_TOLERANCE: f64 = 1e-5;

/// Largest distance between the diagonals of a planar quad, as a share of its longer diagonal. It limits the
/// tolerance above far from the origin.
const MAX_RELATIVE_BEND: f64 = 1e-4;

/// Sine of the turn at a corner that counts as straight: rounding of f64 coordinates, not of their text.
const STRAIGHT_CORNER_SINE: f64 = 1e-9;

/// Sine of the turn to the right that counts as straight in a quad that was moved after its import.
const MAX_STORED_TURN_SINE: f64 = 1e-6;

/// Twice the area of a corner's triangle that counts as zero, per square of the polygon's size.
const MIN_RELATIVE_AREA: f64 = 1e-12;

/// A planar convex piece of a polygon.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ConvexPiece {
    /// Planar convex quad.
    Quad([DVec3; 4]),
    /// Triangle, with or without area.
    Triangle([DVec3; 3]),
}

/// Remarks about irregular polygons, which follow the words "1 face" in a note.
pub const NO_AREA: &str = "without area: neither lit nor lighting";
const REPEATED_CORNER: &str = "with a repeated corner, which counts once";
const NON_PLANAR: &str = "not planar: split into two triangles";
const NON_CONVEX: &str = "not convex: split into two triangles";
const MANY_CORNERS: &str = "with more than four corners: split into triangles";

/// Splits a polygon of at most [`MAX_CORNERS`] finite corners into one or more pieces, with
/// remarks about its irregularities.
pub fn split_polygon(corners: &[DVec3]) -> (Vec<ConvexPiece>, Vec<&'static str>) {
    let distinct = without_repeats(corners);
    let mut remarks = Vec::new();
    if distinct.len() < corners.len() && corners.len() > 3 {
        remarks.push(REPEATED_CORNER);
    }
    let no_area = is_collinear(&distinct);
    if no_area {
        remarks.push(NO_AREA);
    }
    let piece = match (corners, distinct.as_slice()) {
        (&[a, b, c], _) | (_, &[a, b, c]) => ConvexPiece::Triangle([a, b, c]),
        (_, []) => return (Vec::new(), remarks),
        (_, &[a]) => ConvexPiece::Triangle([a, a, a]),
        (_, &[a, b]) => ConvexPiece::Triangle([a, b, b]),
        (_, &[a, b, c, d]) if no_area => ConvexPiece::Quad([a, b, c, d]),
        (_, &[a, b, .., z]) if no_area => ConvexPiece::Triangle([a, b, z]),
        (_, &[a, b, c, d]) if !is_planar(&[a, b, c, d]) => {
            remarks.push(NON_PLANAR);
            return (clip_ears(&distinct), remarks);
        }
        (_, &[a, b, c, d]) if smallest_turn(&[a, b, c, d]) >= -STRAIGHT_CORNER_SINE => ConvexPiece::Quad([a, b, c, d]),
        (_, all) => {
            remarks.push(if all.len() == 4 { NON_CONVEX } else { MANY_CORNERS });
            return (clip_ears(&distinct), remarks);
        }
    };
    (vec![piece], remarks)
}

/// Joins two triangles with a common edge into a planar, strictly convex quad; none if they form none. The
/// first corner of the quad is the first triangle's.
pub fn join_triangles(first: [DVec3; 3], second: [DVec3; 3]) -> Option<[DVec3; 4]> {
    let shared = |k: usize| {
        let edge = (first[(k + 1) % 3], first[k]);
        let m = (0..3).find(|m| (second[*m], second[(m + 1) % 3]) == edge)?;
        Some(second[(m + 2) % 3])
    };
    let (after, apex) = (0..3).find_map(|k| Some((k, shared(k)?)))?;
    let [a, b, c] = first;
    let quad = match after {
        0 => [a, apex, b, c],
        1 => [a, b, apex, c],
        _ => [a, b, c, apex],
    };
    // A corner of 180° would make the quad a triangle with a superfluous vertex.
    (is_planar(&quad) && smallest_turn(&quad) > 1e-6).then_some(quad)
}

/// Removes repeated corners (the first of equal neighbours stays) and spikes (a corner between equal ones).
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
    // The same for the last and the first corners.
    loop {
        match distinct.as_slice() {
            [first, .., last] if first == last => distinct.pop(),
            [first, _, .., before, _] if first == before => distinct.pop(),
            [_, second, .., last] if second == last && distinct.len() > 2 => Some(distinct.remove(0)),
            _ => return distinct,
        };
    }
}

/// True if the area of the polygon is within the rounding of its coordinates.
fn is_collinear(corners: &[DVec3]) -> bool {
    let Some(origin) = corners.first() else {
        return true;
    };
    let magnitude = largest_coordinate(corners);
    let distances = corners.iter().map(|p| p.distance(*origin));
    let areas = double_areas(corners).map(DVec3::length);
    let [longest, largest] = [distances.fold(0.0, f64::max), areas.fold(0.0, f64::max)];
    largest <= 8.0 * f64::EPSILON * magnitude * longest
}

fn largest_coordinate(corners: &[DVec3]) -> f64 {
    let largest = corners.iter().map(|p| p.abs().max_element());
    largest.fold(0.0, f64::max)
}

/// True if the distance between the diagonals is within the rounding of the corners.
fn is_planar(quad: &[DVec3; 4]) -> bool {
    let (bend, diagonal) = bend_and_diagonal(quad);
    let tolerance = (PLANARITY_TOLERANCE * largest_coordinate(quad))
        .clamp(PLANARITY_TOLERANCE * diagonal, MAX_RELATIVE_BEND * diagonal);
    bend <= tolerance
}

/// Returns the distance between the diagonals and the longer diagonal.
fn bend_and_diagonal(quad: &[DVec3; 4]) -> (f64, f64) {
    let [a, b, c, d] = *quad;
    let bend = vector_area(quad).normalize_or_zero().dot(b - a).abs();
    (bend, a.distance(c).max(b.distance(d)))
}

/// Returns whether four corners form a planar convex quad, or one without area, as far as can be known of a quad that
/// was scaled and moved after its import.
pub(crate) fn is_convex_quad(quad: &[DVec3; 4]) -> bool {
    let (bend, diagonal) = bend_and_diagonal(quad);
    let is_flat = bend <= 2.0 * MAX_RELATIVE_BEND * diagonal;
    is_collinear(quad) || (is_flat && smallest_turn(quad) >= -MAX_STORED_TURN_SINE)
}

/// Returns the smallest sine of the left turn at a corner (negative at a reflex corner).
fn smallest_turn(quad: &[DVec3; 4]) -> f64 {
    // A quad that crosses itself with equal areas has no front.
    let Some(normal) = vector_area(quad).try_normalize() else {
        return f64::NEG_INFINITY;
    };
    let turn = |k: usize| {
        let (before, after) = (quad[k] - quad[(k + 3) % 4], quad[(k + 1) % 4] - quad[k]);
        before.cross(after).dot(normal) / (before.length() * after.length())
    };
    (0..4).map(turn).fold(f64::INFINITY, f64::min)
}

/// Returns the vector area (Newell): the sum of the triangles about the first corner.
pub fn vector_area(corners: &[DVec3]) -> DVec3 {
    double_areas(corners).sum::<DVec3>() * 0.5
}

/// Iterates over twice the vector areas of the triangles about the first corner.
fn double_areas(corners: &[DVec3]) -> impl Iterator<Item = DVec3> {
    let edges = corners.windows(2);
    edges.map(|w| (w[0] - corners[0]).cross(w[1] - corners[0]))
}

/// Cuts a polygon into triangles by ear clipping, beginning with corner 1: a convex polygon becomes the fan
/// about corner 0. Drops triangles without area. A polygon that crosses itself loses a corner at each step too.
fn clip_ears(corners: &[DVec3]) -> Vec<ConvexPiece> {
    let mut normals = std::iter::once(vector_area(corners)).chain(double_areas(corners));
    let normal = normals.find_map(DVec3::try_normalize).unwrap_or(DVec3::ZERO);
    let reach = corners.iter().map(|p| p.distance_squared(corners[0]));
    let flat = MIN_RELATIVE_AREA * reach.fold(0.0, f64::max);
    let mut remaining = corners.to_vec();
    let mut cut = Vec::with_capacity(corners.len() - 2);
    let mut at = 1;
    while remaining.len() > 3 {
        let n = remaining.len();
        let candidates = || (0..n).map(|k| (at + k) % n);
        let is_flat = |k: &usize| double_area(ear_at(&remaining, *k), normal).abs() <= flat;
        let ear = candidates().find(|k| is_ear(&remaining, *k, normal, flat));
        let k = ear.or_else(|| candidates().find(is_flat));
        let k = k.unwrap_or(at % n);
        cut.push(ear_at(&remaining, k));
        remaining.remove(k);
        at = k;
    }
    cut.push([remaining[0], remaining[1], remaining[2]]);
    let has_area = |triangle: &[DVec3; 3]| double_area(*triangle, normal).abs() > flat;
    if cut.iter().any(has_area) {
        cut.retain(has_area);
    }
    cut.into_iter().map(ConvexPiece::Triangle).collect()
}

/// Returns corner k's triangle.
fn ear_at(remaining: &[DVec3], k: usize) -> [DVec3; 3] {
    let n = remaining.len();
    [k + n - 1, k, k + 1].map(|k| remaining[k % n])
}

/// Returns twice the area of a triangle, negative at a reflex corner.
fn double_area([a, b, c]: [DVec3; 3], normal: DVec3) -> f64 {
    (b - a).cross(c - a).dot(normal)
}

/// True if corner k's triangle lies inside the polygon: it has an area and contains no other corner.
fn is_ear(remaining: &[DVec3], k: usize, normal: DVec3, flat: f64) -> bool {
    let [a, b, c] = ear_at(remaining, k);
    let inside = |p: DVec3| {
        let parts = [[a, b, p], [b, c, p], [c, a, p]];
        parts.into_iter().all(|part| double_area(part, normal) >= 0.0)
    };
    let mut others = remaining.iter().filter(|p| ![a, b, c].contains(p));
    double_area([a, b, c], normal) > flat && !others.any(|p| inside(*p))
}

#[cfg(test)]
mod tests;
