//! Printed numbers, and each way held to another.

use super::*;
use approx::abs_diff_eq;

/// The reference prints ten digits.
const PRINTED: f64 = 5e-11;

fn assert_close(value: f64, expected: f64, tolerance: f64) {
    assert!(
        abs_diff_eq!(value, expected, epsilon = tolerance),
        "{value} is not {expected} ± {tolerance}"
    );
}

/// A rectangle from `corner` along `u` and `v`; its front is u × v.
fn rectangle(corner: [f64; 3], u: [f64; 3], v: [f64; 3]) -> Vec<DVec3> {
    let [c, u, v] = [corner, u, v].map(DVec3::from);
    vec![c, c + u, c + u + v, c + v]
}

fn floor() -> Vec<DVec3> {
    rectangle([0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0])
}

/// The unit square that shares the floor's edge x = 0 at `degrees`, fronts facing.
fn leaf(degrees: f64) -> Vec<DVec3> {
    let (s, c) = degrees.to_radians().sin_cos();
    rectangle([0.0; 3], [0.0, 1.0, 0.0], [c, 0.0, s])
}

#[test]
fn closed_forms_give_the_printed_numbers() {
    assert_close(parallel_rectangles(1.0, 1.0, 1.0), 0.1998248957, PRINTED);
    assert_close(
        perpendicular_rectangles(1.0, 1.0, 1.0),
        0.2000437761,
        PRINTED,
    );
    assert_close(parallel_rectangles(1.0, 1.5, 0.5), 0.4756, 5e-5);
    assert_close(parallel_rectangles(0.1, 0.1, 0.05), 0.4153, 5e-5);
    assert_close(coaxial_discs(1.0, 1.0, 1.0), 0.3819660113, PRINTED);
    let sum = parallel_rectangles(1.0, 1.0, 1.0) + 4.0 * perpendicular_rectangles(1.0, 1.0, 1.0);
    assert_close(sum, 1.0, 1e-14);
}

