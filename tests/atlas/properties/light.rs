//! Solutions of replayed shots: superposition and monotonicity.

use super::scenes::any_scene;
use super::setups::check_every_engine;
use common::shooting::RadiosityField;
use glam::Vec3;
use proptest::prelude::*;
use radiosity_tests::bounds::U;
use radiosity_tests::engines::all_patches;
use radiosity_tests::random_rooms::RandomRoom;

/// Returns the scene with other emission.
fn with_emission(cut: &RandomRoom, light: impl Fn(usize) -> Vec3) -> RandomRoom {
    let mut cut = cut.clone();
    for (k, face) in cut.scene.faces.iter_mut().enumerate() {
        face.emission = light(k);
    }
    cut
}

/// Returns the scene with its emission, with that of the next face, and with the sum of the two.
fn two_lights_and_their_sum(cut: &RandomRoom) -> [RandomRoom; 3] {
    let faces = &cut.scene.faces;
    let first = |k: usize| faces[k].emission;
    let second = |k: usize| faces[(k + 1) % faces.len()].emission * 0.75;
    [
        with_emission(cut, first),
        with_emission(cut, second),
        with_emission(cut, |k| first(k) + second(k)),
    ]
}

fn add_radiosities(a: &RadiosityField, b: &RadiosityField) -> RadiosityField {
    let mut sum = a.clone();
    for (value, other) in sum.radiosity.iter_mut().zip(&b.radiosity) {
        *value += *other;
    }
    sum
}

/// The same shots are sums of positive numbers. Each rounds what it adds 14 times (a flux of up to 64 texels 8, three
/// products, two quotients, the addition), and light may pass through all of the shots.
#[test]
fn replayed_shots_superpose() {
    check_every_engine(4, &any_scene(), |way, cut| {
        let [first, second, both] = two_lights_and_their_sum(&cut).map(|cut| cut.sampled_mesh(way.samples));
        let log: Vec<u32> = all_patches(&both).into_iter().chain(all_patches(&both)).collect();
        let [first, second, together] = [&first, &second, &both].map(|mesh| way.replay_log(mesh, &log).field);
        let bound = 2.0 * (14 * log.len() + 2) as f64 * U;
        let sum = add_radiosities(&first, &second);
        for (k, (a, b)) in together.radiosity.iter().zip(&sum.radiosity).enumerate() {
            let (a, b) = (a.truncate().as_dvec3(), b.truncate().as_dvec3());
            prop_assert!((a - b).abs().cmple(bound * a).all(), "texel {k}: {a} is not {b}");
        }
        Ok(())
    });
}

/// Returns the scene with more emission of one face and more reflectance of another.
fn brighten_scene(cut: &RandomRoom, at: usize) -> RandomRoom {
    let mut cut = cut.clone();
    let n = cut.scene.faces.len();
    let most = cut
        .scene
        .faces
        .iter()
        .fold(Vec3::ZERO, |most, face| most.max(face.emission));
    cut.scene.faces[at % n].emission += most * 0.5 + Vec3::splat(0.25);
    let reflectance = &mut cut.scene.faces[(at / 7) % n].reflectance;
    *reflectance += (Vec3::splat(0.85) - *reflectance) * 0.5;
    cut
}

/// Sums, products and quotients by the same numbers are monotone when rounded, too: no texel may be darker by one bit.
#[test]
fn replayed_shots_of_brighter_scene_darken_nothing() {
    check_every_engine(4, &(any_scene(), any::<usize>()), |way, (cut, at)| {
        let [less, more] = [cut.clone(), brighten_scene(&cut, at)].map(|cut| cut.sampled_mesh(way.samples));
        let log: Vec<u32> = all_patches(&less).into_iter().chain(all_patches(&less)).collect();
        let [less, more] = [&less, &more].map(|mesh| way.replay_log(mesh, &log).field);
        for k in 0..less.radiosity.len() {
            prop_assert!(more.radiosity[k].cmpge(less.radiosity[k]).all(), "B of texel {k}");
            prop_assert!(more.irradiance[k].cmpge(less.irradiance[k]).all(), "H of texel {k}");
        }
        Ok(())
    });
}
