//! Soft visibility: samples on patch and texel, equal on every engine; rays on the GPU.

use approx::abs_diff_eq;
use common::scene::{Face, Scene};
use common::settings::{Settings, Visibility};
use common::shooting::{RadiosityField, replay_log};
use glam::{DVec3, Vec3};
use gpu::ShaderFault;
use radiosity_tests::engines::{
    both_engines, gpu_solver, item_buffer, mesh_scene, settings_of, shared_gpu, shoot_freely, shoot_on_cpu,
};
use radiosity_tests::factor_cases::rectangle;
use radiosity_tests::shader_faults::assert_faults_noticed;
use radiosity_tests::{box_faces, box_in_room, furnace, lit_room, named_scene, paper_room};

fn settings(visibility: Visibility) -> Settings {
    settings_of([4, 2, 7], visibility, 0.02)
}

/// Returns a triangle, a trapezoid and a box: every kind of texel, in an open scene.
fn odd_shapes() -> Scene {
    let p = DVec3::new;
    let white = Vec3::splat(0.6);
    let mut faces = box_faces(p(0.2, 0.1, 0.2), p(0.5, 0.4, 0.6), false, Vec3::ZERO, white);
    let trapezoid = [
        p(-1.0, 0.0, -1.0),
        p(-0.5, 0.0, 2.0),
        p(1.5, 0.0, 1.0),
        p(2.0, 0.0, -1.0),
    ];
    faces.push(Face::quad("floor", trapezoid, Vec3::ZERO, white));
    let lamp = [p(0.0, 1.0, 0.0), p(1.0, 1.2, 0.0), p(0.0, 1.0, 1.0)];
    faces.push(Face::triangle("lamp", lamp, Vec3::new(3.0, 2.0, 1.0), white));
    named_scene("odd shapes", faces)
}

/// Returns the largest difference over the largest value.
fn distance(a: &RadiosityField, b: &RadiosityField) -> f32 {
    let size = b.radiosity.iter().map(|v| v.max_element()).fold(0.0, f32::max);
    let pairs = a.radiosity.iter().zip(&b.radiosity);
    pairs.map(|(a, b)| (*a - *b).abs().max_element()).fold(0.0, f32::max) / size
}

/// Relative rounding of f32 over a few hundred shots, with a few roundings of each of a texel's sums.
const ROUNDING: f32 = 1e-4;

/// The same shots on CPU and GPU; links by rays are bit-identical where the adapter does not fuse products and sums.
#[test]
fn soft_visibility_agrees_on_all_engines() {
    for (scene, visibility) in [
        (box_in_room(), Visibility::Rays),
        (odd_shapes(), Visibility::Rays),
        (paper_room(), Visibility::Rays),
        (box_in_room(), item_buffer(128)),
        (odd_shapes(), item_buffer(128)),
    ] {
        let settings = settings(visibility);
        let mesh = mesh_scene(&scene, &settings);
        let cpu = shoot_on_cpu(&mesh, &settings);
        let mut engine = gpu_solver(&mesh, &settings.transport, &[]);
        let gpu = replay_log(&mut engine, &cpu.shooter_log()).unwrap();
        // The twin's raster may differ in pixels on an outline: one sample of seven.
        let bound = match visibility {
            Visibility::Rays if shared_gpu().line.software => 0.0,
            Visibility::Rays => ROUNDING,
            Visibility::ItemBuffer(_) => 0.02,
        };
        let error = distance(&gpu.field, &cpu.field);
        assert!(error <= bound, "{} {visibility:?}: {error}", scene.name);
    }
}

/// Returns the field of a log in which every patch of a small scene shoots twice; lamps are last, they shoot first.
fn replay_twice(scene: &Scene, settings: &Settings, faults: &[ShaderFault]) -> RadiosityField {
    let mesh = mesh_scene(scene, settings);
    let once = (0..mesh.patches.len() as u32).rev().take(60);
    let log: Vec<u32> = once.clone().chain(once).collect();
    let mut engine = gpu_solver(&mesh, &settings.transport, faults);
    replay_log(&mut engine, &log).unwrap().field
}

