//! Relighting on the GPU: the same as on the CPU, and faults in it are noticed.

use common::relight::{MendedFlaws, RelightMethod, RoomRadiosity, relight_room};
use common::settings::{ItemBufferProjection, Schedule, Visibility};
use cpu::CpuSolver;
use glam::Vec3;
use gpu::GpuSolver;
use radiosity_tests::engines::open_gpu;
use radiosity_tests::relighting::*;
use radiosity_tests::shader_faults::{assert_faults_noticed, shader_fault};
use std::ops::ControlFlow;

#[test]
fn cpu_and_gpu_relight_to_equal_fields() {
    let settings = relight_settings(Visibility::Rays);
    let (scene, count) = furnished_room(bottomless_box(Vec3::new(1.0, 0.5, 0.0), Vec3::splat(0.5)));
    let mesh = furnished_mesh(&scene, count, &settings);
    let room = capture_room(&scene, &mesh, &settings, 1e-4);
    for method in [RelightMethod::Signed, RelightMethod::Paper(MendedFlaws::default())] {
        let cpu = run_relight(
            &mut CpuSolver::new(&mesh, &settings.transport),
            &mesh,
            &room,
            method,
            &settings.schedule,
        );
        let mut solver = GpuSolver::new(&open_gpu(), &mesh, &settings.transport).unwrap();
        let gpu = run_relight(&mut solver, &mesh, &room, method, &settings.schedule);
        assert_ne!(cpu.run.field.origin, gpu.run.field.origin);
        let apart = relative_error(&mesh, &gpu.run.field, &cpu.run.field);
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
fn captured_light_only_decreases() {
    let gpu = open_gpu();
    for visibility in VISIBILITIES {
        let mut settings = relight_settings(visibility);
        settings.meshing.samples = 1;
        let (scene, count) = furnished_room(bottomless_box(Vec3::ZERO, Vec3::ZERO));
        let mesh = furnished_mesh(&scene, count, &settings);
        let room = capture_room(&scene, &mesh, &settings, 1e-3);
        for make in [&cpu_engine as &EngineMaker, &gpu_engine(&gpu)] {
            // With the room's walls black, all there is are the captured shots: each can only take.
            let black = RoomRadiosity {
                reflectance: Some(vec![Vec3::splat(1e-3); mesh.texels.len()]),
                ..room.clone()
            };
            let mut engine = make(&mesh, &settings.transport);
            let mut watched = 0;
            relight_room(
                engine.as_mut(),
                &mesh,
                &black,
                RelightMethod::Signed,
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
            let after = engine.read_field().unwrap();
            for (k, h) in after.irradiance.iter().enumerate() {
                if !mesh.is_object(mesh.texels[k].face) {
                    assert!(h.truncate().max_element() <= 0.0, "{visibility:?} {k} {h}");
                }
            }
            // Table 3 clips what is half a unit deep: all of this room.
            let shadow = after.irradiance.iter().any(|h| h.x < 0.0);
            assert!(
                shadow || visibility == Visibility::with_item_buffer(ItemBufferProjection::Paper, 256),
                "{visibility:?}: no shadow"
            );
        }
    }
}

#[test]
fn relight_shader_faults_are_noticed() {
    let faults = [
        ("deposit", "* shot.scale - baseline.x", "* shot.scale"),
        (
            "deposit",
            "radiosity[k] += vec4f(shot.radiosity * baseline.y, 0.0);",
            "",
        ),
        ("deposit", "if (params.rule & KEEP_BIT) != 0u ||", "if"),
        (
            "link",
            "before = visible_factor(sums, sums.before, shots[slot].open_before);",
            "before = visible_factor(sums, sums.seen, shots[slot].open);",
        ),
        ("rays", "if !continues || primitive < params.room", "if true"),
        ("select", "shot.open_before = patches[patch_index].open_before;", ""),
    ];
    let mut settings = relight_settings(Visibility::Rays);
    settings.meshing.samples = 4;
    let (scene, count) = furnished_room(bottomless_box(Vec3::new(1.0, 0.5, 0.0), Vec3::splat(0.5)));
    let mesh = furnished_mesh(&scene, count, &settings);
    let room = capture_room(&scene, &mesh, &settings, 1e-4);
    let cpu = run_relight(
        &mut CpuSolver::new(&mesh, &settings.transport),
        &mesh,
        &room,
        RelightMethod::Signed,
        &settings.schedule,
    );
    let gpu = open_gpu();
    let faults = faults.map(|(file, from, to)| shader_fault(file, from, to));
    assert_faults_noticed(faults, |fault| {
        let mut solver = GpuSolver::with_faults(&gpu, &mesh, &settings.transport, &[fault]).unwrap();
        let relit = relight_room(
            &mut solver,
            &mesh,
            &room,
            RelightMethod::Signed,
            &Schedule {
                max_shots: 500,
                ..settings.schedule
            },
            &mut |_, _| ControlFlow::Continue(()),
        )
        .unwrap();
        let change = relative_error(&mesh, &relit.run.field, &cpu.run.field);
        let before = relit
            .surface
            .emission
            .iter()
            .zip(&cpu.surface.emission)
            .any(|(a, b)| (*a - *b).abs().max_element() > 1e-3);
        println!("{fault:?}: {change:.1e} {before}");
        change.is_nan() || change > settings.schedule.epsilon || before
    });
}
