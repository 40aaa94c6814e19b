//! Light: its balance, superposition, monotony, and one answer of two solvers.

use super::kit::{ITERATIONS, Way, all, apart, every_engine, every_way, gain, left, unshot};
use super::scenes::{Cut, any_scene};
use common::energy::Energy;
use common::mesh::Mesh;
use common::settings::Iteration;
use common::shooting::{Field, Run, Shot, select};
use glam::Vec3;
use proptest::prelude::*;
use radiosity_tests::bounds::{U, energy_rounding};
use radiosity_tests::engines::shared_gpu;

/// What rounding leaves of the balance of a solve by passes: as many roundings as cells in H, and as
/// 64 lanes and a few products in the sums, of all that was shot, up and down the balance.
fn passes_rounding(mesh: &Mesh, energy: &Energy, shots: &[Shot]) -> f64 {
    let shot: f64 = shots
        .iter()
        .map(|s| f64::from(Vec3::from(s.power).abs().element_sum() * s.form_factor_sum.max(1.0)))
        .sum();
    let emitted: f64 = energy.emitted.iter().sum();
    4.0 * (mesh.cells.len() + 64) as f64 * U * shot * mesh.area_unit() / emitted
}

/// B = E + ρH, each side rounded at each of `additions`, and thrice in each product.
fn settled(mesh: &Mesh, field: &Field, additions: usize) -> Result<(), TestCaseError> {
    for (k, texel) in mesh.texels.iter().enumerate() {
        let [b, h] = [&field.radiosity, &field.irradiance].map(|v| v[k].truncate().as_dvec3());
        let reflected = texel.reflectance.as_dvec3() * h;
        let difference = (b - texel.emission.as_dvec3() - reflected).abs();
        let bound = (b.abs() + reflected.abs()) * (2.0 * additions as f64 + 6.0) * U;
        prop_assert!(
            difference.cmple(bound).all(),
            "texel {k}: {difference} > {bound}"
        );
    }
    Ok(())
}

#[test]
fn what_is_emitted_is_absorbed_unshot_escaped_or_lost() {
    every_way(3, &any_scene(), |way, cut| {
        let mesh = cut.mesh(way.samples);
        let run = way.solve(&mesh);
        let energy = Energy::new(&mesh, &run.field, &run.shots);
        let single = way.iteration == Iteration::Southwell;
        let bound = if single {
            energy_rounding(&energy, mesh.area_unit(), &run.shots)
        } else {
            passes_rounding(&mesh, &energy, &run.shots)
        };
        prop_assert!(run.converged && !run.stagnated);
        prop_assert!(
            energy.imbalance <= bound,
            "{} > {bound}: {energy:?}",
            energy.imbalance
        );
        settled(&mesh, &run.field, if single { run.shots.len() } else { 1 })
    });
}

#[test]
fn every_shot_balances() {
    every_engine(3, &any_scene(), |way, cut| {
        let mesh = cut.mesh(way.samples);
        let mut engine = way.engine(&mesh);
        let mut shots = Vec::new();
        while shots.len() < 12
            && let Some(cell) = select(&engine.cell_power().unwrap(), 0.0)
        {
            shots.push(engine.shoot(cell).unwrap());
            let field = engine.field().unwrap();
            let energy = Energy::new(&mesh, &field, &shots);
            let bound = energy_rounding(&energy, mesh.area_unit(), &shots);
            prop_assert!(
                energy.imbalance <= bound,
                "{} > {bound}: {energy:?}",
                energy.imbalance
            );
            settled(&mesh, &field, shots.len())?;
        }
        Ok(())
    });
}

/// The scene with each face's light changed.
fn relit(cut: &Cut, light: impl Fn(usize) -> Vec3) -> Cut {
    let mut cut = cut.clone();
    for (k, face) in cut.scene.faces.iter_mut().enumerate() {
        face.emission = light(k);
    }
    cut
}

/// Each face's light, each other face's, and the sum of the two.
fn lights(cut: &Cut) -> [Cut; 3] {
    let faces = &cut.scene.faces;
    let first = |k: usize| faces[k].emission;
    let second = |k: usize| faces[(k + 1) % faces.len()].emission * 0.75;
    [
        relit(cut, first),
        relit(cut, second),
        relit(cut, |k| first(k) + second(k)),
    ]
}

fn sum(a: &Field, b: &Field) -> Field {
    let mut sum = a.clone();
    for (value, other) in sum.radiosity.iter_mut().zip(&b.radiosity) {
        *value += *other;
    }
    sum
}

