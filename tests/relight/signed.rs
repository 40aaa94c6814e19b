//! Relighting held to the full solution, and to what can be worked out by hand.

use approx::abs_diff_eq;
use common::energy::Energy;
use common::import::{ImportOptions, load};
use common::relight::{Mended, Method, Relit, Room};
use common::settings::{Meshing, Schedule, Settings, Transport, Visibility};
use cpu::CpuSolver;
use glam::{DVec3, Vec3, Vec4};
use radiosity_tests::engines::{drawn, gpu};
use radiosity_tests::relighting::*;
use radiosity_tests::room;
use std::path::Path;

#[test]
fn nothing_inserted_changes_nothing() {
    let gpu = gpu();
    for visibility in ALL {
        let settings = settings(visibility);
        let (scene, count) = furnished_room(Vec::new());
        let mesh = mesh_of(&scene, count, &settings);
        let room = capture(&scene, &mesh, &settings, 1e-2);
        for make in [&on_cpu as &Maker, &on_gpu(&gpu)] {
            for method in [
                Method::Signed,
                Method::Paper(Mended {
                    empty_room: true,
                    ..Mended::default()
                }),
            ] {
                let mut engine = make(&mesh, &settings.transport);
                let relit = run(engine.as_mut(), &mesh, &room, method, &settings.schedule);
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
fn signed_is_the_full_solution() {
    let gpu = gpu();
    for visibility in [Visibility::Rays, DRAWN] {
        let settings = settings(visibility);
        let (scene, count) = furnished_room(cube(Vec3::ZERO, Vec3::new(0.2, 0.5, 0.8)));
        let mesh = mesh_of(&scene, count, &settings);
        let room = capture(&scene, &mesh, &settings, 1e-2);
        let truth = full(
            &mesh,
            &settings.transport,
            &Schedule {
                epsilon: 1e-6,
                ..settings.schedule
            },
        );
        for make in [&on_cpu as &Maker, &on_gpu(&gpu)] {
            let mut engine = make(&mesh, &settings.transport);
            let relit = run(
                engine.as_mut(),
                &mesh,
                &room,
                Method::Signed,
                &settings.schedule,
            );
            let error = error(&mesh, &relit.run.field, &truth);
            let energy = Energy::new(
                &with_surface(&mesh, &relit),
                &relit.run.field,
                &relit.run.shots,
            );
            println!(
                "{visibility:?}: {error:.2e}, imbalance {:.1e}, {} + {} shots",
                energy.imbalance, relit.map_shots, relit.object_shots
            );
            assert!(error < 1e-3, "{visibility:?}: {error}");
            assert!(energy.imbalance < 1e-4, "{energy:?}");
        }
    }
}

/// The paper's room with its objects, whole faces as the paper shot them; tight enough that what is
/// left unshot on both sides is well below the bound.
#[test]
fn signed_is_the_full_solution_in_the_paper_s_room() {
    let bundled = |name: &str| {
        let path = Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("../scenes")
            .join(name);
        load(&path, &ImportOptions::default()).unwrap()
    };
    let mut scene = bundled("paper_room.obj");
    let count = scene.faces.len();
    scene.faces.extend(bundled("paper_objects.obj").faces);
    let gpu = gpu();
    for visibility in [Visibility::Rays, drawn(512)] {
        let settings = Settings {
            meshing: Meshing {
                texels: 8,
                cells: 1,
                samples: 1,
            },
            transport: Transport {
                ..settings(visibility).transport
            },
            ..settings(visibility)
        };
        let mesh = mesh_of(&scene, count, &settings);
        let room = capture(&scene, &mesh, &settings, 1e-4);
        let truth = full(&mesh, &settings.transport, &settings.schedule);
        let mut printed = f64::NAN;
        for make in [&on_cpu as &Maker, &on_gpu(&gpu)] {
            let relit = run(
                make(&mesh, &settings.transport).as_mut(),
                &mesh,
                &room,
                Method::Signed,
                &settings.schedule,
            );
            let paper = Method::Paper(Mended::default());
            let table_2 = run(
                make(&mesh, &settings.transport).as_mut(),
                &mesh,
                &room,
                paper,
                &settings.schedule,
            );
            let of = |relit: &Relit| {
                let energy = Energy::new(
                    &with_surface(&mesh, relit),
                    &relit.run.field,
                    &relit.run.shots,
                );
                (
                    error(&mesh, &relit.run.field, &truth),
                    energy.imbalance,
                    energy.share(energy.closure),
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
            // Two solvers, one answer.
            assert!(printed.is_nan() || abs_diff_eq!(printed, table_2.0, epsilon = 0.01));
            printed = table_2.0;
        }
    }
}

#[test]
fn a_black_object_only_darkens() {
    let gpu = gpu();
    for visibility in [Visibility::Rays, DRAWN] {
        let mut settings = settings(visibility);
        settings.meshing.cells = 4;
        // It covers one cell of the floor: of one that it cut, the light would leave from whichever
        // of its points are open, which is noise that may brighten.
        let (low, high) = (DVec3::new(1.5, 0.0, 2.0), DVec3::new(2.25, 0.8, 3.0));
        let (scene, count) = furnished_room(room(low, high, false, Vec3::ZERO, Vec3::ZERO));
        let mesh = mesh_of(&scene, count, &settings);
        let room = capture(&scene, &mesh, &settings, 1e-6);
        for make in [&on_cpu as &Maker, &on_gpu(&gpu)] {
            let mut engine = make(&mesh, &settings.transport);
            let relit = run(
                engine.as_mut(),
                &mesh,
                &room,
                Method::Signed,
                &settings.schedule,
            );
            // What is still unshot may land anywhere: at most all of it on one texel.
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

/// Light under a body is lost, whether it stands on a lamp of the room or on captured light.
#[test]
fn a_body_on_a_lamp_buries_its_light() {
    let mut settings = settings(Visibility::Rays);
    settings.meshing.samples = 16;
    let (mut scene, count) = furnished_room(cube(Vec3::ZERO, Vec3::splat(0.5)));
    scene.faces[0].emission = Vec3::splat(2.0);
    let mesh = mesh_of(&scene, count, &settings);
    assert!(
        mesh.cells
            .iter()
            .any(|c| c.open < 1.0 && c.open > 0.0 && c.open_before == 1.0)
    );
    let room = capture(&scene, &mesh, &settings, 1e-5);
    let relit = run(
        &mut CpuSolver::new(&mesh, &settings.transport),
        &mesh,
        &room,
        Method::Signed,
        &settings.schedule,
    );
    let truth = full(
        &mesh,
        &settings.transport,
        &Schedule {
            epsilon: 1e-6,
            ..settings.schedule
        },
    );
    let error = error(&mesh, &relit.run.field, &truth);
    let energy = Energy::new(
        &with_surface(&mesh, &relit),
        &relit.run.field,
        &relit.run.shots,
    );
    println!("{error:.2e} {energy:?}");
    assert!(error < 1e-3 && energy.imbalance < 1e-4);
    assert!(energy.share(energy.escaped) > 0.01, "{energy:?}");
}

#[test]
fn walls_are_told_from_their_own_light() {
    let settings = Settings {
        meshing: Meshing {
            texels: 8,
            cells: 8,
            samples: 4,
        },
        ..settings(Visibility::Rays)
    };
    let (scene, count) = furnished_room(Vec::new());
    let mesh = mesh_of(&scene, count, &settings);
    let known = capture(&scene, &mesh, &settings, 1e-6);
    let room = Room {
        residual: vec![Vec4::ZERO; mesh.texels.len()],
        reflectance: None,
        ..known.clone()
    };
    let relit = run(
        &mut CpuSolver::new(&mesh, &settings.transport),
        &mesh,
        &room,
        Method::Signed,
        &settings.schedule,
    );
    let surface = &relit.surface;
    for (k, texel) in mesh.texels.iter().enumerate() {
        // The ceiling is the lamp.
        assert_eq!(
            surface.emitters.contains(&(k as u32)),
            texel.face == 1,
            "{k}"
        );
        let h = relit.run.field.irradiance[k].truncate();
        let b = surface.emission[k] + surface.reflectance[k] * h;
        let apart = (b - room.radiosity[k].truncate()).abs().max_element();
        assert!(apart <= 4.0 * f32::EPSILON * b.max_element(), "{k}");
        if texel.face != 1 {
            let error = (surface.reflectance[k] - texel.reflectance)
                .abs()
                .max_element();
            assert!(
                error < 1e-4,
                "{k}: {} for {}",
                surface.reflectance[k],
                texel.reflectance
            );
        }
    }
}
