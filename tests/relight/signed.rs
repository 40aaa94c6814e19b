//! Signed relighting, compared with the full solution and with results by hand.

use approx::abs_diff_eq;
use common::energy::EnergyBalance;
use common::import::{ImportOptions, load_scene};
use common::relight::{MendedFlaws, RelightMethod, RelitRoom, RoomRadiosity};
use common::settings::{Meshing, Schedule, Settings, Transport, Visibility};
use cpu::CpuSolver;
use glam::{DVec3, Vec3, Vec4};
use radiosity_tests::box_faces;
use radiosity_tests::engines::{item_buffer, open_gpu};
use radiosity_tests::relighting::*;
use std::path::Path;

#[test]
fn null_object_changes_nothing() {
    let gpu = open_gpu();
    for visibility in VISIBILITIES {
        let settings = relight_settings(visibility);
        let (scene, count) = furnished_room(Vec::new());
        let mesh = furnished_mesh(&scene, count, &settings);
        let room = capture_room(&scene, &mesh, &settings, 1e-2);
        for make in [&cpu_engine as &EngineMaker, &gpu_engine(&gpu)] {
            for method in [
                RelightMethod::Signed,
                RelightMethod::Paper(MendedFlaws {
                    empty_room: true,
                    ..MendedFlaws::default()
                }),
            ] {
                let mut engine = make(&mesh, &settings.transport);
                let relit = run_relight(engine.as_mut(), &mesh, &room, method, &settings.schedule);
                let worst = relit.change.radiosity.iter().position(|d| *d != Vec4::ZERO);
                assert!(
                    worst.is_none(),
                    "{visibility:?} {} {worst:?} {:?}",
                    relit.run.field.origin,
                    relit.change.radiosity[worst.unwrap()]
                );
                assert_eq!(relit.run.field.radiosity, room.radiosity);
                assert!(relit.run.converged && relit.object_shots == 0 && relit.map_shots > 0);
            }
        }
    }
}

#[test]
fn signed_relight_equals_full_solution() {
    let gpu = open_gpu();
    for visibility in [Visibility::Rays, ITEM_BUFFER] {
        let settings = relight_settings(visibility);
        let (scene, count) = furnished_room(bottomless_box(Vec3::ZERO, Vec3::new(0.2, 0.5, 0.8)));
        let mesh = furnished_mesh(&scene, count, &settings);
        let room = capture_room(&scene, &mesh, &settings, 1e-2);
        let truth = full_solution(
            &mesh,
            &settings.transport,
            &Schedule {
                epsilon: 1e-6,
                ..settings.schedule
            },
        );
        for make in [&cpu_engine as &EngineMaker, &gpu_engine(&gpu)] {
            let mut engine = make(&mesh, &settings.transport);
            let relit = run_relight(engine.as_mut(), &mesh, &room, RelightMethod::Signed, &settings.schedule);
            let error = relative_error(&mesh, &relit.run.field, &truth);
            let energy = EnergyBalance::new(&with_surface(&mesh, &relit), &relit.run.field, &relit.run.shots);
            println!(
                "{visibility:?}: {error:.2e}, imbalance {:.1e}, {} + {} shots",
                energy.imbalance, relit.map_shots, relit.object_shots
            );
            assert!(error < 1e-3, "{visibility:?}: {error}");
            assert!(energy.imbalance < 1e-4, "{energy:?}");
        }
    }
}

/// The paper's room with its objects, shot as whole faces like in the paper; unshot light on both sides is well
/// below the bound.
#[test]
fn signed_relight_equals_full_solution_in_paper_room() {
    let bundled = |name: &str| {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes").join(name);
        load_scene(&path, &ImportOptions::default()).unwrap()
    };
    let mut scene = bundled("paper_room.obj");
    let count = scene.faces.len();
    scene.faces.extend(bundled("paper_objects.obj").faces);
    let gpu = open_gpu();
    for visibility in [Visibility::Rays, item_buffer(512)] {
        let settings = Settings {
            meshing: Meshing {
                texels: 8,
                patches: 1,
                samples: 1,
            },
            transport: Transport {
                ..relight_settings(visibility).transport
            },
            ..relight_settings(visibility)
        };
        let mesh = furnished_mesh(&scene, count, &settings);
        let room = capture_room(&scene, &mesh, &settings, 1e-4);
        let truth = full_solution(&mesh, &settings.transport, &settings.schedule);
        let mut printed = f64::NAN;
        for make in [&cpu_engine as &EngineMaker, &gpu_engine(&gpu)] {
            let relit = run_relight(
                make(&mesh, &settings.transport).as_mut(),
                &mesh,
                &room,
                RelightMethod::Signed,
                &settings.schedule,
            );
            let paper = RelightMethod::Paper(MendedFlaws::default());
            let table_2 = run_relight(
                make(&mesh, &settings.transport).as_mut(),
                &mesh,
                &room,
                paper,
                &settings.schedule,
            );
            let of = |relit: &RelitRoom| {
                let energy = EnergyBalance::new(&with_surface(&mesh, relit), &relit.run.field, &relit.run.shots);
                (
                    relative_error(&mesh, &relit.run.field, &truth),
                    energy.imbalance,
                    energy.share_of_emitted(energy.closure),
                )
            };
            let (signed, table_2) = (of(&relit), of(&table_2));
            println!(
                "{visibility:?} {}: signed {:.4} % of error, imbalance {:.1e}, closure {:.2} %, {} + {} shots; Table 2 {:.1} %, {:.2}",
                relit.run.field.origin,
                100.0 * signed.0,
                signed.1,
                100.0 * signed.2,
                relit.map_shots,
                relit.object_shots,
                100.0 * table_2.0,
                table_2.1
            );
            assert!(signed.0 < 1e-3 && signed.1 < 1e-4, "{signed:?}");
            assert!(table_2.0 > 0.05 && table_2.1 > 0.01, "{table_2:?}");
            // Both solvers agree.
            assert!(printed.is_nan() || abs_diff_eq!(printed, table_2.0, epsilon = 0.01));
            printed = table_2.0;
        }
    }
}

