//! Order of shots: choice of the shooter, end of the run, and equality of runs, single shots and replays.

use approx::abs_diff_eq;
use common::mesh::Mesh;
use common::settings::{Iteration, Schedule, Visibility};
use common::shooting::{Shot, ShotOrder, replay_log, select_shooter, solve_progress};
use glam::Vec3;
use gpu::GpuSolver;
use radiosity_tests::engines::{
    GREEDY_TO_ZERO, each_engine, engine_settings, gpu_solver, item_buffer, mesh_of, run_shots, shared_gpu,
    shoot_freely, solve_by_schedule,
};
use radiosity_tests::{furnace, lit_room};
use std::ops::ControlFlow;

/// Greedy runs and replays, whose shooters repeat.
#[test]
fn run_equals_its_single_shots() {
    let mesh = mesh_of(&lit_room());
    let log: Vec<u32> = (0..150u32).map(|k| k * 7 % mesh.patches.len() as u32).collect();
    each_engine(&mesh, |name, fresh| {
        for order in [GREEDY_TO_ZERO, ShotOrder::Replay(&log)] {
            let mut whole = fresh();
            let shots = run_shots(&mut *whole, order, 150);
            assert_eq!(shots.len(), 150);
            let mut single = fresh();
            for (shot, logged) in shots.iter().zip(&log) {
                let patch = match order {
                    ShotOrder::Greedy { .. } => select_shooter(&single.patch_power().unwrap(), 0.0).unwrap(),
                    ShotOrder::Replay(_) => *logged,
                };
                assert_eq!(single.shoot(patch).unwrap(), *shot, "{name}");
            }
            assert_eq!(single.read_field().unwrap(), whole.read_field().unwrap(), "{name}");
            assert!(run_shots(&mut *whole, order, 0).is_empty(), "{name}");
            assert!(run_shots(&mut *whole, ShotOrder::Replay(&[]), 9).is_empty(), "{name}");
        }
        // A run continues from the end of another.
        let mut halves = fresh();
        let mut parts = run_shots(&mut *halves, GREEDY_TO_ZERO, 70);
        parts.extend(run_shots(&mut *halves, GREEDY_TO_ZERO, 80));
        let mut whole = fresh();
        assert_eq!(parts, run_shots(&mut *whole, GREEDY_TO_ZERO, 150), "{name}");
        assert_eq!(halves.read_field().unwrap(), whole.read_field().unwrap(), "{name}");
    });
}

/// A page awaits what other programs wait for.
#[test]
fn awaited_run_equals_the_one_that_waits() {
    let mesh = mesh_of(&lit_room());
    let schedule = engine_settings().schedule;
    for visibility in [Visibility::Rays, item_buffer(128)] {
        let transport = engine_settings().with_visibility(visibility).transport;
        let expected = shoot_freely(&mut gpu_solver(&mesh, &transport, &[]), &schedule);
        let mut watched = Vec::new();
        let awaited = pollster::block_on(async {
            let mut solver = GpuSolver::request(shared_gpu(), &mesh, &transport, &[]).await?;
            let mut keep_shot = |shot: &Shot, emitted| {
                assert_eq!(emitted, expected.emitted);
                watched.push(*shot);
                ControlFlow::Continue(())
            };
            solver.request_run(&schedule, &mut keep_shot).await
        });
        let awaited = awaited.unwrap();
        assert!(awaited.converged && awaited.shots.len() > 100);
        assert_eq!(watched, expected.shots);
        assert_eq!(awaited.shots, expected.shots);
        assert_eq!(awaited.field, expected.field);
    }
}

#[test]
fn repeated_run_is_bit_identical() {
    let mesh = mesh_of(&lit_room());
    each_engine(&mesh, |name, fresh| {
        let runs = [0, 1].map(|_| shoot_freely(&mut *fresh(), &engine_settings().schedule));
        assert!(runs[0].converged && runs[0].shots.len() > 100, "{name}");
        assert_eq!(runs[0].shots, runs[1].shots, "{name}");
        assert_eq!(runs[0].field, runs[1].field, "{name}");
        let by_passes = Schedule {
            iteration: Iteration::Cg,
            ..engine_settings().schedule
        };
        let runs = [0, 1].map(|_| solve_by_schedule(&mut *fresh(), &mesh, &by_passes));
        assert_eq!(runs[0].field, runs[1].field, "{name} by passes");
    });
}

