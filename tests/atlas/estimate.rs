//! The error estimate against the error itself, over many settings.

use common::form_factor::FormFactor;
use common::settings::{ItemBufferProjection, Visibility};
use oracle::solve::regather::ErrorCause;
use radiosity_tests::solutions::{
    dense_truth_on, error_against, room_with_standing_box, slit_room, solve_on_cpu, solve_settings,
};
use radiosity_tests::{furnace, lit_room};

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
