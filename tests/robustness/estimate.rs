//! The estimate of an answer's error against the error itself; what is warned about, and mended.

use common::form_factor::FormFactor;
use common::mesh::Mesh;
use common::scene::{Face, Scene};
use common::settings::{Raster, Settings, Visibility};
use common::shooting::Field;
use glam::{DVec3, Vec3};
use oracle::judge::diff::pair::Pair;
use oracle::judge::diff::reflected::Reflected;
use oracle::solve::check::{Cause, Estimate, estimate};
use oracle::solve::dense;
use oracle::solve::{Answer, Given};
use radiosity_tests::answers::{settings, solved};
use radiosity_tests::matrices::assemble;
use radiosity_tests::{furnace, lit_room, room, scene};

const GREY: Vec3 = Vec3::splat(0.7);

/// A lit room, cut in two by a wall with a slit.
fn slit() -> Scene {
    let mut all = room(DVec3::ZERO, DVec3::ONE, true, Vec3::ZERO, GREY);
    all[1].emission = Vec3::splat(3.0);
    for [x0, x1] in [[0.0, 0.45], [0.55, 1.0]] {
        let p = |x, z| DVec3::new(x, 0.5, z);
        let corners = [p(x0, 0.0), p(x0, 1.0), p(x1, 1.0), p(x1, 0.0)];
        let up = Face::quad("wall", corners, Vec3::ZERO, GREY);
        all.push(up.reversed());
        all.push(up);
    }
    scene("a slit", all)
}

/// The lit room with its box on the floor.
fn standing() -> Scene {
    let mut scene = lit_room();
    scene.name = "a box on the floor".into();
    for face in &mut scene.faces[6..] {
        for corner in &mut face.corners {
            corner.y -= 0.25;
        }
    }
    scene
}

/// Relative RMS against a matrix of twice the texels.
fn error(scene: &Scene, answer: &Answer, truth: &(Mesh, Field)) -> f64 {
    let ours = Reflected::of(scene, &answer.solved.mesh, &answer.solved.run.field);
    let theirs = Reflected::of(scene, &truth.0, &truth.1);
    Pair::new(&ours, &theirs, None).unwrap().worst().0
}

fn truth(scene: &Scene) -> (Mesh, Field) {
    let (mesh, matrix, _) = assemble(scene, 16);
    let field = dense::by(&mesh, &matrix).unwrap().0.field;
    (mesh, field)
}

fn looked_at(scene: &Scene, settings: &Settings, answer: &Answer, field: &Field) -> Estimate {
    estimate(scene, settings, &answer.solved.mesh, field).unwrap()
}

/// From 15 % to 1 %. The estimate is held to a factor of two: a few texels make most of an error.
/// Errors below half a per cent are the matrix's as well.
#[test]
fn the_estimate_is_the_error_within_a_factor_of_two() {
    for scene in [lit_room(), standing(), slit(), furnace(0.5)] {
        let truth = truth(&scene);
        for (cells, samples, form_factor) in [
            (1, 1, FormFactor::Polygon),
            (4, 1, FormFactor::Disc),
            (4, 4, FormFactor::Polygon),
            (8, 4, FormFactor::Polygon),
        ] {
            let settings = Settings {
                cells,
                samples,
                form_factor,
                ..settings()
            };
            let answer = solved(&scene, &settings, Given::ALL);
            let (found, error) = (
                answer.estimate.as_ref().unwrap().error,
                error(&scene, &answer, &truth),
            );
            let what = format!(
                "{}, {cells} cells, {samples} samples, {form_factor:?}: {found:.4} estimated, {error:.4} true",
                scene.name
            );
            println!("{what}");
            assert!(found <= 2.0 * error + 0.005, "{what}");
            assert!(error <= 2.0 * found + 0.005, "{what}");
        }
    }
}

/// Whatever a solver gets wrong shows, not only what its settings explain.
#[test]
fn light_that_is_lost_or_made_up_is_found() {
    let scene = lit_room();
    let answer = solved(&scene, &settings(), Given::ALL);
    let clean = looked_at(&scene, &settings(), &answer, &answer.solved.run.field).error;
    for factor in [0.8, 1.2] {
        let mut field = answer.solved.run.field.clone();
        for h in &mut field.irradiance {
            *h *= factor;
        }
        let found = looked_at(&scene, &settings(), &answer, &field).error;
        assert!(found > clean + 0.15, "×{factor}: {found}, clean {clean}");
    }
}

