//! Invariance of solutions under the unit of light, the unit of length, the origin, dark and degenerate faces, and
//! the resolution of each face.

use common::mesh::Mesh;
use common::scene::{Face, Scene};
use common::settings::Schedule;
use common::shooting::{RadiosityField, Shoot, replay_log};
use cpu::CpuSolver;
use glam::{DVec3, Vec3, Vec4};
use oracle::exact;
use radiosity_tests::bounds::U;
use radiosity_tests::engines::{each_engine, engine_settings, mesh_of, shoot_freely};
use radiosity_tests::{furnace, lit_room};

fn with_brightness(scene: &Scene, factor: f32) -> Scene {
    let mut scene = scene.clone();
    scene.faces.iter_mut().for_each(|face| face.emission *= factor);
    scene
}

/// Powers of two scale every number without rounding.
#[test]
fn power_of_two_brightness_keeps_shots_and_scales_radiosity() {
    let plain = lit_room();
    each_engine(&mesh_of(&plain), |name, fresh| {
        let run = shoot_freely(&mut *fresh(), &engine_settings().schedule);
        for factor in [(-20f32).exp2(), 20f32.exp2()] {
            each_engine(&mesh_of(&with_brightness(&plain, factor)), |other, fresh| {
                if other == name {
                    let scaled = shoot_freely(&mut *fresh(), &engine_settings().schedule);
                    assert_eq!(scaled.shooter_log(), run.shooter_log(), "{name}");
                    for (a, b) in scaled.field.radiosity.iter().zip(&run.field.radiosity) {
                        assert_eq!(*a, *b * factor, "{name}");
                    }
                }
            });
        }
    });
}

/// Other factors round E and all sums: the shooter is the same or one of equal power.
#[test]
fn brightness_keeps_shooters_except_among_equals() {
    let plain = lit_room();
    let meshes = [1.0, 1e-6, 1e6].map(|factor| mesh_of(&with_brightness(&plain, factor)));
    let [reference, small, large] = &meshes;
    let log = shoot_freely(
        &mut CpuSolver::new(reference, &engine_settings().transport),
        &engine_settings().schedule,
    );
    for mesh in [small, large] {
        let own = shoot_freely(
            &mut CpuSolver::new(mesh, &engine_settings().transport),
            &engine_settings().schedule,
        );
        assert_eq!(own.shots.len(), log.shots.len());
        let mut engine = CpuSolver::new(mesh, &engine_settings().transport);
        for (k, patch) in log.shooter_log().into_iter().enumerate() {
            let power = engine.patch_power().unwrap();
            let best = power.iter().copied().fold(0.0, f32::max);
            // The power of a patch is a sum after k shots: k + 40 roundings.
            let bound = 1.0 - (k as f64 + 40.0) * U;
            assert!(f64::from(power[patch as usize]) >= bound * f64::from(best), "shot {k}");
            engine.shoot(patch).unwrap();
        }
    }
}

fn scaled_and_moved(scene: &Scene, scale: f64, shift: DVec3) -> Scene {
    let mut scene = scene.clone();
    for face in &mut scene.faces {
        face.corners = face.corners.map(|p| p * scale + shift);
    }
    scene
}

fn same_bits(a: &RadiosityField, b: &RadiosityField) -> bool {
    a.radiosity == b.radiosity && a.residual == b.residual && a.irradiance == b.irradiance
}

/// lit_room has dyadic coordinates: powers of two and dyadic shifts are exact in f64.
#[test]
fn dyadic_units_and_shifts_keep_every_bit() {
    let plain = lit_room();
    let run = |scene: &Scene| {
        let mesh = mesh_of(scene);
        shoot_freely(
            &mut CpuSolver::new(&mesh, &engine_settings().transport),
            &engine_settings().schedule,
        )
    };
    let expected = run(&plain);
    let shift = DVec3::new(1024.0, -0.125, 4096.5);
    for scene in [
        scaled_and_moved(&plain, (-40f64).exp2(), DVec3::ZERO),
        scaled_and_moved(&plain, 40f64.exp2(), DVec3::ZERO),
        scaled_and_moved(&plain, 1.0, shift),
    ] {
        let run = run(&scene);
        assert_eq!(run.shots, expected.shots);
        assert!(same_bits(&run.field, &expected.field));
    }
}

