//! Warnings that no estimate gives: each comes where it must, and not beside it.

use common::scene::Face;
use common::settings::{Iteration, Meshing, Settings};
use glam::{DVec3, Vec3};
use oracle::solve::Answer;
use radiosity_tests::answers::{settings, solved};
use radiosity_tests::{furnace, lit_room, room, scene};

const GREY: Vec3 = Vec3::splat(0.5);

/// A parallelogram with its front along u × v.
fn square(corner: [f64; 3], u: [f64; 3], v: [f64; 3], emission: f32, reflectance: f32) -> Face {
    let [c, u, v] = [corner, u, v].map(DVec3::from);
    let corners = [c, c + u, c + u + v, c + v];
    Face::quad(
        "square",
        corners,
        Vec3::splat(emission),
        Vec3::splat(reflectance),
    )
}

/// A floor of one by one.
fn floor() -> Face {
    square([0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], 0.0, 0.5)
}

/// A lamp of one by one that looks down.
fn lamp(height: f64) -> Face {
    let corner = [0.0, 0.0, height];
    square(corner, [0.0, 1.0, 0.0], [1.0, 0.0, 0.0], 1.0, 0.0)
}

/// The faces that a warning names; none where it was not given.
fn warned(answer: &Answer, code: &str) -> Option<Vec<u32>> {
    let found = answer.warnings.iter().find(|w| w.code.text() == code)?;
    Some(found.faces.clone())
}

fn told(faces: Vec<Face>, code: &str) -> Option<Vec<u32>> {
    let answer = solved(&scene(code, faces), &settings());
    warned(&answer, code)
}

#[test]
fn fronts_on_each_other_are_named() {
    let patch = |height: f64| {
        let corner = [0.2, 0.3, height];
        square(corner, [0.5, 0.0, 0.0], [0.0, 0.5, 0.0], 0.0, 0.5)
    };
    let faces = |height: f64| vec![lamp(1.0), floor(), patch(height)];
    assert_eq!(told(faces(0.0), "overlap"), Some(vec![1, 2]));
    assert_eq!(told(faces(0.1), "overlap"), None);
}

#[test]
fn light_that_is_shot_into_a_gap_is_noticed_but_not_under_a_lamp() {
    // A block above the floor, which hides half of some texels.
    let block = |gap: f64| {
        let (low, high) = (DVec3::new(0.31, 0.37, gap), DVec3::new(0.61, 0.67, 0.5));
        let block = room(low, high, false, Vec3::ZERO, GREY);
        [vec![lamp(1.0), floor()], block].concat()
    };
    let faces = told(block(1e-3), "gap").unwrap();
    assert_eq!(faces[0], 1, "the floor first: {faces:?}");
    assert_eq!(told(block(0.3), "gap"), None);
    // A lamp that meets the floor at 3 degrees is as close, but it is light there.
    let (s, c) = 3f64.to_radians().sin_cos();
    let wedge = square([0.0; 3], [0.0, 1.0, 0.0], [c, 0.0, s], 1.0, 0.0);
    assert_eq!(told(vec![floor(), wedge], "gap"), None);
}

#[test]
fn a_lamp_under_a_body_at_all_of_its_samples_is_named() {
    let faces = |side: f64| {
        let below = square([0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], 1.0, 0.0);
        let above = square([0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0], 0.0, 0.5);
        let [low, high] = [0.5 - 0.5 * side, 0.5 + 0.5 * side];
        let (low, high) = (DVec3::new(low, low, 0.0), DVec3::new(high, high, 0.3));
        let body = room(low, high, false, Vec3::ZERO, Vec3::ZERO);
        [vec![above, below], body].concat()
    };
    assert_eq!(told(faces(0.999), "covered"), Some(vec![1]));
    assert_eq!(told(faces(0.7), "covered"), None);
}

#[test]
fn a_floor_that_no_light_was_found_to_reach_is_told() {
    // Two black shutters between a lamp and a floor, a chink or a window between them.
    let faces = |width: f64| {
        let shutter = |x: f64| square([x, -4.0, 0.5], [0.0, 9.0, 0.0], [4.0, 0.0, 0.0], 0.0, 0.0);
        let [left, right] = [0.5 - 0.5 * width - 4.0, 0.5 + 0.5 * width].map(shutter);
        let (low, high) = (DVec3::new(-4.0, -4.0, -1.0), DVec3::new(5.0, 5.0, 2.0));
        let walls = room(low, high, true, Vec3::ZERO, Vec3::ZERO);
        let backs = [left.clone().reversed(), right.clone().reversed()];
        [vec![lamp(1.0), floor(), left, right], backs.into(), walls].concat()
    };
    assert_eq!(told(faces(1e-6), "unlit"), Some(Vec::new()));
    assert_eq!(told(faces(0.3), "unlit"), None);
    // Nothing that could reflect is in front of these lamps.
    assert_eq!(told(vec![lamp(1.0)], "unlit"), None);
    assert_eq!(told(vec![lamp(1.0).reversed(), floor()], "unlit"), None);
}

#[test]
fn what_rounding_has_bent_is_named_where_it_carries_light() {
    let lamp = |width: f64, emission: f32| {
        let corner = [0.0, 0.5, 1.0];
        square(corner, [0.0, width, 0.0], [1.0, 0.0, 0.0], emission, 0.0)
    };
    let alone = |width: f64| vec![floor(), lamp(width, 1.0)];
    assert_eq!(told(alone(1e-7), "precision"), Some(vec![1]));
    assert_eq!(told(alone(1e-3), "precision"), None);
    // The same sliver beside a lamp that outshines it.
    let beside = [alone(1e-7), vec![lamp(0.1, 1.0)]].concat();
    assert_eq!(told(beside, "precision"), None);
}

#[test]
fn light_that_is_left_unshot_is_told() {
    let mut few = settings();
    few.schedule.max_shots = 1;
    few.schedule.iteration = Iteration::Southwell;
    let unshot = |settings: &Settings| warned(&solved(&lit_room(), settings), "unshot").is_some();
    assert!(unshot(&few));
    assert!(!unshot(&settings()));
}

/// A look cannot see a part in a thousand, but where walls reflect 0.999 of it that is a fifth of all
/// light.
#[test]
fn closure_is_told_where_white_walls_add_it_up() {
    let fine = Settings {
        meshing: Meshing {
            texels: 6,
            cells: 6,
            samples: 16,
        },
        ..settings()
    };
    let closure =
        |reflectance: f32| warned(&solved(&furnace(reflectance), &fine), "closure").is_some();
    assert!(closure(0.999));
    assert!(!closure(0.5));
}
