//! Warnings that do not come from the estimate: each is given where it applies and not in a similar scene.

use common::scene::Face;
use common::settings::{Iteration, Settings};
use glam::{DVec3, Vec3};
use oracle::solve::SolveAnswer;
use radiosity_tests::factor_cases::rectangle;
use radiosity_tests::solutions::{solve_on_cpu, solve_settings};
use radiosity_tests::{box_faces, furnace, lit_room, named_scene};

const GREY: Vec3 = Vec3::splat(0.5);

/// Makes a parallelogram with its front along u × v.
fn square_face(corner: [f64; 3], u: [f64; 3], v: [f64; 3], emission: f32, reflectance: f32) -> Face {
    Face::quad(
        "square",
        rectangle(corner, u, v),
        Vec3::splat(emission),
        Vec3::splat(reflectance),
    )
}

/// Makes a floor of one by one.
fn unit_floor() -> Face {
    square_face([0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], 0.0, 0.5)
}

/// Makes a lamp of one by one that faces down.
fn lamp(height: f64) -> Face {
    let corner = [0.0, 0.0, height];
    square_face(corner, [0.0, 1.0, 0.0], [1.0, 0.0, 0.0], 1.0, 0.0)
}

/// Returns the faces that a warning of `code` names whose message has `words`; none if it was not given.
fn warned_faces(answer: &SolveAnswer, code: &str, words: &str) -> Option<Vec<u32>> {
    let mut warnings = answer.warnings.iter();
    let found = warnings.find(|w| w.code.as_str() == code && w.message.contains(words))?;
    Some(found.faces.clone())
}

fn warned_faces_of_solve(faces: Vec<Face>, code: &str, words: &str) -> Option<Vec<u32>> {
    let answer = solve_on_cpu(&named_scene(code, faces), &solve_settings());
    warned_faces(&answer, code, words)
}

#[test]
fn coinciding_fronts_are_warned() {
    let patch = |height: f64| {
        let corner = [0.2, 0.3, height];
        square_face(corner, [0.5, 0.0, 0.0], [0.0, 0.5, 0.0], 0.0, 0.5)
    };
    let faces = |height: f64| vec![lamp(1.0), unit_floor(), patch(height)];
    assert_eq!(warned_faces_of_solve(faces(0.0), "overlap", ""), Some(vec![1, 2]));
    assert_eq!(warned_faces_of_solve(faces(0.1), "overlap", ""), None);
}

#[test]
fn narrow_gap_is_warned_except_below_a_lamp() {
    // A block above the floor, which hides half of some texels.
    let block = |gap: f64| {
        let (low, high) = (DVec3::new(0.31, 0.37, gap), DVec3::new(0.61, 0.67, 0.5));
        let block = box_faces(low, high, false, Vec3::ZERO, GREY);
        [vec![lamp(1.0), unit_floor()], block].concat()
    };
    let faces = warned_faces_of_solve(block(1e-3), "texels", "into gaps").unwrap();
    assert_eq!(faces[0], 1, "the floor first: {faces:?}");
    assert_eq!(warned_faces_of_solve(block(0.3), "texels", "into gaps"), None);
    // A lamp that meets the floor at 3 degrees is as close, but lights it there.
    let (s, c) = 3f64.to_radians().sin_cos();
    let wedge = square_face([0.0; 3], [0.0, 1.0, 0.0], [c, 0.0, s], 1.0, 0.0);
    assert_eq!(
        warned_faces_of_solve(vec![unit_floor(), wedge], "texels", "into gaps"),
        None
    );
}