/// The same shots, all of them sums of positive numbers: each rounds what it adds 14 times (a flux of
/// up to 64 texels 8, three products, two quotients, the addition), and light may have come through
/// all of the shots.
#[test]
fn the_same_shots_of_two_lights_are_those_of_their_sum() {
    every_engine(4, &any_scene(), |way, cut| {
        let [first, second, both] = lights(&cut).map(|cut| cut.mesh(way.samples));
        let log: Vec<u32> = all(&both).into_iter().chain(all(&both)).collect();
        let [first, second, together] =
            [&first, &second, &both].map(|mesh| way.replay(mesh, &log).field);
        let bound = 2.0 * (14 * log.len() + 2) as f64 * U;
        let sum = sum(&first, &second);
        for (k, (a, b)) in together.radiosity.iter().zip(&sum.radiosity).enumerate() {
            let (a, b) = (a.truncate().as_dvec3(), b.truncate().as_dvec3());
            prop_assert!(
                (a - b).abs().cmple(bound * a).all(),
                "texel {k}: {a} is not {b}"
            );
        }
        Ok(())
    });
}

#[test]
fn the_light_of_two_is_the_sum_of_their_lights() {
    every_way(2, &any_scene(), |way, cut| {
        let [first, second, both] = lights(&cut).map(|cut| cut.mesh(way.samples));
        let gain = gain(&both, &way.links(&both));
        prop_assume!(gain < 100.0);
        let runs = [&first, &second, &both].map(|mesh| way.solve(mesh));
        let sum = sum(&runs[0].field, &runs[1].field);
        let found = apart(&both, &sum, &runs[2].field, |k| k);
        let bound = left(&both, gain, &[&runs[0], &runs[1], &runs[2]]);
        prop_assert!(found <= bound, "{found:e} > {bound:e}");
        Ok(())
    });
}

/// One face emits more, another reflects more.
fn brighter(cut: &Cut, at: usize) -> Cut {
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

/// Sums, products and quotients by the same numbers are monotone also when they are rounded: not one
/// texel may be darker by one bit.
#[test]
fn the_same_shots_of_more_light_darken_nothing() {
    every_engine(4, &(any_scene(), any::<usize>()), |way, (cut, at)| {
        let [less, more] = [cut.clone(), brighter(&cut, at)].map(|cut| cut.mesh(way.samples));
        let log: Vec<u32> = all(&less).into_iter().chain(all(&less)).collect();
        let [less, more] = [&less, &more].map(|mesh| way.replay(mesh, &log).field);
        for k in 0..less.radiosity.len() {
            prop_assert!(
                more.radiosity[k].cmpge(less.radiosity[k]).all(),
                "B of texel {k}"
            );
            prop_assert!(
                more.irradiance[k].cmpge(less.irradiance[k]).all(),
                "H of texel {k}"
            );
        }
        Ok(())
    });
}

/// ΣA·max(0, less − more).
fn darkened(mesh: &Mesh, less: &Run, more: &Run) -> f64 {
    let pairs = less.field.radiosity.iter().zip(&more.field.radiosity);
    let each = mesh.texels.iter().zip(pairs).map(|(texel, (less, more))| {
        let lost = (less.truncate() - more.truncate()).max(Vec3::ZERO);
        f64::from(texel.area) * lost.as_dvec3().element_sum()
    });
    each.sum::<f64>() * mesh.area_unit()
}

#[test]
fn more_light_darkens_nothing() {
    every_way(2, &(any_scene(), any::<usize>()), |way, (cut, at)| {
        let [less, more] = [cut.clone(), brighter(&cut, at)].map(|cut| cut.mesh(way.samples));
        let gain = gain(&more, &way.links(&more));
        prop_assume!(gain < 100.0);
        let runs = [&less, &more].map(|mesh| way.solve(mesh));
        let found = darkened(&more, &runs[0], &runs[1]);
        let bound = left(&more, gain, &[&runs[0], &runs[1]]);
        prop_assert!(found <= bound, "{found:e} > {bound:e}");
        Ok(())
    });
}

/// Links by rays are the same bits on a software adapter, and so is all that follows; others may fuse
/// products and sums, and then choose other shooters.
#[test]
fn both_solvers_have_one_answer() {
    every_engine(2, &any_scene(), |way, cut| {
        if way.on_gpu {
            return Ok(());
        }
        let mesh = cut.mesh(way.samples);
        for iteration in ITERATIONS {
            let [cpu, device] = [false, true].map(|on_gpu| {
                let way = Way {
                    on_gpu,
                    iteration,
                    ..way
                };
                way.solve(&mesh)
            });
            if shared_gpu().line.software {
                prop_assert_eq!(&cpu.shots, &device.shots, "{:?}", iteration);
                prop_assert_eq!(&cpu.field.radiosity, &device.field.radiosity);
                prop_assert_eq!(&cpu.field.residual, &device.field.residual);
                for (a, b) in cpu.field.irradiance.iter().zip(&device.field.irradiance) {
                    prop_assert_eq!(a.truncate(), b.truncate());
                }
            } else {
                let bound = 10.0 * (unshot(&mesh, &cpu.field) + unshot(&mesh, &device.field));
                let found = apart(&mesh, &cpu.field, &device.field, |k| k);
                prop_assert!(found <= bound, "{iteration:?}: {found:e} > {bound:e}");
            }
        }
        Ok(())
    });
}
