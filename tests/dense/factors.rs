//! The dense solver's unoccluded form factors against closed forms, and its two independent methods against each other:
//! contour integral and product rule.

use approx::abs_diff_eq;
use common::polygon::distinct_corners;
use cpu::dense::contour_integral::contour_integral;
use cpu::dense::exchange_area::{SurfacePiece, exchange_area, facing_parts, form_factor};
use glam::{DMat3, DVec3};
use oracle::exact::{parallel_rectangles, perpendicular_rectangles};
use proptest::prelude::*;
use radiosity_tests::bounds::assert_near;
use radiosity_tests::factor_cases::{factor_cases, rectangle};
use radiosity_tests::random_cases;
use std::f64::consts::PI;

/// Required accuracy for every closed form.
const EXACT: f64 = 1e-8;

fn floor() -> [DVec3; 4] {
    rectangle([0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0])
}

/// Checks F of the outlines, and of triangles cut from either.
fn assert_printed(name: &str, a: &[DVec3], b: &[DVec3], expected: f64) {
    assert_near(name, form_factor(a, b), expected, EXACT);
    for (from, to) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
        let mut sum = 0.0;
        for part in fan_triangles(a, from) {
            for other in fan_triangles(b, to) {
                sum += form_factor(&part, &other) * SurfacePiece::from_outline(&part).area;
            }
        }
        let name = format!("{name}, triangles, diagonals {from} and {to}");
        assert_near(&name, sum / SurfacePiece::from_outline(a).area, expected, EXACT);
    }
}

/// Cuts an outline into triangles from its corner `first`.
fn fan_triangles(corners: &[DVec3], first: usize) -> Vec<[DVec3; 3]> {
    let n = corners.len();
    let corner = |k: usize| corners[(first + k) % n];
    (1..n - 1).map(|k| [corner(0), corner(k), corner(k + 1)]).collect()
}

/// Every closed form, in both directions; rectangles at small and large distances beside them.
#[test]
fn closed_forms_are_reproduced() {
    for case in factor_cases() {
        assert_printed(&case.name, case.from.outline(), case.to.outline(), case.exact);
    }
    for (a, b, c) in [
        (1.0, 0.001, 0.3),
        (0.1, 0.1, 5.0),
        (1.0, 1.0, 1e-2),
        (1.0, 1.0, 1e-3),
        (1.0, 1.0, 1e-4),
        (1.0, 1.0, 1e-5),
    ] {
        let low = rectangle([0.0; 3], [a, 0.0, 0.0], [0.0, b, 0.0]);
        let high = rectangle([0.0, 0.0, c], [0.0, b, 0.0], [a, 0.0, 0.0]);
        let name = format!("{a} × {b} at {c}");
        assert_near(&name, form_factor(&low, &high), parallel_rectangles(a, b, c), EXACT);
        let wall = rectangle([0.0; 3], [0.0, b, 0.0], [0.0, 0.0, c]);
        let name = format!("{a} × {b} and a wall {c} high");
        let exact = perpendicular_rectangles(b, a, c);
        assert_near(&name, form_factor(&low, &wall), exact, EXACT);
    }
}

#[test]
fn touching_and_averted_faces_exchange_nothing() {
    let down = rectangle([0.25, 0.25, 0.0], [0.0, 0.5, 0.0], [0.5, 0.0, 0.0]);
    assert_eq!(form_factor(&floor(), &down), 0.0);
    let up = rectangle([0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    assert_eq!(form_factor(&floor(), &up), 0.0);
    // The half of a wall below the floor's plane does not count.
    let wall = rectangle([0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [0.0, 0.0, 2.0]);
    let upper = perpendicular_rectangles(1.0, 1.0, 1.0);
    assert_near("cut wall", form_factor(&floor(), &wall), upper, EXACT);
}

/// Generates convex quads and triangles of size ≤ 1 around the origin, rotated at random.
fn any_convex_quad() -> impl Strategy<Value = [DVec3; 4]> {
    let shape = (0.1..1.0, 0.1..1.0, -0.3..0.3, 0.0..0.5, any::<bool>());
    let turn = (-PI..PI, -PI..PI, -PI..PI);
    (shape, turn).prop_map(|((w, h, skew, taper, triangle), (x, y, z))| {
        let turn = DMat3::from_euler(glam::EulerRot::XYZ, x, y, z);
        let top = if triangle { 0.0 } else { 1.0 - taper };
        [(0.0, 0.0), (w, 0.0), (w * top + skew, h), (skew, h)]
            .map(|(u, v)| turn * DVec3::new(u - w / 2.0, v - h / 2.0, 0.0))
    })
}

/// Makes a piece whose front faces `towards` a direction.
fn piece_facing(corners: &[DVec3; 4], towards: DVec3) -> SurfacePiece {
    let mut corners = distinct_corners(corners).to_vec();
    if SurfacePiece::from_outline(&corners).plane.normal.dot(towards) < 0.0 {
        corners.reverse();
    }
    SurfacePiece::from_outline(&corners)
}

proptest! {
    #![proptest_config(random_cases(2000))]

    /// Both methods agree wherever the product rule is used, and both are symmetric.
    #[test]
    fn product_rule_and_contour_integral_agree(
        a in any_convex_quad(),
        b in any_convex_quad(),
        direction in (-1.0..1.0, -1.0..1.0, -1.0..1.0),
        distance in 0.5f64..12.0,
    ) {
        let shift = DVec3::from(direction).normalize_or(DVec3::Z) * distance;
        let pair = facing_parts(&piece_facing(&a, shift), &piece_facing(&b.map(|p| p + shift), -shift));
        let Some((a, b)) = pair else { return Ok(()) };
        let (value, exact) = (exchange_area(&a, &b), contour_integral(&a.polygon, &b.polygon));
        let gap = (a.centre.distance(b.centre) - a.radius - b.radius).max(1e-3);
        // The rule's own tolerance, and what the contour integral loses to cancellation.
        let bound = 4e-9 * a.area * b.area / (PI * gap * gap) + 1e-13;
        prop_assert!(abs_diff_eq!(value, exact, epsilon = bound), "{value} {exact} {bound}");
        prop_assert!(abs_diff_eq!(value, exchange_area(&b, &a), epsilon = bound));
    }
}
