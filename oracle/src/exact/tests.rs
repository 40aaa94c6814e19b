//! Compares each method with printed values and with the other methods.

use super::*;
use approx::abs_diff_eq;

/// Tolerance of the printed values, which have ten digits.
const PRINTED_TOLERANCE: f64 = 5e-11;

fn assert_close(value: f64, expected: f64, tolerance: f64) {
    assert!(
        abs_diff_eq!(value, expected, epsilon = tolerance),
        "{value} is not {expected} ± {tolerance}"
    );
}

/// Returns the rectangle from `corner` along `u` and `v`; its front is u × v.
fn spanned_rectangle(corner: [f64; 3], u: [f64; 3], v: [f64; 3]) -> Vec<DVec3> {
    let [c, u, v] = [corner, u, v].map(DVec3::from);
    vec![c, c + u, c + u + v, c + v]
}

fn floor_square() -> Vec<DVec3> {
    spanned_rectangle([0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0])
}

/// Returns the unit square that shares the floor's edge x = 0 at `degrees`, fronts facing.
fn hinged_square(degrees: f64) -> Vec<DVec3> {
    let (s, c) = degrees.to_radians().sin_cos();
    spanned_rectangle([0.0; 3], [0.0, 1.0, 0.0], [c, 0.0, s])
}

#[test]
fn closed_forms_match_printed_values() {
    assert_close(parallel_rectangles(1.0, 1.0, 1.0), 0.1998248957, PRINTED_TOLERANCE);
    assert_close(perpendicular_rectangles(1.0, 1.0, 1.0), 0.2000437761, PRINTED_TOLERANCE);
    assert_close(parallel_rectangles(1.0, 1.5, 0.5), 0.4756, 5e-5);
    assert_close(parallel_rectangles(0.1, 0.1, 0.05), 0.4153, 5e-5);
    assert_close(coaxial_discs(1.0, 1.0, 1.0), 0.3819660113, PRINTED_TOLERANCE);
    let sum = parallel_rectangles(1.0, 1.0, 1.0) + 4.0 * perpendicular_rectangles(1.0, 1.0, 1.0);
    assert_close(sum, 1.0, 1e-14);
}

#[test]
fn contour_integral_matches_closed_forms_at_any_size() {
    for (a, b, c) in [(1.0, 1.0, 0.01), (3.0, 0.2, 1.0), (0.1, 0.1, 5.0), (7.0, 2.0, 0.5)] {
        let low = spanned_rectangle([0.0; 3], [a, 0.0, 0.0], [0.0, b, 0.0]);
        let high = spanned_rectangle([0.0, 0.0, c], [0.0, b, 0.0], [a, 0.0, 0.0]);
        // Logarithms that nearly cancel: ε of the integral against F·2πA.
        let tolerance = 1e-13 * (1.0 + c * c / (a * b));
        assert_close(polygon_to_polygon(&low, &high), parallel_rectangles(a, b, c), tolerance);
        let wall = spanned_rectangle([0.0; 3], [0.0, b, 0.0], [0.0, 0.0, c]);
        assert_close(
            polygon_to_polygon(&low, &wall),
            perpendicular_rectangles(b, a, c),
            tolerance,
        );
    }
}

#[test]
fn parts_behind_the_other_plane_are_ignored() {
    // A wall from z = −1 to 1 shows the floor its upper half only; the floor x ∈ [−1, 1] shows
    // the wall x = 0 its right half only.
    let wall = spanned_rectangle([0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [0.0, 0.0, 2.0]);
    let wide = spanned_rectangle([-1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    let corner = perpendicular_rectangles(1.0, 1.0, 1.0);
    assert_close(polygon_to_polygon(&floor_square(), &wall), corner, 1e-13);
    assert_close(polygon_to_polygon(&wide, &wall), corner / 2.0, 1e-13);
    let back: Vec<DVec3> = wall.iter().rev().copied().collect();
    assert_eq!(polygon_to_polygon(&floor_square(), &back), 0.0);
    let point = DVec3::new(0.3, 0.6, 0.0);
    let upper = hinged_square(90.0);
    let whole = point_to_polygon(point, DVec3::Z, &wall);
    assert_close(whole, point_to_polygon(point, DVec3::Z, &upper), 1e-15);
    assert_eq!(point_to_polygon(point, DVec3::Z, &back), 0.0);
    assert_eq!(point_to_polygon(point, DVec3::NEG_Z, &upper), 0.0);
}

#[test]
fn mean_of_point_factors_equals_contour_integral() {
    let ceiling = spanned_rectangle([0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]);
    let mean = tanh_sinh_quadrature(0.0, 1.0, |x| {
        tanh_sinh_quadrature(0.0, 1.0, |y| {
            point_to_polygon(DVec3::new(x, y, 0.0), DVec3::Z, &ceiling)
        })
    });
    assert_close(mean, polygon_to_polygon(&floor_square(), &ceiling), 1e-13);
    // Howell B-3, a point below the corner of a square as wide as it is far.
    let corner = point_to_polygon(DVec3::ZERO, DVec3::Z, &ceiling);
    assert_close(corner, (0.5f64.sqrt()).atan() / (PI * 2f64.sqrt()), 1e-15);
}

#[test]
fn polygon_factors_converge_to_disc_factors() {
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
fn enclosures_have_the_printed_radiosities() {
    let printed = [
        (0.5, [1.09090910, 0.18174583, 0.18183627]),
        (0.7, [1.28654972, 0.40926241, 0.40938030]),
        (0.9, [2.37288137, 1.52531055, 1.52545202]),
    ];
    for (reflectance, expected) in printed {
        let radiosity = cube_radiosities(reflectance);
        for (value, expected) in radiosity.into_iter().zip(expected) {
            assert_close(value, expected, 5e-9);
        }
        let [top, bottom, side] = radiosity;
        assert_close(top + bottom + 4.0 * side, furnace_radiosity(1.0, reflectance), 1e-13);
    }
    assert_eq!(furnace_radiosity(3.0, 0.25), 4.0);
}