/// Millimetres, and a place far from the origin: coordinates round differently.
#[test]
fn other_units_and_origins_change_only_rounding() {
    // At 1e6 from the origin f64 leaves 1e−10, less than f32's own rounding in the mesh. That moves
    // each texel and corner by √3·u, which near an edge (half a texel, h = ⅙ of 1/4, away) changes
    // F by √3·u/(h/2) of itself, here 100u, and B by that at each of a handful of reflections.
    const BOUND: f64 = 1000.0 * U;
    let plain = lit_room();
    let mesh = mesh_of(&plain);
    let expected = shoot_freely(
        &mut CpuSolver::new(&mesh, &engine_settings().transport),
        &engine_settings().schedule,
    );
    for (scale, shift) in [
        (1000.0, DVec3::ZERO),
        (0.3, DVec3::splat(0.1)),
        (1.0, DVec3::new(1e6, 0.1, -3e5)),
    ] {
        let mesh = mesh_of(&scaled_and_moved(&plain, scale, shift));
        assert_eq!(mesh.unit.log2().fract(), 0.0, "the unit is a power of two");
        let mut engine = CpuSolver::new(&mesh, &engine_settings().transport);
        let run = replay_log(&mut engine, &expected.shooter_log()).unwrap();
        let pairs = run.field.radiosity.iter().zip(&expected.field.radiosity);
        let worst = pairs
            .map(|(a, b)| f64::from((a.x - b.x).abs() / b.x))
            .fold(0.0, f64::max);
        assert!(worst < BOUND, "scale {scale}, shift {shift}: {} u", worst / U);
    }
}

#[test]
fn dark_scene_converges_without_a_shot() {
    let mesh = mesh_of(&with_brightness(&lit_room(), 0.0));
    each_engine(&mesh, |name, fresh| {
        let run = shoot_freely(&mut *fresh(), &engine_settings().schedule);
        assert!(run.shots.is_empty() && run.converged, "{name}");
        assert_eq!(run.unshot_fraction(), 0.0, "{name}");
        assert!(run.field.radiosity.iter().all(|b| *b == Vec4::ZERO), "{name}");
    });
}

/// A point, a line and a folded quad among the faces, all of them bright.
#[test]
fn faces_without_area_shoot_nothing_and_give_no_nan() {
    let mut scene = lit_room();
    let (p, q) = (DVec3::new(2.0, 1.0, 3.0), DVec3::new(2.25, 1.0, 3.5));
    for corners in [[p; 4], [p, q, q, p], [p, q, p, q]] {
        scene
            .faces
            .push(Face::quad("flat", corners, Vec3::ONE, Vec3::splat(0.5)));
    }
    let mesh = mesh_of(&scene);
    each_engine(&mesh, |name, fresh| {
        let run = shoot_freely(&mut *fresh(), &engine_settings().schedule);
        assert!(run.converged, "{name}");
        let area = |patch: &u32| mesh.patches[*patch as usize].shooter.area;
        assert!(run.shooter_log().iter().all(|patch| area(patch) > 0.0), "{name}");
        let mut engine = fresh();
        for patch in 0..mesh.patches.len() as u32 {
            let shot = engine.shoot(patch).unwrap();
            let finite = shot.form_factor_sum.is_finite() && shot.escaped.is_finite() && shot.unshot.is_finite();
            assert!(finite, "{name}: {shot:?}");
        }
        for field in [run.field, engine.read_field().unwrap()] {
            let all = field.radiosity.iter().chain(&field.residual).chain(&field.irradiance);
            assert!(all.into_iter().all(|v| v.is_finite()), "{name}");
        }
    });
}

/// In a furnace B = E/(1 − ρ) solves the discrete equations at any resolution: Lambert's factors
/// from a texel's centre to all patches around it sum to 1, wherever it is and however large they are.
#[test]
fn furnace_is_exact_with_faces_of_different_resolution() {
    const REFLECTANCE: f32 = 0.5;
    let resolutions: Vec<[u32; 2]> = (0..6).map(|k| [2 + k, 3 + 2 * k % 7]).collect();
    let mesh = Mesh::new(&furnace(REFLECTANCE), &resolutions, 2).unwrap();
    assert_eq!(
        mesh.texels.len() as u32,
        resolutions.iter().map(|[w, h]| w * h).sum::<u32>()
    );
    each_engine(&mesh, |name, fresh| {
        let run = shoot_freely(
            &mut *fresh(),
            &Schedule {
                epsilon: 1e-4,
                ..engine_settings().schedule
            },
        );
        assert!(run.converged, "{name}");
        // Unshot power would be reflected again and again; additions round by u each, F by 100u.
        let unshot = run.field.residual.iter().map(|r| f64::from(r.x)).fold(0.0, f64::max);
        let later = f64::from(REFLECTANCE / (1.0 - REFLECTANCE)) * unshot;
        let rounding = 2.0 * U * (run.shots.len() as f64 + 100.0);
        for b in &run.field.radiosity {
            let missing = exact::furnace_radiosity(1.0, f64::from(REFLECTANCE)) - f64::from(b.x);
            assert!(
                (-rounding..=later + rounding).contains(&missing),
                "{name}: {missing} of {later}"
            );
        }
    });
}
