//! Error attribution: a planted error is found again under its cause.

use common::mesh::Mesh;
use common::scene::Scene;
use cpu::hierarchy::error_attribution::{ErrorAttribution, attribute_error};
use cpu::hierarchy::solver::{ErrorBudget, HierarchicalSolution, solve_scene};
use glam::{DVec3, Vec3};
use radiosity_tests::lit_room;
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
    for part in [none.receivers, none.propagation, none.sources, none.visibility] {
        assert!(rms(part) < 0.2 * f64::from(PLANTED), "{none:?}");
    }
    let off = |k: usize| {
        if k.is_multiple_of(2) { PLANTED } else { -PLANTED }
    };
    let single = attribute_remaining_error(&scene, &mesh, &planted(&off));
    let found = rms(single.receivers) / f64::from(PLANTED);
    assert!((0.8..1.2).contains(&found), "{found}");
    assert!(rms(single.propagation) < 0.2 * f64::from(PLANTED));
    // A uniform error changes the radiosity of the sources too: it would be found wholly only in direct light.
    let all = attribute_remaining_error(&scene, &mesh, &planted(&|_| PLANTED));
    let found = rms(all.propagation) / f64::from(PLANTED);
    assert!((0.4..1.0).contains(&found), "{found}");
    assert!(rms(all.receivers) < 0.5 * rms(all.propagation));
}
