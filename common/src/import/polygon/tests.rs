//! Every piece faces as its polygon does, and together they cover it once.

use super::*;
use approx::abs_diff_eq;

fn at(points: &[(f64, f64)]) -> Vec<DVec3> {
    points
        .iter()
        .map(|(x, y)| DVec3::new(*x, *y, 3.0))
        .collect()
}

/// Signed area about +z of every piece.
fn areas(pieces: &[Piece]) -> Vec<f64> {
    pieces
        .iter()
        .map(|piece| match piece {
            Piece::Quad(c) => vector_area(c).z,
            Piece::Triangle(c) => vector_area(c).z,
        })
        .collect()
}

fn covers(points: &[(f64, f64)]) -> (usize, Vec<Remark>) {
    let corners = at(points);
    let (pieces, remarks) = split(&corners);
    let areas = areas(&pieces);
    assert!(
        areas.iter().all(|a| *a > 0.0),
        "a piece faces backwards: {areas:?}"
    );
    let total: f64 = areas.iter().sum();
    assert!(
        abs_diff_eq!(total, vector_area(&corners).z, epsilon = 1e-12),
        "area {total} of {}",
        vector_area(&corners).z
    );
    (pieces.len(), remarks)
}

#[test]
fn convex_quads_stay() {
    assert_eq!(
        covers(&[(0., 0.), (2., 0.), (2., 1.), (0., 1.)]),
        (1, vec![])
    );
    // A straight corner is convex, and so is one that rounding bends inwards by 1e-16.
    assert_eq!(
        covers(&[(0., 0.), (0.1, 0.1), (0.3, 0.3), (0., 1.)]),
        (1, vec![])
    );
}

#[test]
fn darts_are_cut_inside_wherever_they_begin() {
    let dart = [(0., 0.), (2., 0.), (0.5, 0.5), (0., 2.)];
    for first in 0..4 {
        let mut turned = dart;
        turned.rotate_left(first);
        assert_eq!(covers(&turned), (2, vec![Remark::NonConvex]));
    }
}

#[test]
fn concave_polygons_are_covered_once() {
    let l = [(0., 0.), (2., 0.), (2., 1.), (1., 1.), (1., 2.), (0., 2.)];
    assert_eq!(covers(&l), (4, vec![Remark::Polygon]));
    let comb = [
        (0., 0.),
        (5., 0.),
        (5., 2.),
        (4., 1.),
        (3., 2.),
        (2., 1.),
        (1., 2.),
        (0.5, 0.2),
        (0., 2.),
    ];
    assert_eq!(covers(&comb), (7, vec![Remark::Polygon]));
    // A square hole joined to the outline by a bridge that is walked twice.
    let keyhole = [
        (0., 0.),
        (3., 0.),
        (3., 3.),
        (0., 3.),
        (0., 0.),
        (1., 1.),
        (1., 2.),
        (2., 2.),
        (2., 1.),
        (1., 1.),
    ];
    assert_eq!(covers(&keyhole).1, vec![Remark::Polygon]);
}

#[test]
fn straight_corners_make_no_empty_triangle() {
    let pentagon = [(0., 0.), (1., 0.), (2., 0.), (2., 2.), (0., 2.)];
    assert_eq!(covers(&pentagon), (3, vec![Remark::Polygon]));
}

#[test]
fn a_spike_is_dropped() {
    let spiked = [(0., 0.), (2., 0.), (2., 2.), (3., 2.), (2., 2.), (0., 2.)];
    for first in 0..6 {
        let mut turned = spiked;
        turned.rotate_left(first);
        assert_eq!(covers(&turned), (1, vec![Remark::Repeated]), "from {first}");
    }
}

#[test]
fn a_bow_tie_ends() {
    let (pieces, remarks) = split(&at(&[(0., 0.), (1., 1.), (1., 0.), (0., 1.)]));
    assert_eq!((pieces.len(), remarks), (2, vec![Remark::NonConvex]));
}

#[test]
fn planar_within_six_digits_of_the_coordinates() {
    let bent = |by: f64, offset: f64| {
        let mut quad =
            [DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, by), DVec3::Y].map(|p| p + offset);
        quad.rotate_left(1);
        split(&quad).1
    };
    assert_eq!(bent(5e-6, 0.0), vec![]);
    assert_eq!(bent(5e-5, 0.0), vec![Remark::NonPlanar]);
    // At 10 the sixth digit is worth 1e-4, …
    assert_eq!(bent(5e-5, 9.0), vec![]);
    // … but a visible bend is a bend at any distance.
    assert_eq!(bent(1e-3, 1e4), vec![Remark::NonPlanar]);
}

