//! Signed relighting, compared with the full solution and with results by hand.

use approx::abs_diff_eq;
use common::energy::EnergyBalance;
use common::relight::{MendedFlaws, RelightMethod};
use common::scene::Face;
use common::settings::Visibility;
use cpu::CpuSolver;
use glam::{DVec3, Vec3, Vec4};
use radiosity_tests::engines::{both_engines, settings_of};
use radiosity_tests::relighting::*;
use radiosity_tests::{box_faces, bundled_scene, lit_room};

#[test]
fn null_object_changes_nothing() {
    let empty_room = MendedFlaws {
        empty_room: true,
        ..MendedFlaws::default()
    };
    for visibility in VISIBILITIES {
        let captured = FurnishedRoom::furnish(relight_settings(visibility), Vec::new(), 1e-2);
        for method in [RelightMethod::Signed, RelightMethod::Paper(empty_room)] {
            for mut engine in both_engines(&captured.mesh, &captured.settings.transport) {
                let relit = captured.relight(engine.as_mut(), method);
                let changed = relit.change.radiosity.iter().position(|d| *d != Vec4::ZERO);
                assert_eq!(changed, None, "{visibility:?} {}", relit.run.field.origin);
                assert_eq!(relit.run.field.radiosity, captured.room.radiosity);
                assert!(relit.run.converged && relit.object_shots == 0 && relit.map_shots > 0);
            }
        }
    }
}

#[test]
fn object_without_area_or_behind_a_wall_changes_nothing_in_the_room() {
    let flat = Face::quad("flat", [DVec3::new(1.5, 1.0, 3.0); 4], Vec3::ONE, Vec3::splat(0.5));
    let (low, high) = (DVec3::new(3.05, 0.3, 1.0), DVec3::new(3.45, 1.0, 1.5));
    for objects in [vec![flat], box_faces(low, high, false, Vec3::ZERO, Vec3::splat(0.5))] {
        let captured = FurnishedRoom::furnish(relight_settings(Visibility::Rays), objects, 1e-2);
        for mut engine in both_engines(&captured.mesh, &captured.settings.transport) {
            let relit = captured.relight(engine.as_mut(), RelightMethod::Signed);
            assert!(relit.map_shots > 0 && relit.object_shots == 0);
            for (k, texel) in captured.mesh.texels.iter().enumerate() {
                if !captured.mesh.is_object(texel.face) {
                    assert_eq!(relit.change.radiosity[k].truncate(), Vec3::ZERO, "texel {k}");
                    assert_eq!(relit.run.field.radiosity[k], captured.room.radiosity[k]);
                }
            }
        }
    }
}

/// Relights on both engines; returns error against the full solution and energy balance of each.
fn relit_errors(captured: &FurnishedRoom, method: RelightMethod, epsilon: f64) -> [(f64, EnergyBalance); 2] {
    let truth = captured.full_solution(epsilon);
    both_engines(&captured.mesh, &captured.settings.transport).map(|mut engine| {
        let relit = captured.relight(engine.as_mut(), method);
        let error = relative_error(&captured.mesh, &relit.run.field, &truth);
        // The balance counts the recovered reflectance and emission.
        let mut mesh = captured.mesh.clone();
        for (k, texel) in mesh.texels.iter_mut().enumerate() {
            texel.reflectance = relit.surface.reflectance[k];
            texel.emission = relit.surface.emission[k];
        }
        let energy = EnergyBalance::new(&mesh, &relit.run.field, &relit.run.shots);
        (error, energy)
    })
}

#[test]
fn signed_relight_equals_full_solution() {
    for visibility in [Visibility::Rays, ITEM_BUFFER] {
        let objects = bottomless_box(Vec3::ZERO, Vec3::new(0.2, 0.5, 0.8));
        let captured = FurnishedRoom::furnish(relight_settings(visibility), objects, 1e-2);
        for (error, energy) in relit_errors(&captured, RelightMethod::Signed, 1e-6) {
            assert!(error < 1e-3, "{visibility:?}: {error}");
            assert!(energy.imbalance < 1e-4, "{energy:?}");
        }
    }
}

/// The second object is put into the relit room of the first, in either order and on either engine.
#[test]
fn objects_put_in_one_after_the_other_equal_full_solution() {
    let settings = relight_settings(Visibility::Rays);
    let (low, high) = (DVec3::new(0.4, 0.5, 2.6), DVec3::new(0.9, 1.2, 3.2));
    let lamp = box_faces(low, high, false, Vec3::new(0.5, 1.0, 2.0), Vec3::splat(0.6));
    let grey = bottomless_box(Vec3::ZERO, Vec3::splat(0.5));
    for [first, second] in [[&lamp, &grey], [&grey, &lamp]] {
        let one = FurnishedRoom::furnish(settings, first.clone(), 1e-6);
        let mut scene = lit_room();
        scene.faces.extend_from_slice(first);
        let count = scene.faces.len();
        scene.faces.extend_from_slice(second);
        for mut engine in both_engines(&one.mesh, &settings.transport) {
            let relit = one.relight(engine.as_mut(), RelightMethod::Signed);
            let mesh = furnished_mesh(&scene, count, &settings);
            let room = captured_room(&relit.run.field, &mesh);
            let both = FurnishedRoom { settings, mesh, room };
            for (error, energy) in relit_errors(&both, RelightMethod::Signed, 1e-6) {
                assert!(error < 2e-3 && energy.imbalance < 2e-4, "{error} {energy:?}");
            }
        }
    }
}