#[test]
fn lamp_covered_at_all_samples_is_warned() {
    let faces = |side: f64| {
        let below = square_face([0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], 1.0, 0.0);
        let above = square_face([0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0], 0.0, 0.5);
        let [low, high] = [0.5 - 0.5 * side, 0.5 + 0.5 * side];
        let (low, high) = (DVec3::new(low, low, 0.0), DVec3::new(high, high, 0.3));
        let body = box_faces(low, high, false, Vec3::ZERO, Vec3::ZERO);
        [vec![above, below], body].concat()
    };
    assert_eq!(
        warned_faces_of_solve(faces(0.999), "unlit", "every lamp lies under"),
        Some(vec![1])
    );
    assert_eq!(
        warned_faces_of_solve(faces(0.7), "unlit", "every lamp lies under"),
        None
    );
}

#[test]
fn floor_behind_thin_chink_is_warned_as_unlit() {
    // Two black shutters between a lamp and a floor, a chink or a window between them.
    let faces = |width: f64| {
        let shutter = |x: f64| square_face([x, -4.0, 0.5], [0.0, 9.0, 0.0], [4.0, 0.0, 0.0], 0.0, 0.0);
        let [left, right] = [0.5 - 0.5 * width - 4.0, 0.5 + 0.5 * width].map(shutter);
        let (low, high) = (DVec3::new(-4.0, -4.0, -1.0), DVec3::new(5.0, 5.0, 2.0));
        let walls = box_faces(low, high, true, Vec3::ZERO, Vec3::ZERO);
        let backs = [left.clone().reversed(), right.clone().reversed()];
        [vec![lamp(1.0), unit_floor(), left, right], backs.into(), walls].concat()
    };
    assert_eq!(warned_faces_of_solve(faces(1e-6), "unlit", ""), Some(Vec::new()));
    assert_eq!(warned_faces_of_solve(faces(0.3), "unlit", ""), None);
    // No reflecting face is in front of these lamps.
    assert_eq!(warned_faces_of_solve(vec![lamp(1.0)], "unlit", ""), None);
    assert_eq!(
        warned_faces_of_solve(vec![lamp(1.0).reversed(), unit_floor()], "unlit", ""),
        None
    );
}

#[test]
fn scene_without_lamp_is_noted_and_has_no_estimate() {
    let answer = solve_on_cpu(&named_scene("dark", vec![unit_floor()]), &solve_settings());
    assert!(answer.estimate.is_none() && answer.warnings.is_empty());
    assert!(answer.notes[0].starts_with("no face emits light"), "{:?}", answer.notes);
}

#[test]
fn sliver_bent_by_rounding_is_warned_if_it_carries_light() {
    let lamp = |width: f64, emission: f32| {
        let corner = [0.0, 0.5, 1.0];
        square_face(corner, [0.0, width, 0.0], [1.0, 0.0, 0.0], emission, 0.0)
    };
    let alone = |width: f64| vec![unit_floor(), lamp(width, 1.0)];
    assert_eq!(warned_faces_of_solve(alone(1e-7), "precision", ""), Some(vec![1]));
    assert_eq!(warned_faces_of_solve(alone(1e-3), "precision", ""), None);
    // The same sliver beside a much brighter lamp.
    let beside = [alone(1e-7), vec![lamp(0.1, 1.0)]].concat();
    assert_eq!(warned_faces_of_solve(beside, "precision", ""), None);
}

#[test]
fn unshot_light_is_warned() {
    let mut few = solve_settings();
    few.schedule.max_shots = 1;
    few.schedule.iteration = Iteration::Southwell;
    let unshot = |settings: &Settings| warned_faces(&solve_on_cpu(&lit_room(), settings), "unshot", "").is_some();
    assert!(unshot(&few));
    assert!(!unshot(&solve_settings()));
}

/// The estimate does not resolve a thousandth, but between walls that reflect 0.999 this adds up to a fifth of all
/// light.
#[test]
fn closure_is_warned_between_white_walls() {
    let mut fine = solve_settings();
    fine.meshing.patches = 6;
    fine.meshing.texels = 6;
    fine.meshing.samples = 16;
    let closure = |reflectance: f32| warned_faces(&solve_on_cpu(&furnace(reflectance), &fine), "closure", "").is_some();
    assert!(closure(0.999));
    assert!(!closure(0.5));
}
