//! What a plan expects is what a solve takes.

use super::bundled::bundled;
use common::cover::sampled;
use common::passes::solve;
use common::settings::{Iteration, Meshing, Schedule, Settings};
use cpu::CpuSolver;
use oracle::plan::passes::expected;
use oracle::plan::{Counts, trial};
use std::ops::ControlFlow;

/// Whether `told` is `true_value` within a factor of 3.
fn near(told: f64, true_value: f64) -> bool {
    (1.0 / 3.0..3.0).contains(&(told / true_value))
}

#[test]
fn shots_passes_and_cells_are_expected_within_a_factor_of_three() {
    for name in ["cornell_box.obj", "furnace.obj"] {
        let scene = bundled(name);
        for iteration in [Iteration::Southwell, Iteration::Chebyshev, Iteration::Cg] {
            let settings = Settings {
                meshing: Meshing {
                    cells: 8,
                    samples: 2,
                    ..Meshing::default()
                },
                schedule: Schedule {
                    iteration,
                    ..Schedule::default()
                },
                ..Settings::default()
            };
            let told = expected(&scene, &settings).unwrap();
            assert!(told.from.is_some_and(|side| side < settings.meshing.texels));
            let mesh = sampled(&scene, &settings.meshing).unwrap();
            let mut engine = CpuSolver::new(&mesh, &settings.transport);
            let run = solve(&mut engine, &mesh, &settings.schedule, &mut |_| {
                ControlFlow::Continue(())
            })
            .unwrap();
            let mut linked = run.cells();
            linked.sort_unstable();
            linked.dedup();
            let what = format!("{name}, {iteration:?}: {told:?}");
            assert!(
                near(told.shots, run.shooters as f64),
                "{what} {}",
                run.shooters
            );
            assert!(
                near(told.passes, f64::from(run.passes)),
                "{what} {}",
                run.passes
            );
            assert!(
                near(told.linked, linked.len() as f64),
                "{what} {}",
                linked.len()
            );
            let counts = Counts::new(&scene, &settings.meshing);
            assert_eq!(counts.texels, mesh.texels.len() as u64);
            assert_eq!(counts.cells, mesh.cells.len() as u64);
        }
    }
}

#[test]
fn the_trial_times_every_part() {
    let scene = bundled("cornell_box.obj");
    for iteration in [Iteration::Southwell, Iteration::Cg] {
        let settings = Settings {
            schedule: Schedule {
                iteration,
                ..Schedule::default()
            },
            ..Settings::default()
        };
        let told = expected(&scene, &settings).unwrap();
        let mesh = sampled(&scene, &settings.meshing).unwrap();
        let mut engine = CpuSolver::new(&mesh, &settings.transport);
        let time = trial::time(&mut engine, &mesh, &told).unwrap();
        assert!(time.links > 0.0 && time.passes > 0.0, "{time:?}");
        assert!(
            time.tried > 4 && time.factor > 1.0 && time.factor < 10.0,
            "{time:?}"
        );
    }
}
