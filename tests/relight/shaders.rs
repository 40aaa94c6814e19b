//! Relighting on the GPU: the same as on the CPU, and faults in it are noticed.

use common::relight::{MendedFlaws, RelightMethod};
use common::settings::Visibility;
use cpu::CpuSolver;
use glam::Vec3;
use radiosity_tests::engines::{both_engines, gpu_solver};
use radiosity_tests::relighting::*;
use radiosity_tests::shader_faults::assert_faults_noticed;

#[test]
fn cpu_and_gpu_relight_to_equal_fields() {
    let glowing = bottomless_box(Vec3::new(1.0, 0.5, 0.0), Vec3::splat(0.5));
    let captured = FurnishedRoom::furnish(relight_settings(Visibility::Rays), glowing, 1e-4);
    for method in [RelightMethod::Signed, RelightMethod::Paper(MendedFlaws::default())] {
        let engines = both_engines(&captured.mesh, &captured.settings.transport);
        let [cpu, gpu] = engines.map(|mut engine| {
            // An engine keeps no state between relights.
            let [first, second] = [(); 2].map(|()| captured.relight(engine.as_mut(), method).run);
            assert_eq!(first.shots, second.shots);
            assert_eq!(first.field, second.field);
            first
        });
        assert_ne!(cpu.field.origin, gpu.field.origin);
        let apart = relative_error(&captured.mesh, &gpu.field, &cpu.field);
        let shots = [cpu.shots.len(), gpu.shots.len()];
        // Rounding of a few hundred shots, and one more or less of them.
        assert!(apart < captured.settings.schedule.epsilon, "{method:?}: {apart}");
        assert!(shots[0].abs_diff(shots[1]) <= 2, "{shots:?}");
    }
}

#[test]
fn captured_light_only_decreases() {
    for visibility in VISIBILITIES {
        let mut settings = relight_settings(visibility);
        settings.meshing.samples = 1;
        let mut captured = FurnishedRoom::furnish(settings, bottomless_box(Vec3::ZERO, Vec3::ZERO), 1e-3);
        // With the room's walls black, all there is are the captured shots: each can only take.
        captured.room.reflectance = Some(vec![Vec3::splat(1e-3); captured.mesh.texels.len()]);
        for mut engine in both_engines(&captured.mesh, &settings.transport) {
            captured.relight_shots(engine.as_mut(), RelightMethod::Signed, 8);
            let after = engine.read_field().unwrap();
            for (k, h) in after.irradiance.iter().enumerate() {
                if !captured.mesh.is_object(captured.mesh.texels[k].face) {
                    assert!(h.truncate().max_element() <= 0.0, "{visibility:?} {k} {h}");
                }
            }
            // Table 3 clips what is half a unit deep: all of this room.
            let shadow = after.irradiance.iter().any(|h| h.x < 0.0);
            assert!(shadow || visibility == PAPER_BUFFER, "{visibility:?}: no shadow");
        }
    }
}

#[test]
fn relight_shader_faults_are_noticed() {
    let mut settings = relight_settings(Visibility::Rays);
    settings.meshing.samples = 4;
    let glowing = bottomless_box(Vec3::new(1.0, 0.5, 0.0), Vec3::splat(0.5));
    let captured = FurnishedRoom::furnish(settings, glowing, 1e-4);
    let (mesh, transport) = (&captured.mesh, &settings.transport);
    let cpu = captured.relight(&mut CpuSolver::new(mesh, transport), RelightMethod::Signed);
    assert_faults_noticed("relight", |faults| {
        let mut solver = gpu_solver(mesh, transport, faults);
        let gpu = captured.relight_shots(&mut solver, RelightMethod::Signed, 500);
        let change = relative_error(mesh, &gpu.run.field, &cpu.run.field);
        let emission = gpu.surface.emission.iter().zip(&cpu.surface.emission);
        let differs = emission
            .map(|(a, b)| (*a - *b).abs().max_element())
            .any(|off| off > 1e-3);
        let wrong = [
            ("field", change.is_nan() || change > settings.schedule.epsilon),
            ("emission", differs),
        ];
        let wrong = wrong.into_iter().filter(|(_, wrong)| *wrong);
        wrong.map(|(name, _)| name.to_owned()).collect()
    });
}
