//! Small scenes for tests of pictures and report.

use super::bundled::bundled_scene;
use common::mesh::Mesh;
use common::scene::{Face, Scene};
use common::settings::Settings;
use common::shooting::{SolveRun, shoot_until_converged};
use cpu::CpuSolver;
use glam::{DVec3, Vec3};
use std::ops::ControlFlow;

const WHITE: Vec3 = Vec3::splat(0.7);
const RED: Vec3 = Vec3::new(0.6, 0.06, 0.05);
const GREEN: Vec3 = Vec3::new(0.12, 0.45, 0.1);
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

/// Makes the walls of the unit room but for the front (z = 0) and the ceiling.
fn unit_room_walls() -> Vec<Face> {
    let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
    let mut faces = Vec::new();
    let mut wall = |name: &str, at: DVec3, e: [DVec3; 2], colour: Vec3| {
        faces.extend(quad_grid(name, at, e, [1, 1], [DARK, colour]));
    };
    wall("floor", DVec3::ZERO, [z, x], WHITE);
    wall("back", z, [y, x], WHITE);
    wall("left", DVec3::ZERO, [y, z], GREEN);
    wall("right", x, [z, y], RED);
    faces
}

/// Makes a scene like the Cornell box: open towards −z, y up, the light in the middle of a ceiling of four
/// strips, all five in one plane and of different size.
pub fn cornell_like_box() -> Scene {
    let mut faces = unit_room_walls();
    let strip = |name: &str, x: [f64; 2], z: [f64; 2], light: [Vec3; 2]| {
        let e = [DVec3::X * (x[1] - x[0]), DVec3::Z * (z[1] - z[0])];
        quad_grid(name, DVec3::new(x[0], 1.0, z[0]), e, [1, 1], light)
    };
    let white = [DARK, WHITE];
    faces.extend(strip("ceiling", [0.0, 0.35], [0.0, 1.0], white));
    faces.extend(strip("ceiling", [0.65, 1.0], [0.0, 1.0], white));
    faces.extend(strip("ceiling", [0.35, 0.65], [0.0, 0.35], white));
    faces.extend(strip("ceiling", [0.35, 0.65], [0.65, 1.0], white));
    let light = [Vec3::new(18.0, 14.0, 9.0), Vec3::splat(0.2)];
    faces.extend(strip("light", [0.35, 0.65], [0.35, 0.65], light));
    faces.extend(bundled_scene("paper_objects.obj").faces);
    Scene {
        name: "cornell-like".into(),
        faces,
        notes: Vec::new(),
    }
}

/// Reads the paper's room: 6 walls of 5×5 faces, a lamp box, two boxes; 168 faces.
pub fn paper_room() -> Scene {
    bundled_scene("paper_room_objects.obj")
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
    Scene {
        name: "patchwork".into(),
        faces,
        notes: Vec::new(),
    }
}

/// Shoots on the CPU until the schedule ends.
pub fn shoot_freely(mesh: &Mesh, settings: &Settings) -> SolveRun {
    let mut solver = CpuSolver::new(mesh, &settings.transport);
    shoot_until_converged(&mut solver, &settings.schedule, &mut |_, _| ControlFlow::Continue(())).unwrap()
}
