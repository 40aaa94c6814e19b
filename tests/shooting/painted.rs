//! Painted faces: the hierarchical solver against the dense one, and energy on all engines.

use common::energy::EnergyBalance;
use common::scene::Scene;
use common::settings::Iteration;
use glam::Vec3;
use radiosity_tests::engines::{ENGINE_KINDS, engine_settings, mesh_of, solve_by_schedule};
use radiosity_tests::lit_room;
use radiosity_tests::painted::{paint_face, picture_coat};
use radiosity_tests::relighting::relative_error;
use radiosity_tests::solutions::{dense_truth_on, error_against, solve_to_error};

/// Checks per side.
const CHECKS: u32 = 6;

/// Returns the lit room with a checked floor, and a ceiling that emits in half of its checks.
fn painted_room() -> Scene {
    let is_odd = |k: u32| (k + k / CHECKS) % 2 == 1;
    let colour = |k| {
        if is_odd(k) {
            Vec3::new(0.1, 0.05, 0.6)
        } else {
            Vec3::new(0.8, 0.5, 0.1)
        }
    };
    let light = |k| if is_odd(k) { Vec3::ONE } else { Vec3::ZERO };
    let coat = |pixel: &dyn Fn(u32) -> Vec3| {
        let pixels: Vec<Vec3> = (0..CHECKS * CHECKS).map(pixel).collect();
        Some(picture_coat([CHECKS as usize; 2], &pixels))
    };
    let mut room = lit_room();
    room.faces[0] = paint_face(room.faces[0].clone(), [coat(&colour), None]);
    room.faces[1] = paint_face(room.faces[1].clone(), [None, coat(&light)]);
    room
}

#[test]
fn hierarchical_solve_of_painted_checks_equals_exact_solution() {
    let whole = painted_room();
    let answer = solve_to_error(&whole, 0.005, 2 * CHECKS);
    let off = error_against(&whole, &answer, &dense_truth_on(&whole, 2 * CHECKS));
    assert!(off < 0.01, "{off}");
}

/// On every engine the energy balances, and by rays CPU and GPU agree.
#[test]
fn engines_agree_on_patches_of_uneven_reflectance() {
    let mesh = mesh_of(&painted_room());
    let mut settings = engine_settings();
    settings.schedule.epsilon = 1e-4;
    settings.schedule.iteration = Iteration::Cg;
    let [cpu, _, _, gpu] = ENGINE_KINDS.map(|kind| {
        let mut engine = kind.fresh_engine(&mesh, &settings, &[]);
        let run = solve_by_schedule(engine.as_mut(), &mesh, &settings.schedule);
        let energy = EnergyBalance::new(&mesh, &run.field, &run.shots);
        assert!(run.converged, "{}", kind.name);
        assert!(energy.imbalance < 2e-6, "{}: {energy:?}", kind.name);
        assert!(energy.share_of_emitted(energy.unshot).abs() < 1e-4, "{}", kind.name);
        run.field
    });
    let off = relative_error(&mesh, &gpu, &cpu);
    assert!(off < 1e-5, "{off}");
}
