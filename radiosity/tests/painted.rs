//! Painted faces: texels larger than the solved ones, and agreement with the path tracer.

use super::path_tracer::assert_dense_solver_agrees;
use common::scene::Face;
use common::settings::Settings;
use glam::{DVec3, Vec3};
use oracle::solve::progress::without_progress;
use oracle::solve::solver::{ErrorTarget, SolverChoice};
use oracle::solve::{SolveRequest, solve_request};
use radiosity::studies::stress::cases::shapes::box_faces;
use radiosity_tests::named_scene;
use radiosity_tests::painted::{paint_face, picture_coat};
use radiosity_tests::solutions::dense_truth_on;
use std::f32::consts::PI;

/// A lamp above the white half of a floor: the mean of ρH is far more than the mean of ρ times the mean of H.
#[test]
fn painted_texel_has_mean_of_reflectance_times_irradiance() {
    let p = |x: f64, z: f64| DVec3::new(x, 0.0, z);
    let floor = |from: f64, to: f64| [p(from, 0.), p(from, 1.), p(to, 1.), p(to, 0.)];
    let above = DVec3::Y * 0.3;
    let lamp = [p(0.1, 0.3), p(0.4, 0.3), p(0.4, 0.7), p(0.1, 0.7)].map(|p| p + above);
    let lamp = Face::quad("lamp", lamp, Vec3::splat(PI), Vec3::ZERO);
    let white = Vec3::new(0.8, 0.5, 0.2);
    // Corner 0 to 1 is along z, so that the two pixels are one above the other.
    let halves = picture_coat([1, 2], &[white, Vec3::ZERO]);
    let whole = paint_face(
        Face::quad("floor", floor(0., 1.), Vec3::ZERO, Vec3::ZERO),
        [Some(halves), None],
    );
    let parts = [(0., 0.5, white), (0.5, 1., Vec3::ZERO)];
    let parts = parts.map(|(from, to, rho)| Face::quad("half", floor(from, to), Vec3::ZERO, rho));
    let parts = named_scene("halves", [parts.to_vec(), vec![lamp.clone()]].concat());
    let (mesh, field) = dense_truth_on(&parts, 16);
    let texels = mesh
        .texels
        .iter()
        .zip(&field.radiosity)
        .filter(|(texel, _)| texel.face < 2);
    let expected: DVec3 = texels
        .map(|(texel, b)| b.truncate().as_dvec3() * f64::from(texel.area))
        .sum();
    // The floor's area is not 1 in the mesh's unit.
    let area: f64 = mesh
        .texels
        .iter()
        .filter(|t| t.face < 2)
        .map(|t| f64::from(t.area))
        .sum();
    let expected = expected / area;

    let whole = named_scene("painted", vec![whole, lamp]);
    let error = 0.005;
    let question = SolveRequest {
        task: &whole,
        settings: &Settings::default(),
        solver: SolverChoice::Hierarchy(ErrorTarget { error, texels: Some(1) }),
    };
    let answered = solve_request(&question, &without_progress()).unwrap();
    let (texel, field) = (&answered.solved.mesh.texels[0], &answered.solved.run.field);
    let found = field.radiosity[0].truncate().as_dvec3();
    let off = ((found - expected) / expected).abs().max_element();
    // Twice the requested error: the dense solution on texels of a sixteenth has as much.
    assert!(off < 2.0 * error, "{found} {expected}");
    let product = (texel.reflectance * field.irradiance[0].truncate()).as_dvec3();
    assert!((product - found).abs().max_element() < 1e-6, "{product} {found}");
    assert!((texel.reflectance - white / 2.0).length() < 1e-6);
}

/// A room with a chequered floor and a ceiling that emits in stripes. The texels are as wide as the checks, and half of
/// that.
#[test]
fn path_tracer_and_dense_solver_agree_on_painted_faces() {
    let side = 4;
    let check = |k: usize| [Vec3::new(0.8, 0.5, 0.1), Vec3::new(0.1, 0.2, 0.7)][(k + k / side) % 2];
    let stripe = |k: usize| Vec3::new(3.0, 2.0, 1.0) * [0.0, 1.0, 0.2, 0.0][k % side];
    let [checks, stripes] = [
        (0..side * side).map(check).collect::<Vec<_>>(),
        (0..side * side).map(stripe).collect(),
    ];
    let mut faces = box_faces([0.0; 3], [1.0, 1.0, 0.5], true, 0.5);
    faces[0] = paint_face(faces[0].clone(), [Some(picture_coat([side; 2], &checks)), None]);
    faces[1] = paint_face(faces[1].clone(), [None, Some(picture_coat([side; 2], &stripes))]);
    assert_dense_solver_agrees(&named_scene("paint", faces), 4, 60_000, 0.02);
}
