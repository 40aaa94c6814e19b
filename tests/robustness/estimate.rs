//! The estimate of an answer's error against the error itself.

use common::scene::Scene;
use common::settings::Settings;
use common::shooting::Field;
use glam::Vec3;
use oracle::solve::Answer;
use oracle::solve::check::{Estimate, estimate};
use radiosity_tests::answers::{settings, solved};
use radiosity_tests::{furnace, lit_room};

fn looked_at(scene: &Scene, settings: &Settings, answer: &Answer, field: &Field) -> Estimate {
    estimate(scene, settings, &answer.solved.mesh, field).unwrap()
}

/// Whatever a solver gets wrong shows, not only what its settings explain.
#[test]
fn light_that_is_lost_or_made_up_is_found() {
    let scene = lit_room();
    let answer = solved(&scene, &settings());
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
        let answer = solved(&scene, &settings());
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
    let answer = solved(&furnace(reflectance), &settings());
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
