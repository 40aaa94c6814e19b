//! Pieces face as their polygon does, and together cover it once.

use super::*;
use approx::assert_abs_diff_eq;

/// Returns points in the plane z = 3 from x and y of each.
fn points_in_plane(points: &[f64]) -> Vec<DVec3> {
    let points = points.as_chunks().0.iter();
    points.map(|[x, y]| DVec3::new(*x, *y, 3.0)).collect()
}

/// Checks the number of pieces, that they face +z and cover the area once, and the remarks.
fn assert_cover(points: &[f64], count: usize, remarks: &[&str]) {
    let corners = points_in_plane(points);
    let (pieces, found) = split_polygon(&corners);
    let area = |piece: &ConvexPiece| match piece {
        ConvexPiece::Quad(c) => vector_area(c).z,
        ConvexPiece::Triangle(c) => vector_area(c).z,
    };
    let areas: Vec<f64> = pieces.iter().map(area).collect();
    assert!(areas.iter().all(|a| *a > 0.0), "backwards: {areas:?}");
    let total: f64 = areas.iter().sum();
    assert_abs_diff_eq!(total, vector_area(&corners).z, epsilon = 1e-12);
    assert_eq!((pieces.len(), found.as_slice()), (count, remarks));
}

#[test]
fn polygons_are_covered_once_from_any_first_corner() {
    let comb = [0., 0., 5., 0., 5., 2., 4., 1., 3., 2., 2., 1., 1., 2., 0.5, 0.2, 0., 2.];
    // A square hole joined to the outline by a bridge that is walked twice.
    let keyhole = [
        0., 0., 3., 0., 3., 3., 0., 3., 0., 0., 1., 1., 1., 2., 2., 2., 2., 1., 1., 1.,
    ];
    let cases: [(&[f64], usize, &[&str]); 10] = [
        (&[0., 0., 2., 0., 2., 1., 0., 1.], 1, &[]),
        // A straight corner is convex, and so is one that rounding bends inwards by 1e-16.
        (&[0., 0., 0.1, 0.1, 0.3, 0.3, 0., 1.], 1, &[]),
        (&[0., 0., 2., 0., 0.5, 0.5, 0., 2.], 2, &[NON_CONVEX]),
        (&[0., 0., 2., 0., 2., 1., 1., 1., 1., 2., 0., 2.], 4, &[MANY_CORNERS]),
        (&comb, 7, &[MANY_CORNERS]),
        (&keyhole, 8, &[MANY_CORNERS]),
        // No empty triangle at straight corners.
        (&[0., 0., 1., 0., 2., 0., 2., 2., 0., 2.], 3, &[MANY_CORNERS]),
        // A spike.
        (&[0., 0., 2., 0., 2., 2., 3., 2., 2., 2., 0., 2.], 1, &[REPEATED_CORNER]),
        (&[0., 0., 1., 0., 1., 0., 0., 1.], 1, &[REPEATED_CORNER]),
        (&[0., 0., 1., 0., 0., 1., 0., 0.], 1, &[REPEATED_CORNER]),
    ];
    for (points, count, remarks) in cases {
        let mut points = points.to_vec();
        for _ in 0..points.len() / 2 {
            points.rotate_left(2);
            assert_cover(&points, count, remarks);
        }
    }
}

#[test]
fn bow_tie_becomes_two_triangles() {
    let (pieces, remarks) = split_polygon(&points_in_plane(&[0., 0., 1., 1., 1., 0., 0., 1.]));
    assert_eq!((pieces.len(), remarks), (2, vec![NON_CONVEX]));
}

#[test]
fn quad_is_planar_within_six_digits_of_its_coordinates() {
    let bent = |by: f64, offset: f64| {
        let mut quad = [DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, by), DVec3::Y].map(|p| p + offset);
        quad.rotate_left(1);
        split_polygon(&quad).1
    };
    assert_eq!(bent(5e-6, 0.0), [""; 0]);
    assert_eq!(bent(5e-5, 0.0), vec![NON_PLANAR]);
    // At 10 the sixth digit is worth 1e-4, …
    assert_eq!(bent(5e-5, 9.0), [""; 0]);
    // … but a visible bend is a bend at any distance.
    assert_eq!(bent(1e-3, 1e4), vec![NON_PLANAR]);
}

#[test]
fn four_equal_corners_have_no_area() {
    let (pieces, remarks) = split_polygon(&points_in_plane(&[1.; 8]));
    assert_eq!((pieces.len(), remarks), (1, vec![REPEATED_CORNER, NO_AREA]));
}

#[test]
fn collinear_corners_have_no_area_and_slivers_have() {
    // Decimals on a line: in binary they are not.
    let line = |lift: f64| split_polygon(&points_in_plane(&[0.1, 0.11, 0.2, 0.22, 0.3, 0.33 + lift])).1;
    assert_eq!(line(0.0), vec![NO_AREA]);
    assert_eq!(line(1e-9), [""; 0]);
}

#[test]
fn joined_triangles_keep_the_first_corner() {
    let [a, b, c, d] = [DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y];
    assert_eq!(join_triangles([a, b, c], [a, c, d]), Some([a, b, c, d]));
    assert_eq!(join_triangles([b, c, a], [c, d, a]), Some([b, c, d, a]));
    assert_eq!(join_triangles([c, a, b], [d, a, c]), Some([c, d, a, b]));
    let [reflex, straight] = [DVec3::new(-1.0, -0.5, 0.0), DVec3::new(2.0, 0.0, 0.0)];
    for (first, second, reason) in [
        ([a, b, c], [a, d, c], "opposite windings"),
        ([a, b, c], [a, c, d + DVec3::Z], "not planar"),
        ([a, b, c], [a, c, reflex], "not convex"),
        ([a, b, d], [b, straight, d], "a straight corner"),
    ] {
        assert_eq!(join_triangles(first, second), None, "{reason}");
    }
}
