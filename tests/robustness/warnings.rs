//! Warnings: each is given where it applies and not in a similar scene.

use common::scene::Face;
use common::settings::{Iteration, Settings};
use glam::{DVec3, Vec3};
use oracle::solve::SolveAnswer;
use oracle::solve::error_estimate::closure_error;
use radiosity_tests::factor_cases::rectangle;
use radiosity_tests::solutions::{solve_on_cpu, solve_settings, solve_to_error};
use radiosity_tests::{box_faces, furnace, lit_room, named_scene};

const GREY_REFLECTANCE: Vec3 = Vec3::splat(0.5);

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

/// Makes a floor and a plate of this height above a part of it.
fn plate_on_floor(height: f64) -> Vec<Face> {
    let corner = [0.2, 0.3, height];
    let plate = square_face(corner, [0.5, 0.0, 0.0], [0.0, 0.5, 0.0], 0.0, 0.5);
    vec![lamp(1.0), unit_floor(), plate]
}

/// Makes a block above the floor, which hides half of some texels.
fn block_above_floor(gap: f64) -> Vec<Face> {
    let (low, high) = (DVec3::new(0.31, 0.37, gap), DVec3::new(0.61, 0.67, 0.5));
    let block = box_faces(low, high, false, Vec3::ZERO, GREY_REFLECTANCE);
    [vec![lamp(1.0), unit_floor()], block].concat()
}

/// Makes a lamp that lies under a body of this width.
fn lamp_under_body(side: f64) -> Vec<Face> {
    let below = square_face([0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], 1.0, 0.0);
    let above = square_face([0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0], 0.0, 0.5);
    let [low, high] = [0.5 - 0.5 * side, 0.5 + 0.5 * side];
    let (low, high) = (DVec3::new(low, low, 0.0), DVec3::new(high, high, 0.3));
    [vec![above, below], box_faces(low, high, false, Vec3::ZERO, Vec3::ZERO)].concat()
}

/// Makes two black shutters between a lamp and a floor, a chink or a window between them.
fn floor_behind_shutters(width: f64) -> Vec<Face> {
    let shutter = |x: f64| square_face([x, -4.0, 0.5], [0.0, 9.0, 0.0], [4.0, 0.0, 0.0], 0.0, 0.0);
    let [left, right] = [0.5 - 0.5 * width - 4.0, 0.5 + 0.5 * width].map(shutter);
    let (low, high) = (DVec3::new(-4.0, -4.0, -1.0), DVec3::new(5.0, 5.0, 2.0));
    let walls = box_faces(low, high, true, Vec3::ZERO, Vec3::ZERO);
    let backs = [left.clone().reversed(), right.clone().reversed()];
    [vec![lamp(1.0), unit_floor(), left, right], backs.into(), walls].concat()
}

/// Makes a lamp of this width.
fn strip_lamp(width: f64) -> Face {
    square_face([0.0, 0.5, 1.0], [0.0, width, 0.0], [1.0, 0.0, 0.0], 1.0, 0.0)
}

/// Light that patches send from inside a gap is missing there: the estimate gathers it again.
#[test]
fn narrow_gap_is_warned_by_the_estimate() {
    let solve = |gap: f64| solve_on_cpu(&named_scene("gap", block_above_floor(gap)), &solve_settings());
    let [narrow, wide] = [1e-3, 0.3].map(solve);
    let [error, other] = [&narrow, &wide].map(|answer| answer.estimate.as_ref().unwrap().error);
    assert!(error > 0.05 && other < 0.035, "{error} {other}");
    let warning = narrow.warnings.iter().find(|w| w.message.starts_with("may be"));
    assert!(warning.unwrap().faces.contains(&1), "the floor is named");
}

/// Code, words of its message, a scene, and the faces that it names there; none if it is not given.
type WarningCase = (&'static str, &'static str, Vec<Face>, Option<&'static [u32]>);

#[test]
fn warnings_are_given_where_they_apply_and_nowhere_else() {
    let covered = "every lamp lies under";
    let cases: [WarningCase; 11] = [
        ("overlap", "", plate_on_floor(0.0), Some(&[1, 2])),
        ("overlap", "", plate_on_floor(0.1), None),
        ("unlit", covered, lamp_under_body(0.999), Some(&[1])),
        ("unlit", covered, lamp_under_body(0.7), None),
        ("unlit", "", floor_behind_shutters(1e-6), Some(&[])),
        ("unlit", "", floor_behind_shutters(0.3), None),
        // No reflecting face is in front of these lamps.
        ("unlit", "", vec![lamp(1.0)], None),
        ("unlit", "", vec![lamp(1.0).reversed(), unit_floor()], None),
        ("precision", "", vec![unit_floor(), strip_lamp(1e-7)], Some(&[1])),
        ("precision", "", vec![unit_floor(), strip_lamp(1e-3)], None),
        // The same sliver beside a much brighter lamp.
        (
            "precision",
            "",
            vec![unit_floor(), strip_lamp(1e-7), strip_lamp(0.1)],
            None,
        ),
    ];
    for (k, (code, words, faces, expected)) in cases.into_iter().enumerate() {
        let answer = solve_on_cpu(&named_scene(code, faces), &solve_settings());
        let found = warned_faces(&answer, code, words);
        assert_eq!(found.as_deref(), expected, "{code}, case {k}");
    }
}

#[test]
fn scene_without_lamp_is_noted_and_has_no_estimate() {
    let answer = solve_on_cpu(&named_scene("dark", vec![unit_floor()]), &solve_settings());
    assert!(answer.estimate.is_none() && answer.warnings.is_empty());
    assert!(answer.notes[0].starts_with("no face emits light"), "{:?}", answer.notes);
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

/// A slit in the ceiling through which 0.02 % of the light escapes neither hides a loss nor looks like one.
#[test]
fn lost_light_raises_estimate_beside_a_slit() {
    let mut room = furnace(0.8);
    for corner in &mut room.faces[1].corners {
        corner.x = corner.x.min(0.999);
    }
    let mut solved = solve_to_error(&room, 0.01, 4).solved;
    assert!(solved.run.shots.iter().any(|shot| shot.escaped > 0.0));
    assert!(closure_error(&solved.mesh, &solved.run) < 0.003);
    // Every texel receives 4 % less; light is received five times for each time it is emitted.
    solved.run.field.irradiance.iter_mut().for_each(|h| *h *= 0.96);
    solved
        .run
        .shots
        .iter_mut()
        .for_each(|shot| shot.form_factor_sum *= 1.0 - 0.04 / 5.0);
    let found = closure_error(&solved.mesh, &solved.run);
    assert!((0.03..0.05).contains(&found), "{found}");
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
