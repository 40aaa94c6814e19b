//! Map projections: orientation, solid angles and interpolation across seams.

use common::capture::MapProjection;
use glam::{DVec2, DVec3, Vec3};
use radiosity_tests::radiance_files::{irradiance_at_eye, mean_radiance, paint_panorama};
use std::f64::consts::PI;

const MAPS: [(MapProjection, [usize; 2]); 4] = [
    (MapProjection::LatLong, [64, 32]),
    (MapProjection::LatLong, [33, 16]),
    (MapProjection::Cube, [32, 192]),
    (MapProjection::Angular, [64, 64]),
];

/// Directions all over the sphere, including the six axes and their surroundings.
fn directions() -> Vec<DVec3> {
    let mut directions = Vec::new();
    let golden = PI * (3.0 - 5_f64.sqrt());
    for k in 0..20_000 {
        let y = 1.0 - (2.0 * f64::from(k) + 1.0) / 20_000.0;
        let (sin, cos) = (golden * f64::from(k)).sin_cos();
        directions.push(DVec3::new(sin * (1.0 - y * y).sqrt(), y, cos * (1.0 - y * y).sqrt()));
    }
    for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
        for side in [axis, -axis] {
            for offset in [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z, DVec3::ONE] {
                directions.push((side + offset * 1e-9).normalize());
                directions.push((side - offset * 1e-3).normalize());
            }
        }
    }
    directions
}

#[test]
fn position_and_direction_are_inverse() {
    for (projection, size) in MAPS {
        for d in directions() {
            let at = projection.position_of(size, d);
            let inside = DVec2::new(size[0] as f64, size[1] as f64);
            assert!(
                at.cmpge(DVec2::ZERO).all() && at.cmple(inside).all(),
                "{projection:?} {d} {at}"
            );
            let back = projection.direction_at(size, at);
            assert!((back - d).length() < 1e-9, "{projection:?} {d} {at} {back}");
        }
    }
}

#[test]
fn map_centre_looks_along_z_with_x_to_its_left() {
    let at = |projection: MapProjection, size, x: f64, y: f64| projection.direction_at(size, DVec2::new(x, y));
    let near = |a: DVec3, b: DVec3| assert!((a - b).length() < 1e-12, "{a} {b}");
    let lat_long = |x, y| at(MapProjection::LatLong, [64, 32], x, y);
    near(lat_long(32.0, 16.0), DVec3::Z);
    near(lat_long(16.0, 16.0), DVec3::X);
    near(lat_long(48.0, 16.0), DVec3::NEG_X);
    near(lat_long(5.0, 0.0), DVec3::Y);
    near(lat_long(0.0, 16.0), DVec3::NEG_Z);
    let angular = |x, y| at(MapProjection::Angular, [64, 64], x, y);
    near(angular(32.0, 32.0), DVec3::Z);
    near(angular(48.0, 32.0), DVec3::NEG_X);
    near(angular(32.0, 16.0), DVec3::Y);
    near(angular(0.0, 32.0), DVec3::NEG_Z);
    // OpenEXR's ImfEnvmap.h: each square's middle, and the directions at its right and upper edges.
    let squares = [
        (DVec3::X, DVec3::Z, DVec3::Y),
        (DVec3::NEG_X, DVec3::NEG_Z, DVec3::Y),
        (DVec3::Y, DVec3::X, DVec3::Z),
        (DVec3::NEG_Y, DVec3::X, DVec3::NEG_Z),
        (DVec3::Z, DVec3::NEG_X, DVec3::Y),
        (DVec3::NEG_Z, DVec3::X, DVec3::Y),
    ];
    for (k, (middle, right, up)) in squares.into_iter().enumerate() {
        let cube = |x, y| at(MapProjection::Cube, [32, 192], x, 32.0 * k as f64 + y);
        near(cube(16.0, 16.0), middle);
        near(cube(32.0, 16.0), (middle + right).normalize());
        near(cube(16.0, 0.0), (middle + up).normalize());
    }
}

