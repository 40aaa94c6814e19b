//! The loop's promises: which cell shoots, when it stops, and that neither the host's way of asking
//! nor the scene's units change the answer.

use common::mesh::Mesh;
use common::scene::{Face, Scene};
use common::settings::{Settings, Visibility};
use common::shooting::{Engine, Field, Order, Run, Shot, replay, select, solve};
use cpu::CpuSolver;
use glam::{DVec3, Vec3, Vec4};
use gpu::{Gpu, GpuSolver};
use oracle::exact;
use radiosity_tests::bounds::U;
use radiosity_tests::{furnace, lit_room};
use std::ops::ControlFlow;

fn settings() -> Settings {
    Settings {
        texels: 6,
        cells: 2,
        item_buffer: 128,
        ..Settings::default()
    }
}

fn gpu_settings() -> Settings {
    Settings {
        visibility: Visibility::Stereographic,
        ..settings()
    }
}

fn mesh_of(scene: &Scene) -> Mesh {
    let settings = settings();
    Mesh::uniform(scene, settings.texels, settings.cells).unwrap()
}

fn gpu() -> Gpu {
    Gpu::open(None).unwrap()
}

fn free(engine: &mut dyn Engine, settings: &Settings) -> Run {
    solve(engine, settings, &mut |_, _| ControlFlow::Continue(())).unwrap()
}

/// The same test of the CPU and of the GPU, each on a fresh engine whenever `test` asks.
fn each_engine<'m>(mesh: &'m Mesh, test: impl Fn(&str, &mut dyn FnMut() -> Box<dyn Engine + 'm>)) {
    let (cpu_settings, gpu_settings, gpu) = (settings(), gpu_settings(), gpu());
    test("cpu", &mut || Box::new(CpuSolver::new(mesh, &cpu_settings)));
    test("gpu", &mut || {
        Box::new(GpuSolver::new(&gpu, mesh, &gpu_settings).unwrap())
    });
}

fn run(engine: &mut dyn Engine, order: Order, max_shots: u32) -> Vec<Shot> {
    let mut shots = Vec::new();
    engine
        .run(order, max_shots, &mut |shot| {
            shots.push(*shot);
            ControlFlow::Continue(())
        })
        .unwrap();
    shots
}

const ALL: Order = Order::Greedy { threshold: 0.0 };

#[test]
fn a_run_is_its_single_shots() {
    let mesh = mesh_of(&lit_room());
    each_engine(&mesh, |name, fresh| {
        let mut whole = fresh();
        let shots = run(&mut *whole, ALL, 150);
        assert_eq!(shots.len(), 150);
        let mut single = fresh();
        for shot in &shots {
            let cell = select(&single.cell_power().unwrap(), 0.0).unwrap();
            assert_eq!(single.shoot(cell).unwrap(), *shot, "{name}");
        }
        assert_eq!(single.field().unwrap(), whole.field().unwrap(), "{name}");
        // A run may go on where another stopped.
        let mut halves = fresh();
        let mut log = run(&mut *halves, ALL, 70);
        log.extend(run(&mut *halves, ALL, 80));
        assert_eq!(log, shots, "{name}");
        assert_eq!(halves.field().unwrap(), whole.field().unwrap(), "{name}");
    });
}

#[test]
fn a_run_repeats_itself_bit_for_bit() {
    let mesh = mesh_of(&lit_room());
    each_engine(&mesh, |name, fresh| {
        let runs = [0, 1].map(|_| free(&mut *fresh(), &settings()));
        assert!(runs[0].converged && runs[0].shots.len() > 100, "{name}");
        assert_eq!(runs[0].shots, runs[1].shots, "{name}");
        assert_eq!(runs[0].field, runs[1].field, "{name}");
    });
}

#[test]
fn a_replay_obeys_its_log() {
    let mesh = mesh_of(&lit_room());
    let log: Vec<u32> = (0..100u32)
        .map(|k| k * 7 % mesh.cells.len() as u32)
        .collect();
    each_engine(&mesh, |name, fresh| {
        let mut engine = fresh();
        let again = replay(&mut *engine, &log).unwrap();
        assert_eq!(again.cells(), log, "{name}");
        let mut single = fresh();
        for (cell, shot) in log.iter().zip(&again.shots) {
            assert_eq!(single.shoot(*cell).unwrap(), *shot, "{name}");
        }
        assert_eq!(single.field().unwrap(), again.field, "{name}");
        assert_eq!(run(&mut *engine, Order::Replay(&log), 9).len(), 9, "{name}");
        assert!(
            run(&mut *engine, Order::Replay(&[]), 9).is_empty(),
            "{name}"
        );
    });
}