#[test]
fn comparison_detects_faults_in_samples() {
    for (check, visibility, scene) in [
        ("samples by rays", Visibility::Rays, odd_shapes()),
        ("samples by pixels", item_buffer(128), odd_shapes()),
        ("boxes of rays", Visibility::Rays, paper_room()),
    ] {
        let settings = settings(visibility);
        let expected = replay_twice(&scene, &settings, &[]);
        assert_faults_noticed(check, |faults| {
            let error = distance(&replay_twice(&scene, &settings, faults), &expected);
            Vec::from_iter((error > ROUNDING).then(|| format!("off by {error:.1e}")))
        });
    }
}

#[test]
fn half_width_blocker_halves_the_irradiance() {
    // Facing unit squares, a shade half-way between them over x < ½. Lamp and floor are mirror
    // images of themselves in x = ½: half of the light between them crosses the shade.
    let floor = rectangle([0.0; 3], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]);
    let lamp = rectangle([0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]);
    let shade = rectangle([0.0, 0.5, 0.0], [0.5, 0.0, 0.0], [0.0, 0.0, 1.0]);
    let faces = vec![
        Face::quad("floor", floor, Vec3::ZERO, Vec3::ZERO),
        Face::quad("lamp", lamp, Vec3::ONE, Vec3::ZERO),
        Face::quad("shade", shade, Vec3::ZERO, Vec3::splat(0.5)),
    ];
    let settings = settings_of([8, 1, 1024], Visibility::Rays, 0.5);
    let mesh = mesh_scene(&named_scene("shade", faces), &settings);
    let run = shoot_on_cpu(&mesh, &settings);
    let texels = mesh.texels.iter().zip(&run.field.irradiance);
    let floor = texels.filter(|(texel, _)| texel.face == 0);
    let sum: f64 = floor.map(|(_, h)| f64::from(h.x)).sum();
    let open: f64 = 0.1998248957;
    // 64 texels × 1024 binary samples, evenly distributed: an error of a few in a thousand.
    let ratio = sum / 64.0 / (open / 2.0);
    assert!(abs_diff_eq!(ratio, 1.0, epsilon = 0.005), "{ratio}");
}

/// A box on the floor of a furnace: covered texels receive nothing, and the floor reflects light from its
/// open part only: open texels have B = E/(1 − ρ), on average.
#[test]
fn box_on_furnace_floor_leaves_open_texels_exact() {
    let (rho, low, high) = (0.5f32, 0.375, 0.625);
    let mut faces = furnace(rho).faces;
    let body = box_faces(
        DVec3::new(low, 0.0, low),
        DVec3::new(high, 0.3, high),
        false,
        Vec3::ONE,
        Vec3::splat(rho),
    );
    faces.extend(body.into_iter().filter(|face| face.name != "floor"));
    let settings = settings_of([8, 8, 16], Visibility::Rays, 1e-3);
    let mesh = mesh_scene(&named_scene("box on the floor", faces), &settings);
    let run = shoot_on_cpu(&mesh, &settings);
    let (mut covered, mut square, mut count) = (0, 0.0, 0);
    for (texel, b) in mesh.texels.iter().zip(&run.field.radiosity) {
        let p = texel.position.as_dvec3() * mesh.unit + 0.5;
        let inside = |x: f64| x > low && x < high;
        if texel.face == 0 && inside(p.x) && inside(p.z) {
            assert_eq!(b.x, 1.0, "a covered texel keeps its emission only");
            covered += 1;
        } else {
            square += (b.x * (1.0 - rho) - 1.0).powi(2);
            count += 1;
        }
    }
    assert_eq!(covered, 4);
    let rms = (square / count as f32).sqrt();
    assert!(rms < 0.02, "{rms}");
}

#[test]
fn conserve_scales_every_shot_to_closure() {
    let mut settings = settings(Visibility::Rays);
    settings.transport.conserve = true;
    let mesh = mesh_scene(&lit_room(), &settings);
    for mut engine in both_engines(&mesh, &settings.transport) {
        for shot in shoot_freely(engine.as_mut(), &settings.schedule).shots {
            let sum = shot.form_factor_sum + shot.escaped;
            assert!(abs_diff_eq!(sum, 1.0, epsilon = 4.0 * f32::EPSILON), "{shot:?}");
        }
    }
}
