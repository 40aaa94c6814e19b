//! Scenes and helpers shared by tests.

use common::import::{ImportOptions, load_scene};
use common::scene::{Face, Scene, Shape};
use common::texel;
use glam::{DVec3, Vec3};
use proptest::prelude::*;
use proptest::test_runner::{Config, RngSeed};
use std::f64::consts::PI;
use std::path::Path;

pub mod bounds;
pub mod composites;
pub mod dense;
pub mod engines;
pub mod factor_cases;
pub mod painted;
pub mod radiance_files;
pub mod relighting;
pub mod served_pages;
pub mod shader_faults;
pub mod solutions;

pub use properties::{box_faces, named_scene};

/// Makes a ball of 2·(`rows` − 1)·`around` triangles.
pub fn ball(centre: DVec3, radius: f64, [rows, around]: [u32; 2]) -> Vec<Face> {
    let at = |i: u32, j: u32| {
        let (sin, cos) = (PI * f64::from(i) / f64::from(rows)).sin_cos();
        let (z, x) = (2.0 * PI * f64::from(j % around) / f64::from(around)).sin_cos();
        centre + DVec3::new(sin * x, cos, sin * z) * radius
    };
    let triangle = |corners| Face::triangle("ball", corners, Vec3::ZERO, Vec3::new(0.6, 0.5, 0.4));
    let mut faces = Vec::new();
    for (i, j) in (0..rows).flat_map(|i| (0..around).map(move |j| (i, j))) {
        let [a, b, c, d] = [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)];
        if i + 1 < rows {
            faces.push(triangle([a, c, d]));
        }
        if i > 0 {
            faces.push(triangle([a, b, c]));
        }
    }
    faces
}

/// Loads a scene of the folder `scenes`.
pub fn bundled_scene(file: &str) -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes").join(file);
    load_scene(&path, &ImportOptions::default()).unwrap()
}

/// Makes a closed room of six equal shooters (ties) around a grey box (silhouettes). No face is half a unit from a
/// wall: Table 3 clips there, and rounding would decide.
pub fn box_in_room() -> Scene {
    let walls = Vec3::new(0.7, 0.5, 0.2);
    let mut faces = box_faces(DVec3::ZERO, DVec3::ONE, true, Vec3::ONE, walls);
    let (low, high) = (DVec3::new(0.2, 0.1, 0.3), DVec3::new(0.47, 0.4, 0.55));
    faces.extend(box_faces(low, high, false, Vec3::ZERO, Vec3::splat(0.4)));
    named_scene("a box in a room", faces)
}

/// Makes the closed unit cube in which every face emits 1 W/m² and reflects `reflectance`.
pub fn furnace(reflectance: f32) -> Scene {
    named_scene(
        "furnace",
        box_faces(DVec3::ZERO, DVec3::ONE, true, Vec3::ONE, Vec3::splat(reflectance)),
    )
}

/// Makes a closed room, 3 × 2 × 4, with a floating box of six faces; the ceiling is a lamp. No two faces have the same
/// power.
pub fn lit_room() -> Scene {
    let size = DVec3::new(3.0, 2.0, 4.0);
    let mut faces = box_faces(DVec3::ZERO, size, true, Vec3::ZERO, Vec3::new(0.7, 0.6, 0.5));
    faces[1].emission = Vec3::new(5.0, 4.0, 3.0);
    faces[2].reflectance = Vec3::new(0.8, 0.1, 0.1);
    faces[3].reflectance = Vec3::new(0.1, 0.8, 0.1);
    let (low, high) = (DVec3::new(0.5, 0.25, 0.75), DVec3::new(1.25, 1.5, 2.0));
    faces.extend(box_faces(low, high, false, Vec3::ZERO, Vec3::splat(0.3)));
    named_scene("lit room", faces)
}

/// Divides each face into N×N faces.
pub fn divide_faces(faces: &[Face], side: u32) -> Vec<Face> {
    let parts = faces
        .iter()
        .flat_map(|face| (0..side * side).map(move |part| (face, part)));
    let face = |(face, part): (&Face, u32)| Face {
        corners: texel::texel_outline(face, [side, side], part).padded_corners(),
        ..face.clone()
    };
    parts.map(face).collect()
}

/// Returns the paper's room without its objects: the unit cube, each wall 5×5 faces, and a lamp box under the ceiling; 156
/// faces.
pub fn paper_room() -> Scene {
    bundled_scene("paper_room.obj")
}

/// Draws a face with corners on a lattice of so many steps either side of `offset`; it may be a point or a line.
pub fn any_lattice_face(steps: i32, offset: f64, emission: Vec3, reflectance: Vec3) -> impl Strategy<Value = Face> {
    let corner = move || {
        let at = prop::array::uniform3(-steps..=steps);
        at.prop_map(move |p| DVec3::from(p.map(f64::from)) + offset)
    };
    (corner(), corner(), corner(), any::<bool>()).prop_map(move |(a, b, c, is_quad)| {
        if is_quad {
            Face::quad("", [a, b, b + c - a, c], emission, reflectance)
        } else {
            Face::triangle("", [a, b, c], emission, reflectance)
        }
    })
}

/// Configures `count` random cases, the same in every run unless PROPTEST_RNG_SEED or PROPTEST_CASES are set.
pub fn random_cases(count: u32) -> Config {
    let mut config = Config {
        failure_persistence: None,
        ..Config::default()
    };
    if config.rng_seed == RngSeed::Random {
        config.rng_seed = RngSeed::Fixed(1);
    }
    if std::env::var_os("PROPTEST_CASES").is_none() {
        config.cases = count;
    }
    config.max_global_rejects = config.cases.max(1024);
    config
}

/// Returns the triangle with another corner first: the same face.
pub fn rotate_triangle(face: &Face, by: usize) -> Face {
    let [a, b, c, _] = face.corners;
    let corners = [[a, b, c], [b, c, a], [c, a, b]][by % 3];
    Face {
        corners: [corners[0], corners[1], corners[2], corners[2]],
        ..face.clone()
    }
}

/// Splits each quad into two triangles that begin at different corners.
pub fn halve_quads(scene: &Scene) -> Scene {
    let mut faces = Vec::new();
    for (k, face) in scene.faces.iter().enumerate() {
        assert_eq!(face.shape, Shape::Quad);
        let [a, b, c, d] = face.corners;
        for (half, corners) in [[a, b, c], [a, c, d]].into_iter().enumerate() {
            let triangle = Face::triangle(&face.name, corners, face.emission, face.reflectance);
            faces.push(rotate_triangle(&triangle, k + half));
        }
    }
    crate::named_scene("halved", faces)
}
