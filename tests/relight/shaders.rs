//! Relighting on the GPU: the same as on the CPU, and faults in it are noticed.

use common::relight::{Mended, Method, Room, relight};
use common::settings::{Projection, Schedule, Visibility};
use cpu::CpuSolver;
use glam::Vec3;
use gpu::{Fault, GpuSolver};
use radiosity_tests::engines::gpu;
use radiosity_tests::relighting::*;
use std::ops::ControlFlow;

#[test]
fn cpu_and_gpu_relight_alike() {
    let settings = settings(Visibility::Rays);
    let (scene, count) = furnished_room(cube(Vec3::new(1.0, 0.5, 0.0), Vec3::splat(0.5)));
    let mesh = mesh_of(&scene, count, &settings);
    let room = capture(&scene, &mesh, &settings, 1e-4);
    for method in [Method::Signed, Method::Paper(Mended::default())] {
        let cpu = run(
            &mut CpuSolver::new(&mesh, &settings.transport),
            &mesh,
            &room,
            method,
            &settings.schedule,
        );
        let mut solver = GpuSolver::new(&gpu(), &mesh, &settings.transport).unwrap();
        let gpu = run(&mut solver, &mesh, &room, method, &settings.schedule);
        assert_ne!(cpu.run.field.origin, gpu.run.field.origin);
        let apart = error(&mesh, &gpu.run.field, &cpu.run.field);
        println!(
            "{method:?}: {apart:.1e}, shots {} and {}",
            cpu.run.shots.len(),
            gpu.run.shots.len()
        );
        // Rounding of a few hundred shots, and one more or less of them.
        assert!(apart < settings.schedule.epsilon, "{method:?}: {apart}");
        assert!(cpu.run.shots.len().abs_diff(gpu.run.shots.len()) <= 2);
    }
}

#[test]
fn nothing_is_seen_that_was_not_seen_before() {
    let gpu = gpu();
    for visibility in ALL {
        let mut settings = settings(visibility);
        settings.meshing.samples = 1;
        let (scene, count) = furnished_room(cube(Vec3::ZERO, Vec3::ZERO));
        let mesh = mesh_of(&scene, count, &settings);
        let room = capture(&scene, &mesh, &settings, 1e-3);
        for make in [&on_cpu as &Maker, &on_gpu(&gpu)] {
            // With the room's walls black, all there is are the captured shots: each can only take.
            let black = Room {
                reflectance: Some(vec![Vec3::splat(1e-3); mesh.texels.len()]),
                ..room.clone()
            };
            let mut engine = make(&mesh, &settings.transport);
            let mut watched = 0;
            relight(
                engine.as_mut(),
                &mesh,
                &black,
                Method::Signed,
                &settings.schedule,
                &mut |_, _| {
                    watched += 1;
                    if watched < 8 {
                        ControlFlow::Continue(())
                    } else {
                        ControlFlow::Break(())
                    }
                },
            )
            .unwrap();
            let after = engine.field().unwrap();
            for (k, h) in after.irradiance.iter().enumerate() {
                if !mesh.is_object(mesh.texels[k].face) {
                    assert!(h.truncate().max_element() <= 0.0, "{visibility:?} {k} {h}");
                }
            }
            // Table 3 clips what is half a unit deep: all of this room.
            let shadow = after.irradiance.iter().any(|h| h.x < 0.0);
            assert!(
                shadow || visibility == Visibility::drawn(Projection::Paper, 256),
                "{visibility:?}: no shadow"
            );
        }
    }
}

#[test]
fn a_wrong_shader_is_noticed() {
    let faults = [
        ("deposit", "* shot.scale - baseline.x", "* shot.scale"),
        (
            "deposit",
            "radiosity[k] += vec4f(shot.radiosity * baseline.y, 0.0);",
            "",
        ),
        ("deposit", "if (params.rule & KEEP) != 0u ||", "if"),
        (
            "link",
            "before = share(sums, sums.before, shots[slot].open_before);",
            "before = share(sums, sums.seen, shots[slot].open);",
        ),
        ("rays", "if !through || primitive < params.room", "if true"),
        ("select", "shot.open_before = cells[cell].open_before;", ""),
    ];
    let mut settings = settings(Visibility::Rays);
    settings.meshing.samples = 4;
    let (scene, count) = furnished_room(cube(Vec3::new(1.0, 0.5, 0.0), Vec3::splat(0.5)));
    let mesh = mesh_of(&scene, count, &settings);
    let room = capture(&scene, &mesh, &settings, 1e-4);
    let cpu = run(
        &mut CpuSolver::new(&mesh, &settings.transport),
        &mesh,
        &room,
        Method::Signed,
        &settings.schedule,
    );
    let gpu = gpu();
    for (file, from, to) in faults {
        let fault = [Fault { file, from, to }];
        let mut solver = GpuSolver::with_faults(&gpu, &mesh, &settings.transport, &fault).unwrap();
        let relit = relight(
            &mut solver,
            &mesh,
            &room,
            Method::Signed,
            &Schedule {
                max_shots: 500,
                ..settings.schedule
            },
            &mut |_, _| ControlFlow::Continue(()),
        )
        .unwrap();
        let change = error(&mesh, &relit.run.field, &cpu.run.field);
        let before = relit
            .surface
            .emission
            .iter()
            .zip(&cpu.surface.emission)
            .any(|(a, b)| (*a - *b).abs().max_element() > 1e-3);
        println!("{file}, {to:?}: {change:.1e} {before}");
        assert!(
            change.is_nan() || change > settings.schedule.epsilon || before,
            "{file}, {to} was not noticed"
        );
    }
}
