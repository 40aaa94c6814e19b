//! The error estimate against the error itself.

use common::scene::Scene;
use common::settings::Settings;
use common::shooting::RadiosityField;
use glam::Vec3;
use oracle::solve::SolveAnswer;
use oracle::solve::regather::{ErrorEstimate, estimate_by_regathering};
use radiosity_tests::solutions::{solve_on_cpu, solve_settings};
use radiosity_tests::{furnace, lit_room};

fn estimate_error(scene: &Scene, settings: &Settings, answer: &SolveAnswer, field: &RadiosityField) -> ErrorEstimate {
    estimate_by_regathering(scene, settings, &answer.solved.mesh, field).unwrap()
}

/// The estimate includes errors that no setting explains.
#[test]
fn scaled_irradiance_raises_estimate() {
    let scene = lit_room();
    let answer = solve_on_cpu(&scene, &solve_settings());
    let clean = estimate_error(&scene, &solve_settings(), &answer, &answer.solved.run.field).error;
    for factor in [0.8, 1.2] {
        let mut field = answer.solved.run.field.clone();
        for h in &mut field.irradiance {
            *h *= factor;
        }
        let found = estimate_error(&scene, &solve_settings(), &answer, &field).error;
        assert!(found > clean + 0.15, "×{factor}: {found}, clean {clean}");
    }
}

/// A furnace five per cent too bright: at ρ = 0.9 one bounce shows a tenth of that, later bounces the rest.
#[test]
fn uniform_error_is_estimated_with_later_bounces() {
    for reflectance in [0.5, 0.9, 0.99] {
        let scene = furnace(reflectance);
        let answer = solve_on_cpu(&scene, &solve_settings());
        let mut field = answer.solved.run.field.clone();
        let exact = 1.0 / (1.0 - reflectance);
        for (k, texel) in answer.solved.mesh.texels.iter().enumerate() {
            let reflected = 1.05 * Vec3::splat(reflectance * exact);
            field.irradiance[k] = (reflected / reflectance).extend(0.0);
            field.radiosity[k] = (texel.emission + reflected).extend(0.0);
        }
        let found = estimate_error(&scene, &solve_settings(), &answer, &field);
        // Near patches, a tenth of those hit, are sampled point by point and count among the later bounces as well: a
        // tenth of one bounce's error, which is at most half of all. The noise of the estimate is relative to the
        // emitted light: two times a quarter of a million samples, each within a quarter of its mean, have an error of
        // 3e-4. Rounding of f32 grows with the light.
        let spread = 0.5 * 0.1 * 0.05;
        let rounding = 4.0 * f64::from(f32::EPSILON * exact);
        let off = (found.error - 0.05).abs();
        assert!(off < spread + 5e-4 + rounding, "{found:?}");
    }
}
