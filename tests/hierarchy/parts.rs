//! What is left of an error, by what it is due to: what is planted is found again.

use common::mesh::Mesh;
use common::scene::{Face, Scene};
use common::shooting::Field;
use cpu::hierarchy::again::{Left, again};
use cpu::hierarchy::solve::{Goal, Outcome, solve};
use glam::{DVec3, Vec3};
use radiosity_tests::answers::{error, truth_on};
use radiosity_tests::lit_room;
use std::ops::ControlFlow;

const PLANTED: f32 = 0.05;

fn solved(scene: &Scene) -> (Mesh, Outcome) {
    let mesh = Mesh::uniform(scene, 8, 1).unwrap();
    let mut told = |_: f64| ControlFlow::Continue(());
    let outcome = solve(scene, &mesh, &[], Goal::of(0.005), &mut told).unwrap();
    (mesh, outcome)
}

/// What is left of `irradiance`, of its RMS.
fn left(scene: &Scene, mesh: &Mesh, irradiance: &[Vec3]) -> Left {
    let even: Vec<f32> = mesh.texels.iter().map(|texel| texel.area).collect();
    let mut told = |_: f64| ControlFlow::Continue(());
    again(scene, mesh, irradiance, &even, Goal::of(0.005), &mut told).unwrap()
}

#[test]
fn what_single_texels_are_off_is_the_receivers_and_what_all_are_is_sent_on() {
    let scene = lit_room();
    let (mesh, outcome) = solved(&scene);
    let planted = |by: &dyn Fn(usize) -> f32| -> Vec<Vec3> {
        let values = outcome.irradiance.iter().enumerate();
        values.map(|(k, h)| *h * (1.0 + by(k))).collect()
    };
    let rms = |square: DVec3| square.max_element().sqrt();
    let none = left(&scene, &mesh, &planted(&|_| 0.0));
    println!("{none:?}");
    for part in [
        none.receivers,
        none.propagation,
        none.sources,
        none.visibility,
    ] {
        assert!(rms(part) < 0.2 * f64::from(PLANTED), "{none:?}");
    }
    let off = |k: usize| {
        if k.is_multiple_of(2) {
            PLANTED
        } else {
            -PLANTED
        }
    };
    let single = left(&scene, &mesh, &planted(&off));
    println!("{single:?}");
    let found = rms(single.receivers) / f64::from(PLANTED);
    assert!((0.8..1.2).contains(&found), "{found}");
    assert!(rms(single.propagation) < 0.2 * f64::from(PLANTED));
    // What is too bright everywhere is so by what it sends too: of direct light alone all is found.
    let all = left(&scene, &mesh, &planted(&|_| PLANTED));
    println!("{all:?}");
    let found = rms(all.propagation) / f64::from(PLANTED);
    assert!((0.4..1.0).contains(&found), "{found}");
    assert!(rms(all.receivers) < 0.5 * rms(all.propagation));
}

/// A plate close above a larger one, and a lamp above that.
fn gap() -> Scene {
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
fn light_fades_into_a_narrow_gap() {
    let scene = gap();
    let truth = truth_on(&scene, 40);
    let answer = super::asked::solved(&scene, 0.01, 8);
    let (off, estimate) = (error(&scene, &answer, &truth), answer.estimate.unwrap());
    println!("{off} off, {estimate:?}");
    assert!(off <= 0.01, "{off}");
    // The upper plate has little light, and nobody else tells how much.
    let dim = |mesh: &Mesh, field: &Field| -> f32 {
        let texels = mesh.texels.iter().zip(&field.irradiance);
        let own = texels.filter(|(texel, _)| texel.face == 1);
        own.map(|(texel, h)| texel.area * h.x).sum()
    };
    let ours = dim(&answer.solved.mesh, &answer.solved.run.field);
    let ratio = ours / dim(&truth.0, &truth.1);
    println!("the upper plate has {ratio} of its light");
    assert!((0.93..1.07).contains(&ratio), "{ratio}");
}
