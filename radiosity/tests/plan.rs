//! Passes, shots and times of a plan against those of the solve.

use super::bundled::bundled_scene;
use common::cover::sampled_mesh;
use common::passes::solve_by_schedule;
use common::settings::{Iteration, Meshing, Schedule, Settings};
use cpu::CpuSolver;
use radiosity::plan::passes::estimate_passes;
use radiosity::plan::{SceneCounts, trial};
use std::ops::ControlFlow;

/// Returns true if `told` is within a factor of 3 of `true_value`.
fn within_factor_three(told: f64, true_value: f64) -> bool {
    (1.0 / 3.0..3.0).contains(&(told / true_value))
}

#[test]
fn shots_passes_and_patches_are_estimated_within_factor_three() {
    for name in ["cornell_box.obj", "furnace.obj"] {
        let scene = bundled_scene(name);
        for iteration in [Iteration::Southwell, Iteration::Chebyshev, Iteration::Cg] {
            let settings = Settings {
                meshing: Meshing {
                    patches: 8,
                    samples: 2,
                    ..Meshing::default()
                },
                schedule: Schedule {
                    iteration,
                    ..Schedule::default()
                },
                ..Settings::default()
            };
            let told = estimate_passes(&scene, &settings).unwrap();
            assert!(told.small_side.is_some_and(|side| side < settings.meshing.texels));
            let mesh = sampled_mesh(&scene, &settings.meshing).unwrap();
            let mut engine = CpuSolver::new(&mesh, &settings.transport);
            let run = solve_by_schedule(&mut engine, &mesh, &settings.schedule, &mut |_| {
                ControlFlow::Continue(())
            })
            .unwrap();
            let mut linked = run.shooter_log();
            linked.sort_unstable();
            linked.dedup();
            let what = format!("{name}, {iteration:?}: {told:?}");
            assert!(
                within_factor_three(told.shots, run.shooters as f64),
                "{what} {}",
                run.shooters
            );
            assert!(
                within_factor_three(told.passes, f64::from(run.passes)),
                "{what} {}",
                run.passes
            );
            assert!(
                within_factor_three(told.linked, linked.len() as f64),
                "{what} {}",
                linked.len()
            );
            let counts = SceneCounts::new(&scene, &settings.meshing);
            assert_eq!(counts.texels, mesh.texels.len() as u64);
            assert_eq!(counts.patches, mesh.patches.len() as u64);
        }
    }
}

#[test]
fn trial_times_every_part_of_a_solve() {
    let scene = bundled_scene("cornell_box.obj");
    for iteration in [Iteration::Southwell, Iteration::Cg] {
        let settings = Settings {
            schedule: Schedule {
                iteration,
                ..Schedule::default()
            },
            ..Settings::default()
        };
        let told = estimate_passes(&scene, &settings).unwrap();
        let mesh = sampled_mesh(&scene, &settings.meshing).unwrap();
        let mut engine = CpuSolver::new(&mesh, &settings.transport);
        let time = trial::time_patches(&mut engine, &mesh, &told).unwrap();
        assert!(time.links > 0.0 && time.passes > 0.0, "{time:?}");
        assert!(time.tried > 4 && time.factor > 1.0 && time.factor < 10.0, "{time:?}");
    }
}