#[test]
fn max_shots_is_obeyed() {
    let mesh = mesh_of(&lit_room());
    each_engine(&mesh, |name, fresh| {
        for most in [0, 1, 7, 65, 130] {
            let mut engine = fresh();
            let limited = free(
                &mut *engine,
                &Settings {
                    max_shots: most,
                    ..settings()
                },
            );
            assert_eq!(limited.shots.len(), most as usize, "{name}");
            assert!(!limited.converged, "{name}");
            let mut again = fresh();
            for cell in limited.cells() {
                again.shoot(cell).unwrap();
            }
            assert_eq!(
                again.field().unwrap(),
                limited.field,
                "{name}: after {most}"
            );
        }
    });
}

/// The GPU may have shots under way when `watch` breaks: two submissions at most. Each of them is
/// still reported, so that the log and the textures agree.
#[test]
fn a_break_stops_the_run() {
    const SUBMISSION: usize = 64;
    let mesh = mesh_of(&lit_room());
    each_engine(&mesh, |name, fresh| {
        let mut engine = fresh();
        let mut cells = Vec::new();
        engine
            .run(ALL, 100_000, &mut |shot| {
                cells.push(shot.cell);
                if cells.len() == 5 {
                    ControlFlow::Break(())
                } else {
                    ControlFlow::Continue(())
                }
            })
            .unwrap();
        let most = if name == "cpu" { 5 } else { 2 * SUBMISSION };
        assert!(
            (5..=most).contains(&cells.len()),
            "{name}: {} shots",
            cells.len()
        );
        let mut again = fresh();
        for cell in cells {
            again.shoot(cell).unwrap();
        }
        assert_eq!(again.field().unwrap(), engine.field().unwrap(), "{name}");
    });
}

#[test]
fn the_host_seldom_talks_to_the_device() {
    let mesh = mesh_of(&lit_room());
    let settings = gpu_settings();
    let mut solver = GpuSolver::new(&gpu(), &mesh, &settings).unwrap();
    let run = free(
        &mut solver,
        &Settings {
            epsilon: 1e-5,
            ..settings
        },
    );
    let (shots, counts) = (run.shots.len() as u32, solver.counts());
    assert!(shots >= 300, "{shots}");
    // Submissions of 64 shots at least, two under way at the end, the first sums, the field.
    let most = shots / 64 + 8;
    assert!(
        counts.submissions <= most && counts.maps <= most,
        "{counts:?} for {shots} shots"
    );
}

#[test]
fn ties_go_to_the_lowest_cell() {
    assert_eq!(select(&[1.0, 2.0, 0.5, 2.0], 0.0), Some(1));
    assert_eq!(select(&[2.0, 2.0], 4.0), None);
    // The faces of a unit cube are equal to the last bit.
    let mesh = mesh_of(&furnace(0.5));
    each_engine(&mesh, |name, fresh| {
        let power = fresh().cell_power().unwrap();
        assert!(power.iter().all(|p| *p == power[0]), "{name}: {power:?}");
        let shots = run(&mut *fresh(), ALL, 3);
        assert_eq!(shots[0].cell, 0, "{name}");
        // The other faces have gained, the first one's cells have not.
        assert!(
            shots[1..]
                .iter()
                .all(|shot| mesh.cells[shot.cell as usize].face > 0),
            "{name}"
        );
    });
    // More cells than lanes: 192…319 are equal, and 256 is in the first lane.
    let mut bright = furnace(0.5);
    for k in [0, 1, 2, 5] {
        bright.faces[k].emission = Vec3::ZERO;
    }
    each_engine(&Mesh::uniform(&bright, 8, 8).unwrap(), |name, fresh| {
        assert_eq!(run(&mut *fresh(), ALL, 1)[0].cell, 192, "{name}");
    });
}

