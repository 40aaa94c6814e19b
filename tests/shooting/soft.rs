//! Soft visibility: samples on patch and texel, equal on every engine; rays on the GPU.

use approx::abs_diff_eq;
use common::cover::sampled_mesh;
use common::mesh::Mesh;
use common::passes::Engine;
use common::scene::{Face, Scene};
use common::settings::{Meshing, Schedule, Settings, Transport, Visibility};
use common::shooting::{RadiosityField, Shoot};
use cpu::CpuSolver;
use glam::{DVec3, Vec3};
use gpu::{GpuSolver, ShaderFault};
use radiosity_tests::engines::{item_buffer, open_gpu, shoot_freely};
use radiosity_tests::shader_faults::{assert_faults_noticed, shader_fault};
use radiosity_tests::{box_faces, box_in_room, furnace, lit_room, named_scene, paper_room};

fn settings(visibility: Visibility) -> Settings {
    Settings {
        meshing: Meshing {
            texels: 4,
            patches: 2,
            samples: 7,
        },
        transport: Transport {
            visibility,
            ..Transport::default()
        },
        schedule: Schedule {
            epsilon: 0.02,
            ..Schedule::default()
        },
        ..Settings::default()
    }
}

fn mesh(scene: &Scene, settings: &Settings) -> Mesh {
    sampled_mesh(scene, &settings.meshing).unwrap()
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

fn scenes() -> Vec<Scene> {
    vec![box_in_room(), lit_room(), paper_room(), odd_shapes()]
}

/// Counts the texels that are not bit-identical, and all texels.
fn differing(a: &RadiosityField, b: &RadiosityField) -> (usize, usize) {
    let pairs = a.radiosity.iter().zip(&b.radiosity);
    (pairs.filter(|(a, b)| a != b).count(), a.radiosity.len())
}

/// Returns the largest difference over the largest value.
fn distance(a: &RadiosityField, b: &RadiosityField) -> f32 {
    let size = b.radiosity.iter().map(|v| v.max_element()).fold(0.0, f32::max);
    let pairs = a.radiosity.iter().zip(&b.radiosity);
    pairs.map(|(a, b)| (*a - *b).abs().max_element()).fold(0.0, f32::max) / size
}

/// Relative rounding of f32 over a few hundred shots, with a few roundings of each of a texel's sums.
const ROUNDING: f32 = 1e-4;

#[test]
fn gpu_and_cpu_rays_agree_on_visibility() {
    let gpu = open_gpu();
    for scene in scenes() {
        let mut settings = settings(Visibility::Rays);
        settings.meshing.samples = 1;
        let mesh = mesh(&scene, &settings);
        let mut cpu = CpuSolver::new(&mesh, &settings.transport);
        let mut gpu = GpuSolver::new(&gpu, &mesh, &settings.transport).unwrap();
        let (mut lit, mut hidden) = (0, 0);
        for patch in 0..mesh.patches.len() as u32 {
            gpu.shoot(patch).unwrap();
            let seen = gpu.read_irradiance().unwrap();
            for (k, link) in cpu.link_row(patch).unwrap().links.iter().enumerate() {
                assert_eq!(seen[k].w > 0.0, *link > 0.0, "{} {patch} {k}", scene.name);
                lit += usize::from(*link > 0.0);
                hidden += usize::from(*link == 0.0);
            }
        }
        assert!(lit > 0 && hidden > 0, "{}: nothing was compared", scene.name);
    }
}

#[test]
fn soft_visibility_agrees_on_all_engines() {
    let gpu = open_gpu();
    for scene in [box_in_room(), odd_shapes()] {
        for visibility in [Visibility::Rays, item_buffer(128)] {
            let settings = settings(visibility);
            let mesh = mesh(&scene, &settings);
            let cpu = shoot_freely(&mut CpuSolver::new(&mesh, &settings.transport), &settings.schedule);
            let log = cpu.shooter_log();
            let mut engine = GpuSolver::new(&gpu, &mesh, &settings.transport).unwrap();
            let gpu = common::shooting::replay_log(&mut engine, &log).unwrap();
            // The twin's raster may differ in pixels on an outline: one sample of seven.
            let bound = if visibility == Visibility::Rays { ROUNDING } else { 0.02 };
            let error = distance(&gpu.field, &cpu.field);
            let (bits, all) = differing(&gpu.field, &cpu.field);
            println!("{} {visibility:?}: {error:.1e}, {bits} of {all} differ", scene.name);
            assert!(error <= bound, "{} {visibility:?}: {error}", scene.name);
        }
    }
}

#[test]
fn comparison_detects_faults_in_samples() {
    let faults = [
        shader_fault(
            "sampling",
            "sample_coordinate(s, STEP_V, second)",
            "sample_coordinate(s, STEP_U, second)",
        ),
        shader_fault("texel_point", "uv = vec2f(1.0 - uv.x, 1.0 - uv.y);", ""),
        shader_fault(
            "texel_point",
            "(place.y + uv.y) / size.y;\n    let low",
            "(place.y + uv.x) / size.y;\n    let low",
        ),
        shader_fault(
            "link",
            "sum = Sums(sums[at].x, sums[at].y, sums[at].z, sums[at].w);",
            "",
        ),
        shader_fault(
            "intersect",
            "hit.t > 0.0 && hit.t < SEGMENT_END_FRACTION * end",
            "hit.t < SEGMENT_END_FRACTION * end",
        ),
        shader_fault(
            "bvh",
            "siblings.y & 0xffu & ((1u << child) - 1u)",
            "siblings.y & 0xffu & (1u << child)",
        ),
        shader_fault(
            "view",
            "shots[slot].next = min(shots[slot].next + params.step, params.samples);",
            "shots[slot].next = params.samples;",
        ),
    ];
    let gpu = open_gpu();
    assert_faults_noticed(faults, |fault| {
        let by_item_buffer = fault.file == "link" || fault.file == "view";
        let visibility = if by_item_buffer {
            item_buffer(128)
        } else {
            Visibility::Rays
        };
        let scene = if fault.file == "bvh" {
            paper_room()
        } else {
            odd_shapes()
        };
        let settings = settings(visibility);
        let mesh = mesh(&scene, &settings);
        // The lamps are last; they shoot first, and every patch of the small scene shoots twice.
        let once = (0..mesh.patches.len() as u32).rev().take(60);
        let log: Vec<u32> = once.clone().chain(once).collect();
        let run = |faults: &[ShaderFault]| {
            let mut engine = GpuSolver::with_faults(&gpu, &mesh, &settings.transport, faults).unwrap();
            common::shooting::replay_log(&mut engine, &log).unwrap().field
        };
        let error = distance(&run(&[fault]), &run(&[]));
        println!("{fault:?}: {error}");
        error > ROUNDING
    });
}

#[test]
fn half_width_blocker_halves_the_irradiance() {
    // Facing unit squares, a shade half-way between them over x < ½. Lamp and floor are mirror
    // images of themselves in x = ½: half of the light between them crosses the shade.
    let p = DVec3::new;
    let white = Vec3::splat(0.5);
    let floor = [p(0.0, 0.0, 0.0), p(0.0, 0.0, 1.0), p(1.0, 0.0, 1.0), p(1.0, 0.0, 0.0)];
    let lamp = [p(0.0, 1.0, 0.0), p(1.0, 1.0, 0.0), p(1.0, 1.0, 1.0), p(0.0, 1.0, 1.0)];
    let shade = [p(0.0, 0.5, 0.0), p(0.5, 0.5, 0.0), p(0.5, 0.5, 1.0), p(0.0, 0.5, 1.0)];
    let faces = vec![
        Face::quad("floor", floor, Vec3::ZERO, Vec3::ZERO),
        Face::quad("lamp", lamp, Vec3::ONE, Vec3::ZERO),
        Face::quad("shade", shade, Vec3::ZERO, white),
    ];
    let settings = Settings {
        meshing: Meshing {
            texels: 8,
            patches: 1,
            samples: 1024,
        },
        schedule: Schedule {
            epsilon: 0.5,
            ..Schedule::default()
        },
        ..Settings::default()
    };
    let mesh = mesh(&named_scene("shade", faces), &settings);
    let run = shoot_freely(&mut CpuSolver::new(&mesh, &settings.transport), &settings.schedule);
    let floor: Vec<f64> = (0..mesh.texels.len())
        .filter(|k| mesh.texels[*k].face == 0)
        .map(|k| f64::from(run.field.irradiance[k].x))
        .collect();
    let open: f64 = 0.1998248957;
    let mean = floor.iter().sum::<f64>() / floor.len() as f64;
    // 64 texels × 1024 binary samples, evenly distributed: an error of a few in a thousand.
    assert!(abs_diff_eq!(mean / (open / 2.0), 1.0, epsilon = 0.005), "{mean}");
}

#[test]
fn box_on_furnace_floor_leaves_open_texels_exact() {
    // A box on the floor of a furnace: covered texels receive nothing, and the floor reflects light from its
    // open part only: open texels have B = E/(1 − ρ), on average.
    let (rho, side) = (0.5f32, 0.25);
    let mut faces = furnace(rho).faces;
    let (low, high) = (
        DVec3::new(0.375, 0.0, 0.375),
        DVec3::new(0.375 + side, 0.3, 0.375 + side),
    );
    for face in box_faces(low, high, false, Vec3::ONE, Vec3::splat(rho)) {
        if face.name != "floor" {
            faces.push(face);
        }
    }
    let settings = Settings {
        meshing: Meshing {
            texels: 8,
            patches: 8,
            samples: 16,
        },
        schedule: Schedule {
            epsilon: 1e-3,
            ..Schedule::default()
        },
        ..Settings::default()
    };
    let mesh = mesh(&named_scene("box on the floor", faces), &settings);
    let run = shoot_freely(&mut CpuSolver::new(&mesh, &settings.transport), &settings.schedule);
    let exact = 1.0 / (1.0 - rho);
    let (mut covered, mut square, mut count) = (0, 0.0, 0);
    for (texel, b) in mesh.texels.iter().zip(&run.field.radiosity) {
        let p = texel.position * mesh.unit as f32 + Vec3::splat(0.5);
        let inside = |x: f32| x > 0.375 && x < 0.375 + side as f32;
        if texel.face == 0 && inside(p.x) && inside(p.z) {
            assert_eq!(b.x, 1.0, "a covered texel keeps its emission only");
            covered += 1;
        } else {
            square += (b.x / exact - 1.0).powi(2);
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
    let gpu = open_gpu();
    let mesh = mesh(&lit_room(), &settings);
    let engines: [Box<dyn Engine>; 2] = [
        Box::new(CpuSolver::new(&mesh, &settings.transport)),
        Box::new(GpuSolver::new(&gpu, &mesh, &settings.transport).unwrap()),
    ];
    for mut engine in engines {
        for shot in shoot_freely(engine.as_mut(), &settings.schedule).shots {
            let sum = shot.form_factor_sum + shot.escaped;
            assert!(abs_diff_eq!(sum, 1.0, epsilon = 4.0 * f32::EPSILON), "{shot:?}");
        }
    }
}
