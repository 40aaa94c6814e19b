//! The loop's promises: which cell shoots, when it stops, and that the host's way of asking changes
//! nothing.

use common::mesh::Mesh;
use common::settings::Schedule;
use common::shooting::{Order, replay, select};
use glam::Vec3;
use gpu::GpuSolver;
use radiosity_tests::engines::{ALL, each_engine, free, gpu, gpu_settings, mesh_of, run, settings};
use radiosity_tests::{furnace, lit_room};
use std::ops::ControlFlow;

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
        let runs = [0, 1].map(|_| free(&mut *fresh(), &settings().schedule));
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
                &Schedule {
                    max_shots: most,
                    ..settings().schedule
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
            .run(ALL, 1000, &mut |shot| {
                cells.push(shot.cell);
                if cells.len() == 5 {
                    ControlFlow::Break(())
                } else {
                    ControlFlow::Continue(())
                }
            })
            .unwrap();
        let most = if name.starts_with("cpu") {
            5
        } else {
            2 * SUBMISSION
        };
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
    let mut solver = GpuSolver::new(&gpu(), &mesh, &settings.transport).unwrap();
    let run = free(
        &mut solver,
        &Schedule {
            epsilon: 1e-5,
            ..settings.schedule
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
                &Schedule {
                    epsilon,
                    ..settings().schedule
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