#[test]
fn solid_angles_are_exact() {
    for (projection, size) in MAPS {
        let pixels = (0..size[0] * size[1]).map(|k| [k % size[0], k / size[0]]);
        let mut whole = 0.0;
        for pixel in pixels {
            let exact = projection.solid_angle(size, pixel);
            whole += exact;
            // The polygon of the pixel's corners in eight parts a side, as triangles.
            let centre = DVec2::new(pixel[0] as f64 + 0.5, pixel[1] as f64 + 0.5);
            let half = size[0] as f64 / 2.0;
            if projection == MapProjection::Angular && (centre - half).length() > half - 4.0 {
                continue;
            }
            let measured: f64 = (0..64)
                .map(|part| {
                    let low = DVec2::new((part % 8) as f64, (part / 8) as f64) / 8.0 + centre - 0.5;
                    let at = |x: f64, y: f64| {
                        // Slightly inside, because the square changes at the border of a cube map's square.
                        let inside = centre + (low + DVec2::new(x, y) / 8.0 - centre) * (1.0 - 1e-9);
                        projection.direction_at(size, inside)
                    };
                    let [a, b, c, d] = [at(0.0, 0.0), at(1.0, 0.0), at(1.0, 1.0), at(0.0, 1.0)];
                    ((b - a).cross(c - a).length() + (c - a).cross(d - a).length()) / 2.0
                })
                .sum();
            // Triangles for curved pieces: (h/8)²/8, h the pixel's size by its distance from where
            // the map is singular, 1/2 at most (a lat-long map's poles, an angular map's rim).
            let error = measured / exact - 1.0;
            let bound = 5e-4;
            assert!(error.abs() < bound, "{projection:?} {pixel:?} {error}");
        }
        // Exact except at an angular map's rim, whose pixels are integrated by 8×8 points.
        let error = whole / (4.0 * PI) - 1.0;
        let bound = if projection == MapProjection::Angular {
            1e-4
        } else {
            1e-12
        };
        assert!(error.abs() < bound, "{projection:?} {error}");
    }
}

/// A smooth radiance, different in all directions.
fn smooth(d: DVec3) -> Vec3 {
    let value = |a: f64, b: f64| 2.0 + a + a * b;
    Vec3::new(value(d.x, d.z) as f32, value(d.y, d.x) as f32, value(d.z, d.y) as f32)
}

#[test]
fn interpolated_radiance_is_continuous() {
    for (projection, size) in MAPS {
        let map = paint_panorama(projection, size, smooth);
        let mut worst = (0.0, DVec3::ZERO);
        for d in directions() {
            let error = (map.radiance(d) - smooth(d)).abs().max_element();
            if error > worst.0 {
                worst = (error, d);
            }
        }
        // Bilinear: h²/8 × the second derivatives (4 and 4) along both axes. At an angular map's rim, beyond which
        // there are no pixels, the error is of first order.
        let h = match projection {
            MapProjection::LatLong | MapProjection::Angular => 2.0 * PI / size[0] as f64,
            MapProjection::Cube => 2.0 / size[0] as f64,
        };
        let bound = if projection == MapProjection::LatLong { h * h } else { h };
        assert!(f64::from(worst.0) < bound, "{projection:?}: {worst:?}, {bound}");
    }
}

#[test]
fn mean_and_irradiance_agree_between_projections() {
    for (projection, size) in MAPS {
        let map = paint_panorama(projection, size, smooth);
        // ∫ of smooth: the mean is 2, since a and ab are odd; E(n) = π (2 + 2/3 n) + ∫ ab cos, 0.
        let mean = mean_radiance(&map) - 2.0;
        assert!(mean.abs().max_element() < 4e-3, "{projection:?} {mean}");
        for normal in [DVec3::X, DVec3::NEG_Y, DVec3::Z] {
            let exact = (DVec3::new(normal.x, normal.y, normal.z) * (2.0 / 3.0) + 2.0) * PI;
            let error = (irradiance_at_eye(&map, normal) - exact).abs().max_element();
            // The midpoint rule: h²/24 × the second derivatives of L cosθ over the hemisphere.
            let h = PI / (size[0] as f64 / 2.0);
            assert!(error < 1.5 * h * h, "{projection:?} {normal} {error}");
        }
    }
}