#[test]
fn black_object_only_darkens() {
    let gpu = open_gpu();
    for visibility in [Visibility::Rays, ITEM_BUFFER] {
        let mut settings = relight_settings(visibility);
        settings.meshing.patches = 4;
        // The object covers one whole patch of the floor. Light of a partly covered patch would leave from its open
        // points, whose noise may brighten texels.
        let (low, high) = (DVec3::new(1.5, 0.0, 2.0), DVec3::new(2.25, 0.8, 3.0));
        let (scene, count) = furnished_room(box_faces(low, high, false, Vec3::ZERO, Vec3::ZERO));
        let mesh = furnished_mesh(&scene, count, &settings);
        let room = capture_room(&scene, &mesh, &settings, 1e-6);
        for make in [&cpu_engine as &EngineMaker, &gpu_engine(&gpu)] {
            let mut engine = make(&mesh, &settings.transport);
            let relit = run_relight(engine.as_mut(), &mesh, &room, RelightMethod::Signed, &settings.schedule);
            // Unshot light may fall anywhere: at most all of it on one texel.
            let unshot: f64 = relit.run.unshot_fraction() * f64::from(relit.run.emitted);
            let mut darkest = 0.0f32;
            for (k, texel) in mesh.texels.iter().enumerate() {
                if mesh.is_object(texel.face) {
                    assert_eq!(relit.run.field.radiosity[k], Vec4::ZERO);
                    continue;
                }
                let change = relit.change.radiosity[k];
                let bound = unshot as f32 / texel.area;
                assert!(change.max_element() <= bound, "{change} beyond {bound}");
                assert!(relit.run.field.radiosity[k].min_element() >= -bound);
                darkest = darkest.min(change.min_element());
            }
            assert!(darkest < -0.1, "no shadow: {darkest}");
        }
    }
}

/// Light under a body is lost, both from a lamp of the room and from captured light.
#[test]
fn light_under_a_body_is_lost() {
    let mut settings = relight_settings(Visibility::Rays);
    settings.meshing.samples = 16;
    let (mut scene, count) = furnished_room(bottomless_box(Vec3::ZERO, Vec3::splat(0.5)));
    scene.faces[0].emission = Vec3::splat(2.0);
    let mesh = furnished_mesh(&scene, count, &settings);
    assert!(
        mesh.patches
            .iter()
            .any(|c| c.open_share < 1.0 && c.open_share > 0.0 && c.open_share_before == 1.0)
    );
    let room = capture_room(&scene, &mesh, &settings, 1e-5);
    let relit = run_relight(
        &mut CpuSolver::new(&mesh, &settings.transport),
        &mesh,
        &room,
        RelightMethod::Signed,
        &settings.schedule,
    );
    let truth = full_solution(
        &mesh,
        &settings.transport,
        &Schedule {
            epsilon: 1e-6,
            ..settings.schedule
        },
    );
    let error = relative_error(&mesh, &relit.run.field, &truth);
    let energy = EnergyBalance::new(&with_surface(&mesh, &relit), &relit.run.field, &relit.run.shots);
    println!("{error:.2e} {energy:?}");
    assert!(error < 1e-3 && energy.imbalance < 1e-4);
    assert!(energy.share_of_emitted(energy.escaped) > 0.01, "{energy:?}");
}

#[test]
fn reflectance_and_emission_are_recovered_from_captured_light() {
    let settings = Settings {
        meshing: Meshing {
            texels: 8,
            patches: 8,
            samples: 4,
        },
        ..relight_settings(Visibility::Rays)
    };
    let (scene, count) = furnished_room(Vec::new());
    let mesh = furnished_mesh(&scene, count, &settings);
    let known = capture_room(&scene, &mesh, &settings, 1e-6);
    let room = RoomRadiosity {
        residual: vec![Vec4::ZERO; mesh.texels.len()],
        reflectance: None,
        ..known.clone()
    };
    let relit = run_relight(
        &mut CpuSolver::new(&mesh, &settings.transport),
        &mesh,
        &room,
        RelightMethod::Signed,
        &settings.schedule,
    );
    let surface = &relit.surface;
    for (k, texel) in mesh.texels.iter().enumerate() {
        // The ceiling is the lamp.
        assert_eq!(surface.emitters.contains(&(k as u32)), texel.face == 1, "{k}");
        let h = relit.run.field.irradiance[k].truncate();
        let b = surface.emission[k] + surface.reflectance[k] * h;
        let apart = (b - room.radiosity[k].truncate()).abs().max_element();
        assert!(apart <= 4.0 * f32::EPSILON * b.max_element(), "{k}");
        if texel.face != 1 {
            let error = (surface.reflectance[k] - texel.reflectance).abs().max_element();
            assert!(
                error < 1e-4,
                "{k}: {} for {}",
                surface.reflectance[k],
                texel.reflectance
            );
        }
    }
}