/// The paper's room with its objects, shot as whole faces like in the paper; unshot light on both sides is well
/// below the bound.
#[test]
fn signed_relight_equals_full_solution_in_paper_room() {
    let mut scene = bundled_scene("paper_room.obj");
    let count = scene.faces.len();
    scene.faces.extend(bundled_scene("paper_objects.obj").faces);
    for visibility in [Visibility::Rays, ITEM_BUFFER] {
        let captured = FurnishedRoom::capture(settings_of([4, 1, 1], visibility, 1e-4), &scene, count, 1e-4);
        for (error, energy) in relit_errors(&captured, RelightMethod::Signed, 1e-4) {
            assert!(error < 1e-3 && energy.imbalance < 1e-4, "{error} {energy:?}");
        }
        let printed = RelightMethod::Paper(MendedFlaws::default());
        let [cpu, gpu] = relit_errors(&captured, printed, 1e-4);
        for (error, energy) in [&cpu, &gpu] {
            assert!(*error > 0.05 && energy.imbalance > 0.01, "{error} {energy:?}");
        }
        assert!(abs_diff_eq!(cpu.0, gpu.0, epsilon = 0.01), "{} {}", cpu.0, gpu.0);
    }
}

#[test]
fn black_object_only_darkens() {
    for visibility in [Visibility::Rays, ITEM_BUFFER] {
        let mut settings = relight_settings(visibility);
        settings.meshing.patches = 4;
        // The object covers one whole patch of the floor. Light of a partly covered patch would leave from its open
        // points, whose noise may brighten texels.
        let (low, high) = (DVec3::new(1.5, 0.0, 2.0), DVec3::new(2.25, 0.8, 3.0));
        let objects = box_faces(low, high, false, Vec3::ZERO, Vec3::ZERO);
        let captured = FurnishedRoom::furnish(settings, objects, 1e-6);
        let mesh = &captured.mesh;
        for mut engine in both_engines(mesh, &settings.transport) {
            let relit = captured.relight(engine.as_mut(), RelightMethod::Signed);
            // Unshot light may fall anywhere: at most all of it on one texel.
            let unshot = relit.run.unshot_fraction() * f64::from(relit.run.emitted);
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
    let settings = settings_of([4, 2, 16], Visibility::Rays, 1e-4);
    let mut scene = lit_room();
    let count = scene.faces.len();
    scene.faces[0].emission = Vec3::splat(2.0);
    scene.faces.extend(bottomless_box(Vec3::ZERO, Vec3::splat(0.5)));
    let captured = FurnishedRoom::capture(settings, &scene, count, 1e-5);
    let mut patches = captured.mesh.patches.iter();
    assert!(patches.any(|c| c.open_share < 1.0 && c.open_share > 0.0 && c.room_open_share == 1.0));
    for (error, energy) in relit_errors(&captured, RelightMethod::Signed, 1e-6) {
        assert!(error < 1e-3 && energy.imbalance < 1e-4, "{error} {energy:?}");
        assert!(energy.share_of_emitted(energy.escaped) > 0.01, "{energy:?}");
    }
}

#[test]
fn reflectance_and_emission_are_recovered_from_captured_light() {
    let settings = settings_of([8, 8, 4], Visibility::Rays, 1e-4);
    let mut captured = FurnishedRoom::furnish(settings, Vec::new(), 1e-6);
    captured.room.residual.fill(Vec4::ZERO);
    captured.room.reflectance = None;
    let mut engine = CpuSolver::new(&captured.mesh, &settings.transport);
    let relit = captured.relight(&mut engine, RelightMethod::Signed);
    let surface = &relit.surface;
    for (k, texel) in captured.mesh.texels.iter().enumerate() {
        // The ceiling is the lamp.
        assert_eq!(surface.emitters.contains(&(k as u32)), texel.face == 1, "{k}");
        let h = relit.run.field.irradiance[k].truncate();
        let b = surface.emission[k] + surface.reflectance[k] * h;
        let apart = (b - captured.room.radiosity[k].truncate()).abs().max_element();
        assert!(apart <= 4.0 * f32::EPSILON * b.max_element(), "{k}");
        let error = (surface.reflectance[k] - texel.reflectance).abs().max_element();
        assert!(texel.face == 1 || error < 1e-4, "{k}: {error}");
    }
}
