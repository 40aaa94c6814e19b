//! The error estimate against the error itself.

use approx::abs_diff_eq;
use common::mesh::Mesh;
use common::scene::Scene;
use common::settings::Settings;
use common::shooting::{RadiosityField, SolveRun};
use glam::{Vec3, Vec4};
use oracle::solve::SolveAnswer;
use oracle::solve::error_estimate::unshot_error;
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

/// The light r that a furnace has not shot would add ρr/(1 − ρ) to B; a channel without light has no error.
#[test]
fn unshot_light_of_a_furnace_is_its_error() {
    let mesh = Mesh::uniform(&furnace(0.25), 2, 1).unwrap();
    let (reflected, residual) = (Vec3::new(0.5, 0.25, 0.0), Vec3::new(0.3, -0.3, 0.3));
    let everywhere = |of: &dyn Fn(Vec3) -> Vec3| -> Vec<Vec4> {
        let values = mesh.texels.iter().map(|texel| of(texel.emission).extend(0.0));
        values.collect()
    };
    let run = SolveRun {
        field: RadiosityField {
            radiosity: everywhere(&|emission| emission + reflected),
            residual: everywhere(&|_| residual),
            ..RadiosityField::default()
        },
        ..SolveRun::default()
    };
    let expected = 0.25 * 0.3 / (1.0 - 0.25) / 0.25;
    let found = unshot_error(&mesh, &run);
    // B is rounded beside E = 1, the other numbers by themselves.
    let rounding = 16.0 * f64::from(f32::EPSILON);
    assert!(
        abs_diff_eq!(found, expected, epsilon = rounding),
        "{found} is not {expected}"
    );
}