#[test]
fn the_run_ends_at_the_threshold_and_not_before() {
    let mesh = mesh_of(&lit_room());
    each_engine(&mesh, |name, fresh| {
        for epsilon in [0.3, 0.03, 0.003] {
            let run = free(
                &mut *fresh(),
                &Settings {
                    epsilon,
                    ..settings()
                },
            );
            assert!(run.converged && run.unshot_fraction() <= epsilon, "{name}");
            let before = &run.shots[run.shots.len() - 2];
            assert!(
                f64::from(before.unshot) > epsilon * f64::from(run.emitted),
                "{name}"
            );
        }
    });
}

fn scaled(scene: &Scene, factor: f32) -> Scene {
    let mut scene = scene.clone();
    scene
        .faces
        .iter_mut()
        .for_each(|face| face.emission *= factor);
    scene
}

/// Powers of two scale every number without rounding.
#[test]
fn brightness_by_powers_of_two_changes_no_shot() {
    let plain = lit_room();
    each_engine(&mesh_of(&plain), |name, fresh| {
        let run = free(&mut *fresh(), &settings());
        for factor in [(-20f32).exp2(), 20f32.exp2()] {
            each_engine(&mesh_of(&scaled(&plain, factor)), |other, fresh| {
                if other == name {
                    let scaled = free(&mut *fresh(), &settings());
                    assert_eq!(scaled.cells(), run.cells(), "{name}");
                    for (a, b) in scaled.field.radiosity.iter().zip(&run.field.radiosity) {
                        assert_eq!(*a, *b * factor, "{name}");
                    }
                }
            });
        }
    });
}

/// Other factors round E and all that follows: the choice is the same or one of equals.
#[test]
fn brightness_changes_no_shooter_but_among_equals() {
    let plain = lit_room();
    let meshes = [1.0, 1e-6, 1e6].map(|factor| mesh_of(&scaled(&plain, factor)));
    let [reference, small, large] = &meshes;
    let log = free(&mut CpuSolver::new(reference, &settings()), &settings());
    for mesh in [small, large] {
        let own = free(&mut CpuSolver::new(mesh, &settings()), &settings());
        assert_eq!(own.shots.len(), log.shots.len());
        let mut engine = CpuSolver::new(mesh, &settings());
        for (k, cell) in log.cells().into_iter().enumerate() {
            let power = engine.cell_power().unwrap();
            let best = power.iter().copied().fold(0.0, f32::max);
            // A cell's power is the sum of what k shots left: k + 40 roundings.
            let bound = 1.0 - (k as f64 + 40.0) * U;
            assert!(
                f64::from(power[cell as usize]) >= bound * f64::from(best),
                "shot {k}"
            );
            engine.shoot(cell).unwrap();
        }
    }
}

fn moved(scene: &Scene, scale: f64, shift: DVec3) -> Scene {
    let mut scene = scene.clone();
    for face in &mut scene.faces {
        face.corners = face.corners.map(|p| p * scale + shift);
    }
    scene
}

fn same_bits(a: &Field, b: &Field) -> bool {
    a.radiosity == b.radiosity && a.residual == b.residual && a.irradiance == b.irradiance
}

/// lit_room has dyadic coordinates: powers of two and dyadic shifts are exact in f64.
#[test]
fn units_and_origin_change_no_bit() {
    let plain = lit_room();
    let run = |scene: &Scene| {
        let mesh = mesh_of(scene);
        free(&mut CpuSolver::new(&mesh, &settings()), &settings())
    };
    let expected = run(&plain);
    let shift = DVec3::new(1024.0, -0.125, 4096.5);
    for scene in [
        moved(&plain, (-40f64).exp2(), DVec3::ZERO),
        moved(&plain, 40f64.exp2(), DVec3::ZERO),
        moved(&plain, 1.0, shift),
    ] {
        let run = run(&scene);
        assert_eq!(run.shots, expected.shots);
        assert!(same_bits(&run.field, &expected.field));
    }
}

