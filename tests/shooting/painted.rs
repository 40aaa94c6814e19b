//! Painted faces: a checked floor equals separate faces on all solvers, and energy balances on it.

use common::energy::EnergyBalance;
use common::mesh::Mesh;
use common::paint::{Coat, Paint, PaintCorner, TexturePicture, WrapMode, WrappedTexture};
use common::scene::{Face, Scene};
use common::settings::Iteration;
use common::shooting::SolveRun;
use cpu::dense::Matrix;
use cpu::hierarchy::solver::{ErrorBudget, solve_scene};
use glam::{DVec2, DVec3, Vec3};
use radiosity_tests::dense::solve_matrix;
use radiosity_tests::engines::{ENGINE_KINDS, EngineKind, engine_settings, mesh_of, solve_by_schedule};
use radiosity_tests::{lit_room, named_scene};
use std::ops::ControlFlow;
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

/// Returns the scene with a separate face for each check, and the resolutions of its faces.
fn split(whole: &Scene) -> (Scene, Vec<[u32; 2]>) {
    let (mut faces, mut resolutions) = (Vec::new(), Vec::new());
    for (f, face) in whole.faces.iter().enumerate() {
        if face.paint.is_none() {
            faces.push(face.clone());
            resolutions.push([CHECKS; 2]);
            continue;
        }
        for k in 0..CHECKS * CHECKS {
            let (i, j) = (k % CHECKS, k / CHECKS);
            let corners = common::texel::texel_outline(face, [CHECKS; 2], k).padded_corners();
            let light = std::f32::consts::PI * ((i + j) % 2) as f32;
            let [emission, reflectance] = match f {
                0 => [Vec3::ZERO, rho(i, j)],
                _ => [Vec3::splat(light), face.reflectance],
            };
            faces.push(Face::quad("check", corners, emission, reflectance));
            resolutions.push([1; 2]);
        }
    }
    (named_scene("split checks", faces), resolutions)
}

/// Returns B of each texel by the dense matrix, in face order.
fn exact(scene: &Scene, mesh: &Mesh) -> Vec<Vec3> {
    let (matrix, _) = Matrix::assemble(scene, mesh, &mut |_, _| ControlFlow::Continue(())).unwrap();
    let radiosity = solve_matrix(mesh, &matrix).radiosity;
    let order = mesh.texels_in_face_order().into_iter();
    order.map(|k| radiosity[k].as_vec3()).collect()
}

fn run(scene: &Scene, kind: &EngineKind, epsilon: f64) -> (Mesh, SolveRun) {
    let mut settings = engine_settings();
    settings.schedule.epsilon = epsilon;
    settings.schedule.iteration = Iteration::Cg;
    let mesh = mesh_of(scene);
    let run = solve_by_schedule(
        &mut *kind.fresh_engine(&mesh, &settings, &[]),
        &mesh,
        &settings.schedule,
    );
    (mesh, run)
}

/// Returns the RMS of the difference over the RMS of `b`.
fn rms(a: impl Iterator<Item = Vec3>, b: &[Vec3]) -> f32 {
    let off: f32 = a.zip(b).map(|(a, b)| (a - *b).length_squared()).sum();
    (off / b.iter().map(|b| b.length_squared()).sum::<f32>()).sqrt()
}

#[test]
fn painted_checks_equal_separate_faces() {
    let whole = painted();
    let mesh = Mesh::uniform(&whole, CHECKS, 1).unwrap();
    let (parts, resolutions) = split(&whole);
    let other = Mesh::new(&parts, &resolutions, 1).unwrap();
    let (a, b) = (mesh.texels_in_face_order(), other.texels_in_face_order());
    for (a, b) in a.iter().zip(&b) {
        let (a, b) = (&mesh.texels[*a], &other.texels[*b]);
        assert!((a.reflectance - b.reflectance).length() < 1e-6, "{a:?} {b:?}");
        assert!((a.emission - b.emission).length() < 1e-6, "{a:?} {b:?}");
    }
    let expected = exact(&parts, &other);
    let off = rms(exact(&whole, &mesh).into_iter(), &expected);
    assert!(off < 1e-5, "{off}");
}

#[test]
fn hierarchical_solve_of_painted_checks_equals_exact_solution() {
    let whole = painted();
    let mesh = Mesh::uniform(&whole, 2 * CHECKS, 1).unwrap();
    let go_on = &mut |_| ControlFlow::Continue(());
    let outcome = solve_scene(&whole, &mesh, &[], ErrorBudget::for_error(0.005), go_on).unwrap();
    let texels = mesh.texels.iter().zip(&outcome.irradiance);
    let found: Vec<Vec3> = texels.map(|(t, h)| t.emission + t.reflectance * *h).collect();
    let order = mesh.texels_in_face_order();
    let off = rms(order.iter().map(|k| found[*k]), &exact(&whole, &mesh));
    assert!(off < 0.01, "{off}");
}

/// On every engine the energy balances, and by rays CPU and GPU agree.
#[test]
fn engines_agree_on_patches_of_uneven_reflectance() {
    let whole = painted();
    let fields = ENGINE_KINDS.map(|kind| {
        let (mesh, run) = run(&whole, &kind, 1e-4);
        let energy = EnergyBalance::new(&mesh, &run.field, &run.shots);
        assert!(run.converged, "{}", kind.name);
        assert!(energy.imbalance < 2e-6, "{}: {energy:?}", kind.name);
        assert!(energy.share_of_emitted(energy.unshot).abs() < 1e-4, "{}", kind.name);
        run.field
    });
    let [cpu, _, _, gpu] = fields.map(|field| Vec::from_iter(field.radiosity.iter().map(|b| b.truncate())));
    let off = rms(cpu.into_iter(), &gpu);
    assert!(off < 1e-5, "{off}");
}
