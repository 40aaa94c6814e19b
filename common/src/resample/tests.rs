//! Tests of resampling: conservation, and exact means of linear fields.

use super::*;
use crate::texel::texel_outline;
use approx::abs_diff_eq;
use glam::Vec3;

fn faces() -> [Face; 2] {
    let p = |x: f64, y: f64| DVec3::new(x, y, 0.5 * x - y);
    let quad = [p(0.0, 0.0), p(4.0, 0.5), p(3.0, 2.0), p(0.5, 1.0)];
    let triangle = [quad[0], quad[1], p(1.0, 3.0)];
    [
        Face::quad("q", quad, Vec3::ZERO, Vec3::ZERO),
        Face::triangle("t", triangle, Vec3::ZERO, Vec3::ZERO),
    ]
}

#[test]
fn average_conserves_the_area_integral_between_any_resolutions() {
    for face in faces() {
        for (n, m) in [(1, 7), (6, 6), (8, 4), (4, 8), (9, 6), (16, 15), (5, 13), (32, 3)] {
            let (from, to) = ([n, n], [m, m]);
            let pieces = shared_pieces(&face, from, to);
            let values: Vec<DVec3> = (0..n * n)
                .map(|k| DVec3::new(f64::from(k).sin(), 1.0, f64::from(k % 5)))
                .collect();
            let before: DVec3 = (0..n * n)
                .map(|k| values[k as usize] * texel_outline(&face, from, k).area())
                .sum();
            let averages = area_average(&values, &pieces, to);
            let after: DVec3 = (0..m * m)
                .map(|k| averages[k as usize] * texel_outline(&face, to, k).area())
                .sum();
            // Rounding only: n² + m² additions in f64.
            assert!((before - after).length() < 1e-12, "{n} {m}: {before} {after}");
            for (k, area) in summed_areas(&pieces, to).iter().enumerate() {
                let exact = texel_outline(&face, to, k as u32).area();
                assert!(
                    abs_diff_eq!(*area, exact, epsilon = 1e-13),
                    "{n} {m} {k}: {area} {exact}"
                );
            }
        }
    }
}

#[test]
fn quad_with_different_sides_has_all_pieces() {
    let face = &faces()[0];
    let pieces = shared_pieces(face, [6, 1], [4, 2]);
    let total: f64 = pieces.iter().map(|p| p.area).sum();
    assert!(abs_diff_eq!(total, face.area(), epsilon = 1e-13));
    assert_eq!(pieces.len(), (6 + 4 - 2) * 2);
}

#[test]
fn average_of_linear_field_is_its_value_at_the_centroid() {
    // The mean of a linear field over a texel is its value at the centroid.
    let field = |p: DVec3| DVec3::new(p.x, 1.0 + p.y, p.x - 2.0 * p.y);
    for face in faces() {
        let values: Vec<DVec3> = (0..144)
            .map(|k| field(texel_outline(&face, [12, 12], k).centroid()))
            .collect();
        for side in [1, 2, 3, 4, 6, 12] {
            let to = [side, side];
            let averages = area_average(&values, &shared_pieces(&face, [12, 12], to), to);
            for (k, mean) in averages.iter().enumerate() {
                let exact = field(texel_outline(&face, to, k as u32).centroid());
                assert!((*mean - exact).length() < 1e-12, "{side} {k}");
            }
        }
    }
}

#[test]
fn common_resolution_is_the_divisor_unless_too_coarse() {
    let square = |n| [n, n];
    for (a, b, expected) in [
        (16, 32, 16),
        (16, 16, 16),
        (16, 24, 8),
        (15, 16, 15),
        (7, 3, 1),
        (7, 5, 5),
    ] {
        assert_eq!(common_resolution(square(a), square(b)), square(expected));
    }
    assert_eq!(common_resolution([4, 9], [6, 3]), [2, 3]);
}

#[test]
fn independent_errors_fall_with_the_root_of_their_number() {
    let face = Face::quad(
        "unit",
        [DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y],
        Vec3::ZERO,
        Vec3::ZERO,
    );
    let pieces = shared_pieces(&face, [8, 8], [2, 2]);
    for error in average_standard_error(&[DVec3::splat(0.4); 64], &pieces, [2, 2]) {
        assert!((error - 0.1).length() < 1e-15);
    }
}
