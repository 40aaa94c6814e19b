//! Painted faces: the hierarchical solver against the dense one, and energy on all engines.

use common::energy::EnergyBalance;
use common::paint::{Coat, Paint, PaintCorner, TexturePicture, WrapMode, WrappedTexture};
use common::scene::Scene;
use common::settings::Iteration;
use glam::{DVec2, DVec3, Vec3};
use radiosity_tests::engines::{ENGINE_KINDS, engine_settings, mesh_of, solve_by_schedule};
use radiosity_tests::lit_room;
use radiosity_tests::relighting::relative_error;
use radiosity_tests::solutions::{dense_truth_on, error_against, solve_to_error};
use std::sync::Arc;

/// Checks per side.
const CHECKS: u32 = 6;

fn rho(i: u32, j: u32) -> Vec3 {
    match (i + j) % 2 {
        0 => Vec3::new(0.8, 0.5, 0.1),
        _ => Vec3::new(0.1, 0.05, 0.6),
    }
}

/// Returns the lit room with a checked floor, and a ceiling that emits in half of its checks.
fn painted() -> Scene {
    let mut room = lit_room();
    let places = [[0., 0.], [1., 0.], [1., 1.], [0., 1.]].map(DVec2::from);
    let corners = places.map(|place| PaintCorner {
        places: [place; 2],
        colour: DVec3::ONE,
    });
    let coat = |pixel: fn(u32, u32) -> Vec3| {
        let pixels = (0..CHECKS * CHECKS).map(|k| pixel(k % CHECKS, k / CHECKS).to_array());
        let size = [CHECKS as usize; 2];
        Coat {
            factor: DVec3::ONE,
            texture: Some(WrappedTexture {
                picture: Arc::new(TexturePicture::new(size, pixels.collect())),
                wrap: [WrapMode::Clamp; 2],
            }),
            coloured: false,
        }
    };
    let glow = |i: u32, j: u32| Vec3::splat(((i + j) % 2) as f32);
    let coats = [[Some(coat(rho)), None], [None, Some(coat(glow))]];
    for (face, coats) in room.faces.iter_mut().zip(coats) {
        face.paint = Some(Arc::new(Paint {
            corners,
            odd: false,
            coats,
        }));
        let [reflectance, emission] = face.mean_surface(face.outline());
        (face.reflectance, face.emission) = (reflectance, emission);
    }
    room.name = "checks".into();
    room
}

#[test]
fn hierarchical_solve_of_painted_checks_equals_exact_solution() {
    let whole = painted();
    let answer = solve_to_error(&whole, 0.005, 2 * CHECKS);
    let off = error_against(&whole, &answer, &dense_truth_on(&whole, 2 * CHECKS));
    assert!(off < 0.01, "{off}");
}

/// On every engine the energy balances, and by rays CPU and GPU agree.
#[test]
fn engines_agree_on_patches_of_uneven_reflectance() {
    let mesh = mesh_of(&painted());
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