#[test]
fn repeated_corners_count_once() {
    assert_eq!(
        covers(&[(0., 0.), (1., 0.), (1., 0.), (0., 1.)]),
        (1, vec![Remark::Repeated])
    );
    assert_eq!(
        covers(&[(0., 0.), (1., 0.), (0., 1.), (0., 0.)]),
        (1, vec![Remark::Repeated])
    );
    let (pieces, remarks) = split(&at(&[(1., 1.); 4]));
    assert_eq!(
        (pieces.len(), remarks),
        (1, vec![Remark::Repeated, Remark::NoArea])
    );
}

#[test]
fn lines_have_no_area_and_slivers_do() {
    // Decimals on a line: in binary they are not.
    let line = |lift: f64| split(&at(&[(0.1, 0.11), (0.2, 0.22), (0.3, 0.33 + lift)])).1;
    assert_eq!(line(0.0), vec![Remark::NoArea]);
    assert_eq!(line(1e-9), vec![]);
}

#[test]
fn joined_triangles_keep_the_first_corner() {
    let [a, b, c, d] = [DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y];
    assert_eq!(join([a, b, c], [a, c, d]), Some([a, b, c, d]));
    assert_eq!(join([b, c, a], [c, d, a]), Some([b, c, d, a]));
    assert_eq!(join([c, a, b], [d, a, c]), Some([c, d, a, b]));
    assert_eq!(join([a, b, c], [a, d, c]), None, "opposite windings");
    assert_eq!(join([a, b, c], [a, c, d + DVec3::Z]), None, "not planar");
    assert_eq!(
        join([a, b, c], [a, c, DVec3::new(-1.0, -0.5, 0.0)]),
        None,
        "not convex"
    );
    assert_eq!(
        join([a, b, d], [b, DVec3::new(2.0, 0.0, 0.0), d]),
        None,
        "a straight corner"
    );
}

/// Of a thousand corners: a star, a comb, a spiral, each walked from anywhere.
#[test]
fn a_thousand_corners_are_cut_at_once() {
    let n = super::MAX_CORNERS;
    let round = |k: usize, r: f64| {
        let (y, x) = (std::f64::consts::TAU * k as f64 / n as f64).sin_cos();
        (r * x, r * y)
    };
    let star = (0..n).map(|k| round(k, if k % 2 == 0 { 1.0 } else { 0.5 }));
    let tooth = |k: usize| (1.0 - k as f64 / n as f64, (k % 2) as f64);
    let comb = [(0.0, -1.0), (1.0, -1.0)]
        .into_iter()
        .chain((2..n).map(tooth));
    let arm = |k: usize, r: f64| {
        let t = k as f64 / 16.0;
        ((r + t) / 34.0 * t.cos(), (r + t) / 34.0 * t.sin())
    };
    let spiral = (0..n / 2).map(|k| arm(k, 2.0));
    let spiral = spiral.chain((0..n / 2).rev().map(|k| arm(k, 1.0)));
    for shape in [star.collect::<Vec<_>>(), comb.collect(), spiral.collect()] {
        for first in [0, 1, 500] {
            let mut corners = shape.clone();
            corners.rotate_left(first);
            if vector_area(&at(&corners)).z < 0.0 {
                corners.reverse();
            }
            let start = std::time::Instant::now();
            assert_eq!(covers(&corners).0, n - 2);
            // 30 ns for each pair of corners would be a thirtieth of that; for each triple 30 s.
            assert!(start.elapsed().as_secs_f64() < 1.0, "{:?}", start.elapsed());
        }
    }
}

#[test]
fn a_thousand_corners_anywhere_end_at_once() {
    let n = super::MAX_CORNERS as u32;
    let corners: Vec<_> = (0..n)
        .map(|k| {
            let [x, y] = [2 * k, 2 * k + 1].map(|k| f64::from(crate::sampling::hash(k)));
            (x / 4e9, y / 4e9)
        })
        .collect();
    let start = std::time::Instant::now();
    assert!(!split(&at(&corners)).0.is_empty());
    assert!(start.elapsed().as_secs_f64() < 2.0, "{:?}", start.elapsed());
}
