//! Solutions: energy balance, superposition, monotonicity, and agreement of the two engines.

use super::scenes::any_scene;
use super::setups::{ITERATIONS, SolverSetup, check_every_engine, check_every_iteration, power_of, radiosity_distance};
use common::energy::EnergyBalance;
use common::mesh::Mesh;
use common::settings::Iteration;
use common::shooting::{RadiosityField, Shot};
use glam::Vec3;
use proptest::prelude::*;
use radiosity_tests::bounds::{U, energy_rounding};
use radiosity_tests::engines::{all_patches, shared_gpu};
use radiosity_tests::random_rooms::RandomRoom;

/// Returns a bound of the imbalance of a solve by passes: as many roundings of the shot power as patches in H, and as 64
/// lanes and a few products in the sums, on both sides of the balance.
fn passes_rounding(mesh: &Mesh, energy: &EnergyBalance, shots: &[Shot]) -> f64 {
    let shot: f64 = shots
        .iter()
        .map(|s| f64::from(Vec3::from(s.power).abs().element_sum() * s.form_factor_sum.max(1.0)))
        .sum();
    let emitted: f64 = energy.emitted.iter().sum();
    4.0 * (mesh.patches.len() + 64) as f64 * U * shot * mesh.area_unit() / emitted
}

/// Asserts B = E + ρH, each side rounded at each of `additions` and three times in each product.
fn assert_radiosity_equals_emission_plus_reflection(
    mesh: &Mesh,
    field: &RadiosityField,
    additions: usize,
) -> Result<(), TestCaseError> {
    for (k, texel) in mesh.texels.iter().enumerate() {
        let [b, h] = [&field.radiosity, &field.irradiance].map(|v| v[k].truncate().as_dvec3());
        let reflected = texel.reflectance.as_dvec3() * h;
        let difference = (b - texel.emission.as_dvec3() - reflected).abs();
        let bound = (b.abs() + reflected.abs()) * (2.0 * additions as f64 + 6.0) * U;
        prop_assert!(difference.cmple(bound).all(), "texel {k}: {difference} > {bound}");
    }
    Ok(())
}

#[test]
fn energy_of_a_solve_balances() {
    check_every_iteration(3, &any_scene(), |way, cut| {
        let mesh = cut.sampled_mesh(way.samples);
        let run = way.solve_mesh(&mesh);
        let energy = EnergyBalance::new(&mesh, &run.field, &run.shots);
        let single = way.iteration == Iteration::Southwell;
        let bound = if single {
            energy_rounding(&energy, mesh.area_unit(), &run.shots)
        } else {
            passes_rounding(&mesh, &energy, &run.shots)
        };
        prop_assert!(run.converged && !run.stagnated);
        prop_assert!(energy.imbalance <= bound, "{} > {bound}: {energy:?}", energy.imbalance);
        assert_radiosity_equals_emission_plus_reflection(&mesh, &run.field, if single { run.shots.len() } else { 1 })
    });
}

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

/// On a software adapter links by rays, and all that follows, are bit-identical. Hardware may fuse products and sums and
/// then select other shooters.
#[test]
fn both_engines_give_the_same_solution() {
    check_every_engine(2, &any_scene(), |way, cut| {
        if way.on_gpu {
            return Ok(());
        }
        let mesh = cut.sampled_mesh(way.samples);
        for iteration in ITERATIONS {
            let [cpu, device] = [false, true].map(|on_gpu| {
                let way = SolverSetup {
                    on_gpu,
                    iteration,
                    ..way
                };
                way.solve_mesh(&mesh)
            });
            if shared_gpu().line.software {
                prop_assert_eq!(&cpu.shots, &device.shots, "{:?}", iteration);
                prop_assert_eq!(&cpu.field.radiosity, &device.field.radiosity);
                prop_assert_eq!(&cpu.field.residual, &device.field.residual);
                for (a, b) in cpu.field.irradiance.iter().zip(&device.field.irradiance) {
                    prop_assert_eq!(a.truncate(), b.truncate());
                }
            } else {
                let bound = 10.0 * (power_of(&mesh, &cpu.field.residual) + power_of(&mesh, &device.field.residual));
                let found = radiosity_distance(&mesh, &cpu.field, &device.field, |k| k);
                prop_assert!(found <= bound, "{iteration:?}: {found:e} > {bound:e}");
            }
        }
        Ok(())
    });
}
