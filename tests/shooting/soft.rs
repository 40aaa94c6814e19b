//! Soft visibility: samples on cell and texel, the same on every engine; rays on the GPU.

use approx::abs_diff_eq;
use common::cover::sampled;
use common::mesh::Mesh;
use common::passes::Engine;
use common::scene::{Face, Scene};
use common::settings::{Meshing, Schedule, Settings, Transport, Visibility};
use common::shooting::{Field, Shoot};
use cpu::CpuSolver;
use glam::{DVec3, Vec3};
use gpu::{Fault, GpuSolver};
use radiosity_tests::engines::{drawn, free, gpu};
use radiosity_tests::{box_in_room, furnace, lit_room, paper_room, room, scene};

fn settings(visibility: Visibility) -> Settings {
    Settings {
        meshing: Meshing {
            texels: 4,
            cells: 2,
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
    sampled(scene, &settings.meshing).unwrap()
}

/// A triangle, a trapezoid and a box: every kind of texel, in the open.
fn odd_shapes() -> Scene {
    let p = DVec3::new;
    let white = Vec3::splat(0.6);
    let mut faces = room(p(0.2, 0.1, 0.2), p(0.5, 0.4, 0.6), false, Vec3::ZERO, white);
    let trapezoid = [
        p(-1.0, 0.0, -1.0),
        p(-0.5, 0.0, 2.0),
        p(1.5, 0.0, 1.0),
        p(2.0, 0.0, -1.0),
    ];
    faces.push(Face::quad("floor", trapezoid, Vec3::ZERO, white));
    let lamp = [p(0.0, 1.0, 0.0), p(1.0, 1.2, 0.0), p(0.0, 1.0, 1.0)];
    faces.push(Face::triangle(
        "lamp",
        lamp,
        Vec3::new(3.0, 2.0, 1.0),
        white,
    ));
    scene("odd shapes", faces)
}

fn scenes() -> Vec<Scene> {
    vec![box_in_room(), lit_room(), paper_room(), odd_shapes()]
}

/// Texels that are not equal bit for bit, and all.
fn differing(a: &Field, b: &Field) -> (usize, usize) {
    let pairs = a.radiosity.iter().zip(&b.radiosity);
    (pairs.filter(|(a, b)| a != b).count(), a.radiosity.len())
}

/// The largest difference over the largest value.
fn distance(a: &Field, b: &Field) -> f32 {
    let size = b
        .radiosity
        .iter()
        .map(|v| v.max_element())
        .fold(0.0, f32::max);
    let pairs = a.radiosity.iter().zip(&b.radiosity);
    pairs
        .map(|(a, b)| (*a - *b).abs().max_element())
        .fold(0.0, f32::max)
        / size
}

/// f32 over a few hundred shots, each a few roundings on each of a texel's sums.
const ROUNDING: f32 = 1e-4;

#[test]
fn the_gpu_asks_the_rays_of_the_cpu() {
    let gpu = gpu();
    for scene in scenes() {
        let mut settings = settings(Visibility::Rays);
        settings.meshing.samples = 1;
        let mesh = mesh(&scene, &settings);
        let mut cpu = CpuSolver::new(&mesh, &settings.transport);
        let mut gpu = GpuSolver::new(&gpu, &mesh, &settings.transport).unwrap();
        let (mut lit, mut hidden) = (0, 0);
        for cell in 0..mesh.cells.len() as u32 {
            gpu.shoot(cell).unwrap();
            let seen = gpu.irradiance().unwrap();
            for (k, link) in cpu.row(cell).unwrap().links.iter().enumerate() {
                assert_eq!(seen[k].w > 0.0, *link > 0.0, "{} {cell} {k}", scene.name);
                lit += usize::from(*link > 0.0);
                hidden += usize::from(*link == 0.0);
            }
        }
        assert!(
            lit > 0 && hidden > 0,
            "{}: nothing was compared",
            scene.name
        );
    }
}

#[test]
fn samples_are_the_same_on_every_engine() {
    let gpu = gpu();
    for scene in [box_in_room(), odd_shapes()] {
        for visibility in [Visibility::Rays, drawn(128)] {
            let settings = settings(visibility);
            let mesh = mesh(&scene, &settings);
            let cpu = free(
                &mut CpuSolver::new(&mesh, &settings.transport),
                &settings.schedule,
            );
            let log = cpu.cells();
            let mut engine = GpuSolver::new(&gpu, &mesh, &settings.transport).unwrap();
            let gpu = common::shooting::replay(&mut engine, &log).unwrap();
            // The twin's raster may differ in pixels on an outline: a sample of seven.
            let bound = if visibility == Visibility::Rays {
                ROUNDING
            } else {
                0.02
            };
            let error = distance(&gpu.field, &cpu.field);
            let (bits, all) = differing(&gpu.field, &cpu.field);
            println!(
                "{} {visibility:?}: {error:.1e}, {bits} of {all} differ",
                scene.name
            );
            assert!(error <= bound, "{} {visibility:?}: {error}", scene.name);
        }
    }
}

#[test]
fn a_wrong_sample_is_noticed() {
    let fault = |file, from, to| Fault { file, from, to };
    let faults = [
        fault(
            "sampling",
            "coordinate(s, STEP_V, second)",
            "coordinate(s, STEP_U, second)",
        ),
        fault("texel_point", "uv = vec2f(1.0 - uv.x, 1.0 - uv.y);", ""),
        fault(
            "texel_point",
            "(place.y + uv.y) / size.y;\n    let low",
            "(place.y + uv.x) / size.y;\n    let low",
        ),
        fault(
            "link",
            "sum = Sums(sums[at].x, sums[at].y, sums[at].z, sums[at].w);",
            "",
        ),
        fault(
            "intersect",
            "hit.t > 0.0 && hit.t < END * end",
            "hit.t < END * end",
        ),
        fault(
            "tree",
            "siblings.y & 0xffu & ((1u << child) - 1u)",
            "siblings.y & 0xffu & (1u << child)",
        ),
        fault(
            "aim",
            "shots[slot].next = min(shots[slot].next + params.step, params.samples);",
            "shots[slot].next = params.samples;",
        ),
    ];
    let gpu = gpu();
    for fault in faults {
        let by_item_buffer = fault.file == "link" || fault.file == "aim";
        let visibility = if by_item_buffer {
            drawn(128)
        } else {
            Visibility::Rays
        };
        let scene = if fault.file == "tree" {
            paper_room()
        } else {
            odd_shapes()
        };
        let settings = settings(visibility);
        let mesh = mesh(&scene, &settings);
        // The lamps are last; they shoot first, and every cell of the small scene shoots twice.
        let once = (0..mesh.cells.len() as u32).rev().take(60);
        let log: Vec<u32> = once.clone().chain(once).collect();
        let run = |faults: &[Fault]| {
            let mut engine =
                GpuSolver::with_faults(&gpu, &mesh, &settings.transport, faults).unwrap();
            common::shooting::replay(&mut engine, &log).unwrap().field
        };
        let error = distance(&run(&[fault]), &run(&[]));
        assert!(error > ROUNDING, "{fault:?} moved nothing: {error}");
    }
}

#[test]
fn half_a_blocker_hides_half() {
    // Facing unit squares, a shade half-way between them over x < ½. Lamp and floor are mirror
    // images of themselves in x = ½: half of the light between them crosses the shade.
    let p = DVec3::new;
    let white = Vec3::splat(0.5);
    let floor = [
        p(0.0, 0.0, 0.0),
        p(0.0, 0.0, 1.0),
        p(1.0, 0.0, 1.0),
        p(1.0, 0.0, 0.0),
    ];
    let lamp = [
        p(0.0, 1.0, 0.0),
        p(1.0, 1.0, 0.0),
        p(1.0, 1.0, 1.0),
        p(0.0, 1.0, 1.0),
    ];
    let shade = [
        p(0.0, 0.5, 0.0),
        p(0.5, 0.5, 0.0),
        p(0.5, 0.5, 1.0),
        p(0.0, 0.5, 1.0),
    ];
    let faces = vec![
        Face::quad("floor", floor, Vec3::ZERO, Vec3::ZERO),
        Face::quad("lamp", lamp, Vec3::ONE, Vec3::ZERO),
        Face::quad("shade", shade, Vec3::ZERO, white),
    ];
    let settings = Settings {
        meshing: Meshing {
            texels: 8,
            cells: 1,
            samples: 1024,
        },
        schedule: Schedule {
            epsilon: 0.5,
            ..Schedule::default()
        },
        ..Settings::default()
    };
    let mesh = mesh(&scene("shade", faces), &settings);
    let run = free(
        &mut CpuSolver::new(&mesh, &settings.transport),
        &settings.schedule,
    );
    let floor: Vec<f64> = (0..mesh.texels.len())
        .filter(|k| mesh.texels[*k].face == 0)
        .map(|k| f64::from(run.field.irradiance[k].x))
        .collect();
    let open: f64 = 0.1998248957;
    let mean = floor.iter().sum::<f64>() / floor.len() as f64;
    // 64 texels × 1024 samples of a yes or no, spread evenly: a few in a thousand.
    assert!(
        abs_diff_eq!(mean / (open / 2.0), 1.0, epsilon = 0.005),
        "{mean}"
    );
}

#[test]
fn what_stands_on_a_floor_moves_its_light_aside() {
    // A box on the floor of a furnace: covered texels take nothing, and the light that the floor
    // reflects leaves from where it is open: every open texel has B = E/(1 − ρ), on average.
    let (rho, side) = (0.5f32, 0.25);
    let mut faces = furnace(rho).faces;
    let (low, high) = (
        DVec3::new(0.375, 0.0, 0.375),
        DVec3::new(0.375 + side, 0.3, 0.375 + side),
    );
    for face in room(low, high, false, Vec3::ONE, Vec3::splat(rho)) {
        if face.name != "floor" {
            faces.push(face);
        }
    }
    let settings = Settings {
        meshing: Meshing {
            texels: 8,
            cells: 8,
            samples: 16,
        },
        schedule: Schedule {
            epsilon: 1e-3,
            ..Schedule::default()
        },
        ..Settings::default()
    };
    let mesh = mesh(&scene("box on the floor", faces), &settings);
    let run = free(
        &mut CpuSolver::new(&mesh, &settings.transport),
        &settings.schedule,
    );
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
fn conserving_closes_every_shot() {
    let mut settings = settings(Visibility::Rays);
    settings.transport.conserve = true;
    let gpu = gpu();
    let mesh = mesh(&lit_room(), &settings);
    let engines: [Box<dyn Engine>; 2] = [
        Box::new(CpuSolver::new(&mesh, &settings.transport)),
        Box::new(GpuSolver::new(&gpu, &mesh, &settings.transport).unwrap()),
    ];
    for mut engine in engines {
        for shot in free(engine.as_mut(), &settings.schedule).shots {
            let sum = shot.form_factor_sum + shot.escaped;
            assert!(
                abs_diff_eq!(sum, 1.0, epsilon = 4.0 * f32::EPSILON),
                "{shot:?}"
            );
        }
    }
}