/// Millimetres, and a place far from the origin: coordinates round differently.
#[test]
fn other_units_and_origins_change_only_rounding() {
    // At 1e6 from the origin f64 leaves 1e−10, less than f32's own rounding in the mesh. That moves
    // each texel and corner by √3·u, which near an edge (half a texel, h = ⅙ of 1/4, away) changes
    // F by √3·u/(h/2) of itself, here 100u, and B by that at each of a handful of reflections.
    const BOUND: f64 = 1000.0 * U;
    let plain = lit_room();
    let mesh = mesh_of(&plain);
    let expected = free(&mut CpuSolver::new(&mesh, &settings()), &settings());
    for (scale, shift) in [
        (1000.0, DVec3::ZERO),
        (0.3, DVec3::splat(0.1)),
        (1.0, DVec3::new(1e6, 0.1, -3e5)),
    ] {
        let mesh = mesh_of(&moved(&plain, scale, shift));
        let mut engine = CpuSolver::new(&mesh, &settings());
        let run = replay(&mut engine, &expected.cells()).unwrap();
        let pairs = run.field.radiosity.iter().zip(&expected.field.radiosity);
        let worst = pairs
            .map(|(a, b)| f64::from((a.x - b.x).abs() / b.x))
            .fold(0.0, f64::max);
        assert!(
            worst < BOUND,
            "scale {scale}, shift {shift}: {} u",
            worst / U
        );
    }
}

#[test]
fn a_dark_scene_is_done_before_it_starts() {
    let mesh = mesh_of(&scaled(&lit_room(), 0.0));
    each_engine(&mesh, |name, fresh| {
        let run = free(&mut *fresh(), &settings());
        assert!(run.shots.is_empty() && run.converged, "{name}");
        assert_eq!(run.unshot_fraction(), 0.0, "{name}");
        assert!(
            run.field.radiosity.iter().all(|b| *b == Vec4::ZERO),
            "{name}"
        );
    });
}

/// A point, a line and a folded quad among the faces, all of them bright.
#[test]
fn faces_without_area_do_no_harm() {
    let mut scene = lit_room();
    let (p, q) = (DVec3::new(2.0, 1.0, 3.0), DVec3::new(2.25, 1.0, 3.5));
    for corners in [[p; 4], [p, q, q, p], [p, q, p, q]] {
        scene
            .faces
            .push(Face::quad("flat", corners, Vec3::ONE, Vec3::splat(0.5)));
    }
    let mesh = mesh_of(&scene);
    each_engine(&mesh, |name, fresh| {
        let run = free(&mut *fresh(), &settings());
        assert!(run.converged, "{name}");
        let area = |cell: &u32| mesh.cells[*cell as usize].shooter.area;
        assert!(run.cells().iter().all(|cell| area(cell) > 0.0), "{name}");
        let mut engine = fresh();
        for cell in 0..mesh.cells.len() as u32 {
            let shot = engine.shoot(cell).unwrap();
            let finite = shot.form_factor_sum.is_finite()
                && shot.escaped.is_finite()
                && shot.unshot.is_finite();
            assert!(finite, "{name}: {shot:?}");
        }
        for field in [run.field, engine.field().unwrap()] {
            let all = field
                .radiosity
                .iter()
                .chain(&field.residual)
                .chain(&field.irradiance);
            assert!(all.into_iter().all(|v| v.is_finite()), "{name}");
        }
    });
}

/// In a furnace B = E/(1 − ρ) solves the discrete equations at any resolution: Lambert's factors
/// from a texel's centre to all cells around it sum to 1, wherever it is and however large they are.
#[test]
fn faces_may_differ_in_resolution() {
    const REFLECTANCE: f32 = 0.5;
    let resolutions: Vec<[u32; 2]> = (0..6).map(|k| [2 + k, 3 + 2 * k % 7]).collect();
    let mesh = Mesh::new(&furnace(REFLECTANCE), &resolutions, 2).unwrap();
    assert_eq!(
        mesh.texels.len() as u32,
        resolutions.iter().map(|[w, h]| w * h).sum::<u32>()
    );
    each_engine(&mesh, |name, fresh| {
        let run = free(
            &mut *fresh(),
            &Settings {
                epsilon: 1e-4,
                ..settings()
            },
        );
        assert!(run.converged, "{name}");
        // What is unshot will yet be reflected again and again; additions round by u each, F by 100u.
        let unshot = run
            .field
            .residual
            .iter()
            .map(|r| f64::from(r.x))
            .fold(0.0, f64::max);
        let later = f64::from(REFLECTANCE / (1.0 - REFLECTANCE)) * unshot;
        let rounding = 2.0 * U * (run.shots.len() as f64 + 100.0);
        for b in &run.field.radiosity {
            let missing = exact::furnace(1.0, f64::from(REFLECTANCE)) - f64::from(b.x);
            assert!(
                (-rounding..=later + rounding).contains(&missing),
                "{name}: {missing} of {later}"
            );
        }
    });
}