/// After a break the GPU may complete two submissions at most. It reports each of their shots, so that the
/// log and the textures agree.
#[test]
fn break_stops_the_run() {
    const SUBMISSION: usize = 64;
    let mesh = mesh_of(&lit_room());
    each_engine(&mesh, |name, fresh| {
        let mut engine = fresh();
        let mut patches = Vec::new();
        engine
            .run(GREEDY_TO_ZERO, 1000, &mut |shot| {
                patches.push(shot.patch);
                if patches.len() == 5 {
                    ControlFlow::Break(())
                } else {
                    ControlFlow::Continue(())
                }
            })
            .unwrap();
        let most = if name.starts_with("cpu") { 5 } else { 2 * SUBMISSION };
        assert!((5..=most).contains(&patches.len()), "{name}: {} shots", patches.len());
        let again = replay_log(&mut *fresh(), &patches).unwrap();
        assert_eq!(again.field, engine.read_field().unwrap(), "{name}");
    });
}

#[test]
fn run_submits_and_reads_once_per_batch() {
    let mesh = mesh_of(&lit_room());
    let settings = engine_settings().with_visibility(item_buffer(128));
    let mut solver = gpu_solver(&mesh, &settings.transport, &[]);
    let run = shoot_freely(
        &mut solver,
        &Schedule {
            epsilon: 1e-5,
            ..settings.schedule
        },
    );
    let (shots, counts) = (run.shots.len() as u32, solver.queue_counts());
    assert!(shots >= 300, "{shots}");
    // Submissions of 64 shots at least, two under way at the end, the first sums, the field.
    let most = shots / 64 + 8;
    assert!(
        counts.submissions <= most && counts.maps <= most,
        "{counts:?} for {shots} shots"
    );
}

#[test]
fn equal_powers_select_the_lowest_patch() {
    assert_eq!(select_shooter(&[1.0, 2.0, 0.5, 2.0], 0.0), Some(1));
    assert_eq!(select_shooter(&[2.0, 2.0], 4.0), None);
    // The faces of a unit cube are equal to the last bit.
    let mesh = mesh_of(&furnace(0.5));
    each_engine(&mesh, |name, fresh| {
        let power = fresh().patch_power().unwrap();
        assert!(power.iter().all(|p| *p == power[0]), "{name}: {power:?}");
        let shots = run_shots(&mut *fresh(), GREEDY_TO_ZERO, 3);
        assert_eq!(shots[0].patch, 0, "{name}");
        // The other faces have received light, the patches of face 0 have not.
        assert!(
            shots[1..].iter().all(|shot| mesh.patches[shot.patch as usize].face > 0),
            "{name}"
        );
    });
    // More patches than lanes: 192…319 are equal, and 256 is in the first lane.
    let mut bright = furnace(0.5);
    for k in [0, 1, 2, 5] {
        bright.faces[k].emission = Vec3::ZERO;
    }
    each_engine(&Mesh::uniform(&bright, 8, 8).unwrap(), |name, fresh| {
        assert_eq!(run_shots(&mut *fresh(), GREEDY_TO_ZERO, 1)[0].patch, 192, "{name}");
    });
}

#[test]
fn run_ends_at_the_threshold() {
    let mesh = mesh_of(&lit_room());
    each_engine(&mesh, |name, fresh| {
        for epsilon in [0.3, 0.03, 0.003] {
            let schedule = Schedule {
                epsilon,
                ..engine_settings().schedule
            };
            let run = shoot_freely(&mut *fresh(), &schedule);
            assert!(run.converged && run.unshot_fraction() <= epsilon, "{name}");
            let before = &run.shots[run.shots.len() - 2];
            assert!(f64::from(before.unshot) > epsilon * f64::from(run.emitted), "{name}");
            let max_shots = run.shots.len() as u32 - 1;
            let limited = shoot_freely(&mut *fresh(), &Schedule { max_shots, ..schedule });
            assert!(
                !limited.converged && limited.shots == run.shots[..max_shots as usize],
                "{name}"
            );
        }
    });
}

/// From 8 W to the threshold of 1/8 W; 1 W is half the way on a logarithmic scale.
#[test]
fn progress_rises_with_the_logarithm_of_power() {
    let progress = |unshot| {
        let shot = Shot {
            patch: 0,
            power: [0.0; 3],
            form_factor_sum: 1.0,
            escaped: 0.0,
            unshot,
        };
        solve_progress(&shot, 8.0, 1.0 / 64.0)
    };
    for (unshot, expected) in [(9.0, 0.0), (8.0, 0.0), (1.0, 0.5), (0.125, 1.0), (0.1, 1.0), (0.0, 1.0)] {
        let found = progress(unshot);
        assert!(
            abs_diff_eq!(found, expected, epsilon = 4.0 * f64::EPSILON),
            "{unshot}: {found}"
        );
    }
}