#[test]
fn contour_integral_gives_the_printed_numbers() {
    let hinges = [
        (30.0, 0.6190283231),
        (45.0, 0.4833476955),
        (60.0, 0.3709053212),
        (90.0, 0.2000437761),
        (120.0, 0.0866150011),
        (135.0, 0.0483094478),
        (150.0, 0.0213453254),
    ];
    for (degrees, expected) in hinges {
        assert_close(
            polygon_to_polygon(&floor(), &leaf(degrees)),
            expected,
            PRINTED,
        );
    }
    let above = |x: f64| rectangle([x, 0.0, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]);
    assert_close(
        polygon_to_polygon(&floor(), &above(0.0)),
        0.1998248957,
        PRINTED,
    );
    assert_close(
        polygon_to_polygon(&floor(), &above(2.0)),
        0.0152754501,
        PRINTED,
    );
    let far = rectangle([1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    let high = rectangle([0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
    assert_close(polygon_to_polygon(&far, &high), 0.0329381623, PRINTED);
    let triangle = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(DVec3::from);
    let [a, b, c] = triangle.map(|p| p + DVec3::Z);
    assert_close(
        polygon_to_polygon(&triangle, &[a, c, b]),
        0.1150492281,
        PRINTED,
    );
}

#[test]
fn contour_integral_agrees_with_the_closed_forms_at_any_size() {
    for (a, b, c) in [
        (1.0, 1.0, 0.01),
        (3.0, 0.2, 1.0),
        (0.1, 0.1, 5.0),
        (7.0, 2.0, 0.5),
    ] {
        let low = rectangle([0.0; 3], [a, 0.0, 0.0], [0.0, b, 0.0]);
        let high = rectangle([0.0, 0.0, c], [0.0, b, 0.0], [a, 0.0, 0.0]);
        // Logarithms that nearly cancel: ε of the integral against F·2πA.
        let tolerance = 1e-13 * (1.0 + c * c / (a * b));
        assert_close(
            polygon_to_polygon(&low, &high),
            parallel_rectangles(a, b, c),
            tolerance,
        );
        let wall = rectangle([0.0; 3], [0.0, b, 0.0], [0.0, 0.0, c]);
        assert_close(
            polygon_to_polygon(&low, &wall),
            perpendicular_rectangles(b, a, c),
            tolerance,
        );
    }
}

#[test]
fn parts_behind_the_other_plane_exchange_nothing() {
    // A wall from z = −1 to 1 shows the floor its upper half only; the floor x ∈ [−1, 1] shows
    // the wall x = 0 its right half only.
    let wall = rectangle([0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [0.0, 0.0, 2.0]);
    let wide = rectangle([-1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    let corner = perpendicular_rectangles(1.0, 1.0, 1.0);
    assert_close(polygon_to_polygon(&floor(), &wall), corner, 1e-13);
    assert_close(polygon_to_polygon(&wide, &wall), corner / 2.0, 1e-13);
    let back: Vec<DVec3> = wall.iter().rev().copied().collect();
    assert_eq!(polygon_to_polygon(&floor(), &back), 0.0);
    let point = DVec3::new(0.3, 0.6, 0.0);
    let upper = leaf(90.0);
    let whole = point_to_polygon(point, DVec3::Z, &wall);
    assert_close(whole, point_to_polygon(point, DVec3::Z, &upper), 1e-15);
    assert_eq!(point_to_polygon(point, DVec3::Z, &back), 0.0);
    assert_eq!(point_to_polygon(point, DVec3::NEG_Z, &upper), 0.0);
}

#[test]
fn lambert_averaged_over_the_receiver_is_the_contour_integral() {
    let ceiling = rectangle([0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]);
    let mean = quadrature(0.0, 1.0, |x| {
        quadrature(0.0, 1.0, |y| {
            point_to_polygon(DVec3::new(x, y, 0.0), DVec3::Z, &ceiling)
        })
    });
    assert_close(mean, polygon_to_polygon(&floor(), &ceiling), 1e-13);
    // Howell B-3, a point below the corner of a square as wide as it is far.
    let corner = point_to_polygon(DVec3::ZERO, DVec3::Z, &ceiling);
    assert_close(corner, (0.5f64.sqrt()).atan() / (PI * 2f64.sqrt()), 1e-15);
}

#[test]
fn discs_are_the_limit_of_polygons() {
    let disc = |m: usize, radius: f64, z: f64| -> Vec<DVec3> {
        (0..m)
            .map(|k| k as f64 * 2.0 * PI / m as f64 * if z > 0.0 { -1.0 } else { 1.0 })
            .map(|phi| DVec3::new(radius * phi.cos(), radius * phi.sin(), z))
            .collect()
    };
    for (r1, r2) in [(1.0, 1.0), (1.0, 2.0), (1.5, 0.5)] {
        let exact = coaxial_discs(r1, r2, 1.0);
        let error = |m| polygon_to_polygon(&disc(m, r1, 0.0), &disc(m, r2, 1.0)) - exact;
        // An inscribed polygon of m sides lacks (2π/m)²/6 of its disc: of the shooter's light,
        // and of the receiver, which can take no more than its area's share of it.
        let missing = (2.0 * PI / 32.0f64).powi(2) / 6.0;
        assert!(error(32).abs() < missing * (1.0 + (r2 / r1).powi(2)));
        assert_close(error(32) / error(64), 4.0, 0.05);
    }
}

#[test]
fn enclosures() {
    let printed = [
        (0.5, [1.09090910, 0.18174583, 0.18183627]),
        (0.7, [1.28654972, 0.40926241, 0.40938030]),
        (0.9, [2.37288137, 1.52531055, 1.52545202]),
    ];
    for (reflectance, expected) in printed {
        let radiosity = cube(reflectance);
        for (value, expected) in radiosity.into_iter().zip(expected) {
            assert_close(value, expected, 5e-9);
        }
        let [top, bottom, side] = radiosity;
        assert_close(top + bottom + 4.0 * side, furnace(1.0, reflectance), 1e-13);
    }
    assert_eq!(furnace(3.0, 0.25), 4.0);
}