/// All of a furnace five per cent too bright: of that one bounce shows a tenth at ρ = 0.9, the rest
/// comes of later ones.
#[test]
fn later_bounces_count_with_their_gain() {
    for reflectance in [0.5, 0.9, 0.99] {
        let scene = furnace(reflectance);
        let answer = solved(&scene, &settings(), Given::ALL);
        let mut field = answer.solved.run.field.clone();
        let exact = 1.0 / (1.0 - reflectance);
        for (k, texel) in answer.solved.mesh.texels.iter().enumerate() {
            let reflected = 1.05 * Vec3::splat(reflectance * exact);
            field.irradiance[k] = (reflected / reflectance).extend(0.0);
            field.radiosity[k] = (texel.emission + reflected).extend(0.0);
        }
        let found = looked_at(&scene, &settings(), &answer, &field);
        println!("ρ = {reflectance}: {found:?}");
        // What is near by, a tenth of all that is met, is asked point by point and counts among the
        // later bounces as well: of one bounce's error, at most half of all, a tenth. The look's noise is of what is emitted: a quarter of a million samples twice, each
        // within a quarter of its mean, tell it to 3e-4; rounding of f32 grows as the light does.
        let spread = 0.5 * 0.1 * 0.05;
        let rounding = 4.0 * f64::from(f32::EPSILON * exact);
        let off = (found.error - 0.05).abs();
        assert!(off < spread + 5e-4 + rounding, "{found:?}");
    }
}

/// What a solve leaves at ρ = 0.999999 is in doubt by as much as light grows there.
#[test]
fn white_walls_are_not_trusted() {
    let reflectance = 0.999_999f32;
    let answer = solved(&furnace(reflectance), &settings(), Given::ALL);
    let exact = 1.0 / (1.0 - f64::from(reflectance));
    let b: f64 = answer
        .solved
        .run
        .field
        .radiosity
        .iter()
        .map(|b| f64::from(b.x))
        .sum();
    let error = (b / answer.solved.run.field.radiosity.len() as f64 / exact - 1.0).abs();
    let found = answer.estimate.as_ref().unwrap();
    println!("{error:.3} off, {found:?}");
    assert!(found.error >= 0.5 * error, "{error}: {found:?}");
    assert!(error < 0.02 || !answer.warnings.is_empty());
}

#[test]
fn each_cause_is_told() {
    let scene = slit();
    let printed = Settings {
        visibility: Visibility::Paper,
        raster: Raster::Tessellated,
        cells: 8,
        samples: 4,
        ..settings()
    };
    let disc = Settings {
        form_factor: FormFactor::Disc,
        ..settings()
    };
    let whole = Settings {
        cells: 1,
        ..settings()
    };
    for (settings, cause, code) in [
        (printed, Cause::Visibility, "visibility"),
        (disc, Cause::FormFactor, "form-factor"),
        (whole, Cause::Cells, "cells"),
    ] {
        let answer = solved(&scene, &settings, Given::ALL);
        let estimate = answer.estimate.unwrap();
        let worst = estimate
            .parts
            .iter()
            .max_by(|a, b| a.error.total_cmp(&b.error));
        assert_eq!(worst.unwrap().cause, cause, "{estimate:?}");
        assert_eq!(
            answer.warnings[0].code.text(),
            code,
            "{:?}",
            answer.warnings
        );
        assert!(!answer.warnings[0].faces.is_empty());
        assert_eq!(answer.solved.settings, settings, "given options are kept");
    }
}

#[test]
fn what_was_not_given_is_mended_and_said() {
    let scene = lit_room();
    let before = solved(&scene, &settings(), Given::ALL);
    let after = solved(&scene, &settings(), Given::default());
    let truth = truth(&scene);
    assert!(before.notes.is_empty());
    assert!(
        after.notes[0].starts_with("mended: about "),
        "{:?}",
        after.notes
    );
    assert_eq!(
        (after.solved.settings.cells, after.solved.settings.samples),
        (8, 16)
    );
    assert!(2.0 * error(&scene, &after, &truth) < error(&scene, &before, &truth));
    let buffer = Settings {
        visibility: Visibility::Stereographic,
        item_buffer: 16,
        ..settings()
    };
    let by_rays = solved(&slit(), &buffer, Given::default());
    assert_eq!(by_rays.solved.settings.visibility, Visibility::Rays);
    assert!(by_rays.warnings.is_empty(), "{:?}", by_rays.warnings);
}
