//! Small scenes for tests of pictures and report.

use common::scene::{Face, Scene};
use glam::{DVec3, Vec3};
use radiosity_tests::named_scene;

const WHITE: Vec3 = Vec3::splat(0.7);
const DARK: Vec3 = Vec3::ZERO;

/// Makes a parallelogram of n×m quads with front e1 × e2.
pub fn quad_grid(name: &str, at: DVec3, e: [DVec3; 2], n: [u32; 2], light: [Vec3; 2]) -> Vec<Face> {
    let p = |i: u32, j: u32| at + e[0] * f64::from(i) / f64::from(n[0]) + e[1] * f64::from(j) / f64::from(n[1]);
    (0..n[0] * n[1])
        .map(|k| {
            let (i, j) = (k % n[0], k / n[0]);
            let corners = [p(i, j), p(i + 1, j), p(i + 1, j + 1), p(i, j + 1)];
            Face::quad(name, corners, light[0], light[1])
        })
        .collect()
}

/// Makes a floor of quads and triangles of different sizes, with T-junctions, and a light above.
pub fn patchwork_floor() -> Scene {
    let p = |x: f64, z: f64| DVec3::new(x, 0.0, z);
    let quad = |c: [DVec3; 4]| Face::quad("floor", c, DARK, WHITE);
    let triangle = |c: [DVec3; 3]| Face::triangle("floor", c, DARK, WHITE);
    let faces = vec![
        quad([p(0.0, 0.0), p(0.0, 1.0), p(1.0, 1.0), p(1.0, 0.0)]),
        quad([p(1.0, 0.0), p(1.0, 0.5), p(1.5, 0.5), p(1.5, 0.0)]),
        quad([p(1.0, 0.5), p(1.0, 1.0), p(1.5, 1.0), p(1.5, 0.5)]),
        triangle([p(1.5, 0.0), p(1.5, 1.0), p(2.0, 1.0)]),
        triangle([p(2.0, 0.0), p(1.5, 0.0), p(2.0, 1.0)]),
        triangle([p(0.0, 1.0), p(0.0, 1.7), p(1.3, 1.0)]),
        quad([p(1.3, 1.0), p(0.0, 1.7), p(1.6, 1.9), p(2.0, 1.0)]),
        Face::quad(
            "light",
            [p(0.7, 0.7), p(1.2, 0.7), p(1.2, 1.2), p(0.7, 1.2)].map(|q| q.with_y(0.6)),
            Vec3::splat(5.0),
            DARK,
        ),
    ];
    named_scene("patchwork", faces)
}
