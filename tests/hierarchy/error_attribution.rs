//! Error attribution: a planted error is found again under its cause.

use common::mesh::Mesh;
use common::scene::{Face, Scene};
use common::shooting::RadiosityField;
use cpu::hierarchy::error_attribution::{ErrorAttribution, attribute_error};
use cpu::hierarchy::solver::{ErrorBudget, HierarchicalSolution, solve_scene};
use glam::{DVec3, Vec3};
use radiosity_tests::lit_room;
use radiosity_tests::solutions::{dense_truth_on, error_against};
use std::ops::ControlFlow;

const PLANTED: f32 = 0.05;

fn solve_room(scene: &Scene) -> (Mesh, HierarchicalSolution) {
    let mesh = Mesh::uniform(scene, 8, 1).unwrap();
    let mut go_on = |_: f64| ControlFlow::Continue(());
    let outcome = solve_scene(scene, &mesh, &[], ErrorBudget::for_error(0.005), &mut go_on).unwrap();
    (mesh, outcome)
}

/// Attributes the error of `irradiance`, relative to its RMS.
fn attribute_remaining_error(scene: &Scene, mesh: &Mesh, irradiance: &[Vec3]) -> ErrorAttribution {
    let even: Vec<f32> = mesh.texels.iter().map(|texel| texel.area).collect();
    let mut go_on = |_: f64| ControlFlow::Continue(());
    attribute_error(
        scene,
        mesh,
        irradiance,
        &even,
        ErrorBudget::for_error(0.005),
        &mut go_on,
    )
    .unwrap()
}

#[test]
fn single_texel_error_is_receivers_and_uniform_error_is_propagation() {
    let scene = lit_room();
    let (mesh, outcome) = solve_room(&scene);
    let planted = |by: &dyn Fn(usize) -> f32| -> Vec<Vec3> {
        let values = outcome.irradiance.iter().enumerate();
        values.map(|(k, h)| *h * (1.0 + by(k))).collect()
    };
    let rms = |square: DVec3| square.max_element().sqrt();
    let none = attribute_remaining_error(&scene, &mesh, &planted(&|_| 0.0));
    println!("{none:?}");
    for part in [none.receivers, none.propagation, none.sources, none.visibility] {
        assert!(rms(part) < 0.2 * f64::from(PLANTED), "{none:?}");
    }
    let off = |k: usize| {
        if k.is_multiple_of(2) { PLANTED } else { -PLANTED }
    };
    let single = attribute_remaining_error(&scene, &mesh, &planted(&off));
    println!("{single:?}");
    let found = rms(single.receivers) / f64::from(PLANTED);
    assert!((0.8..1.2).contains(&found), "{found}");
    assert!(rms(single.propagation) < 0.2 * f64::from(PLANTED));
    // A uniform error changes the radiosity of the sources too: it would be found wholly only in direct light.
    let all = attribute_remaining_error(&scene, &mesh, &planted(&|_| PLANTED));
    println!("{all:?}");
    let found = rms(all.propagation) / f64::from(PLANTED);
    assert!((0.4..1.0).contains(&found), "{found}");
    assert!(rms(all.receivers) < 0.5 * rms(all.propagation));
}

/// A plate close above a larger one, and a lamp above that.
fn plates_with_gap() -> Scene {
    let white = Vec3::splat(0.85);
    let at = |y: f64, low: f64, high: f64| {
        let p = |x, z| DVec3::new(x, y, z);
        [p(low, low), p(low, high), p(high, high), p(high, low)]
    };
    let below = Face::quad("below", at(0.0, 0.0, 1.0), Vec3::ZERO, white);
    let above = Face::quad("above", at(0.05, 0.3, 0.9), Vec3::ZERO, white).reversed();
    let lamp = Face::quad("lamp", at(1.0, 0.0, 1.0), Vec3::ONE, Vec3::ZERO).reversed();
    Scene {
        name: "a narrow gap".into(),
        faces: vec![below, above, lamp],
        ..lit_room()
    }
}

#[test]
fn light_in_narrow_gap_matches_dense_solution() {
    let scene = plates_with_gap();
    let truth = dense_truth_on(&scene, 40);
    let answer = super::error_budget::solve_to_error(&scene, 0.01, 8);
    let (off, estimate) = (error_against(&scene, &answer, &truth), answer.estimate.unwrap());
    println!("{off} off, {estimate:?}");
    assert!(off <= 0.01, "{off}");
    // The upper plate has little light, which hardly contributes to the total error.
    let dim = |mesh: &Mesh, field: &RadiosityField| -> f32 {
        let texels = mesh.texels.iter().zip(&field.irradiance);
        let own = texels.filter(|(texel, _)| texel.face == 1);
        own.map(|(texel, h)| texel.area * h.x).sum()
    };
    let ours = dim(&answer.solved.mesh, &answer.solved.run.field);
    let ratio = ours / dim(&truth.0, &truth.1);
    println!("the upper plate has {ratio} of its light");
    assert!((0.93..1.07).contains(&ratio), "{ratio}");
}
