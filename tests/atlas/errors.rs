//! Errors of solutions: shooting and its estimate against the dense solver, and the dense solver against a path tracer.

use common::form_factor::FormFactor;
use common::import::{ImportOptions, load_scene};
use common::scene::Scene;
use common::settings::{ItemBufferProjection, Visibility};
use common::solution::StoredSolution;
use oracle::diff::pair::GridPair;
use oracle::diff::reflected::ReflectedField;
use oracle::solve::regather::ErrorCause;
use radiosity_tests::engines::{mesh_scene, settings_of, shoot_on_cpu};
use radiosity_tests::radiance_files::data_folder;
use radiosity_tests::solutions::{
    dense_truth_on, error_against, rms_and_bias, room_with_plates, room_with_standing_box, slit_room, solve_on_cpu,
    solve_settings,
};
use radiosity_tests::{furnace, lit_room};

/// Bound of the RMS error. 16 binary samples of a penumbra have an error of 16^(−3/4) = 12 %. A texel's light comes from
/// 64 patches of the lamp, a few of them partly visible, and from dozens of others: 12 %/√64, and a third more for
/// later reflections.
const RMS: f64 = 0.02;
/// Bound of the bias: samples are unbiased, and over thousands of texels their errors cancel to less than 0.3 %.
const BIAS: f64 = 0.003;

fn shadowed_scenes() -> Vec<Scene> {
    let slat = |k: i32| (0.6, [0.2 * f64::from(k), 0.2 * f64::from(k) + 0.1, 0.0, 1.0]);
    let near = [(0.3, [0.2, 0.8, 0.2, 0.8]), (0.31, [0.25, 0.75, 0.25, 0.75])];
    vec![
        lit_room(),
        room_with_standing_box(),
        room_with_plates("blinds", &[0, 1, 2, 3, 4].map(slat)),
        slit_room(),
        room_with_plates("plates", &near),
    ]
}

/// Every texel shoots in both, so that they differ only by the error of the samples.
#[test]
fn sampled_visibility_agrees_with_dense_solver() {
    for scene in shadowed_scenes() {
        let settings = settings_of([8, 8, 16], Visibility::Rays, 1e-4);
        let mesh = mesh_scene(&scene, &settings);
        let field = shoot_on_cpu(&mesh, &settings).field;
        let truth = dense_truth_on(&scene, 8);
        let (rms, bias) = rms_and_bias(&scene, (&mesh, &field), &truth);
        assert!(rms <= RMS, "{}: {rms}", scene.name);
        assert!(bias.abs() <= BIAS, "{}: {bias}", scene.name);
    }
}

/// Radiosity by a path tracer, area means per texel, is in the folder `truth/` of RADIOSITY_DATA.
#[test]
fn dense_cornell_box_agrees_with_path_tracer() {
    let Some(data) = data_folder() else { return };
    let folder = data.join("truth");
    let scene = load_scene(&folder.join("cornell.obj"), &ImportOptions::default()).unwrap();
    let (mesh, field) = dense_truth_on(&scene, 16);
    let traced = StoredSolution::read(&folder.join("cornell_16")).unwrap();
    let dense = ReflectedField::from_field(&scene, &mesh, &field);
    let (rms, bias) = GridPair::new(&dense, &ReflectedField::from(&traced), None)
        .unwrap()
        .worst_channel();
    println!("RMS {rms}, bias {bias}");
    assert!(rms <= 5e-3, "{rms}");
    assert!(bias.abs() <= 2e-3, "{bias}");
}

/// Errors from 15 % to 1 %. The estimate is within a factor of two, since a few texels make most of an error. Below half
/// a per cent the truth has errors of the same size.
#[test]
fn estimate_is_within_factor_two_of_error() {
    for scene in [lit_room(), room_with_standing_box(), slit_room(), furnace(0.5)] {
        let truth = dense_truth_on(&scene, 16);
        for (patches, samples, form_factor) in [
            (1, 1, FormFactor::Polygon),
            (4, 1, FormFactor::Disc),
            (4, 4, FormFactor::Polygon),
            (8, 4, FormFactor::Polygon),
        ] {
            let mut settings = solve_settings();
            settings.meshing.patches = patches;
            settings.meshing.samples = samples;
            settings.transport.form_factor = form_factor;
            let answer = solve_on_cpu(&scene, &settings);
            let (found, error) = (
                answer.estimate.as_ref().unwrap().error,
                error_against(&scene, &answer, &truth),
            );
            let what = format!(
                "{}, {patches} patches, {samples} samples, {form_factor:?}: {found:.4} estimated, {error:.4} true",
                scene.name
            );
            println!("{what}");
            assert!(found <= 2.0 * error + 0.005, "{what}");
            assert!(error <= 2.0 * found + 0.005, "{what}");
        }
    }
}

#[test]
fn largest_cause_of_error_is_warned() {
    let scene = slit_room();
    let mut printed = solve_settings();
    printed.meshing.patches = 8;
    printed.meshing.samples = 4;
    printed.transport.visibility = Visibility::with_item_buffer(ItemBufferProjection::Paper, 1024);
    let mut disc = solve_settings();
    disc.transport.form_factor = FormFactor::Disc;
    let mut whole = solve_settings();
    whole.meshing.patches = 1;
    for (settings, cause, code) in [
        (printed, ErrorCause::Visibility, "visibility"),
        (disc, ErrorCause::FormFactor, "closure"),
        (whole, ErrorCause::Patches, "cells"),
    ] {
        let answer = solve_on_cpu(&scene, &settings);
        let estimate = answer.estimate.unwrap();
        let worst = estimate.parts.iter().max_by(|a, b| a.error.total_cmp(&b.error));
        assert_eq!(worst.unwrap().cause, cause, "{estimate:?}");
        assert_eq!(answer.warnings[0].code.as_str(), code, "{:?}", answer.warnings);
        assert!(!answer.warnings[0].faces.is_empty());
        assert_eq!(answer.solved.settings, settings, "given options are kept");
    }
}
