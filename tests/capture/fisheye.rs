//! Conversion of a circular fisheye picture to an angular map.

use common::capture::{MapProjection, Panorama};
use glam::{DVec3, Vec3};
use radiosity::merge::fisheye::to_angular_map;

#[test]
fn fisheye_picture_becomes_angular_map() {
    // Wider than its circle; every pixel has its own value.
    let (size, circle) = ([30_usize, 20_usize], 20_usize);
    let pixels: Vec<Vec3> = (1..=600).map(|k| Vec3::splat(k as f32)).collect();
    for (degrees, expected) in [(180.0, 40), (360.0, 20), (150.0, 48), (222.0, 32)] {
        let (side, map) = to_angular_map(size, &pixels, degrees).unwrap();
        assert_eq!(side, expected, "{degrees}");
        let map = Panorama::from_pixels([side; 2], map, Some(MapProjection::Angular)).unwrap();
        for (x, y) in [(9, 10), (14, 12), (3, 7), (10, 1), (18, 9), (0, 0), (19, 19)] {
            // The right of a photograph is −x, up is y, and the lens looks along +z.
            let [u, v] = [x, y].map(|k| (2 * k + 1) as f64 / circle as f64 - 1.0);
            let radius = f64::hypot(u, v);
            let theta = radius * (degrees / 2.0_f64).to_radians();
            let sin = theta.sin() / radius;
            let direction = DVec3::new(-u * sin, -v * sin, theta.cos());
            let at = map.projection().position_of([side; 2], direction);
            let found = map.pixels()[at.y as usize * side + at.x as usize].x;
            let value = if radius < 1.0 { pixels[y * 30 + x + 5].x } else { 0.0 };
            if radius < 1.0 || theta < std::f64::consts::PI {
                assert_eq!(found, value, "{degrees}: {x}, {y}");
            }
        }
        // Outside the field of view the map is black.
        let lit = map.pixels().iter().filter(|p| p.x > 0.0).count();
        let disc = (0..400).filter(|k| {
            let [u, v] = [k % 20, k / 20].map(|k| f64::from(2 * k + 1) / 20.0 - 1.0);
            u.hypot(v) < 1.0
        });
        assert_eq!(lit, disc.count());
    }
    for wrong in [0.0, -180.0, 361.0, f64::NAN, 0.001] {
        let error = to_angular_map(size, &pixels, wrong).unwrap_err().to_string();
        assert!(error.contains("--fisheye"), "{error}");
    }
}
