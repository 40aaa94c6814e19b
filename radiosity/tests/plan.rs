//! Counts of a scene against its mesh, a forecast against the solve.

use super::bundled::bundled_scene;
use common::mesh::Mesh;
use common::settings::{Iteration, Meshing, Schedule, Settings};
use oracle::solve::progress::without_progress;
use oracle::solve::solver::{ErrorTarget, SolverChoice};
use oracle::solve::task::SolveTask;
use radiosity::plan::SceneCounts;
use radiosity::plan::forecast::forecast_solve;
use std::ops::ControlFlow;

/// Returns true if `told` is within a factor of 3 of `true_value`.
fn within_factor_three(told: f64, true_value: f64) -> bool {
    (1.0 / 3.0..3.0).contains(&(told / true_value))
}

#[test]
fn shots_and_passes_are_forecast_within_factor_three() {
    for name in ["cornell_box.obj", "furnace.obj"] {
        let scene = bundled_scene(name);
        for iteration in [Iteration::Southwell, Iteration::Chebyshev, Iteration::Cg] {
            let settings = Settings {
                meshing: Meshing {
                    patches: 8,
                    samples: 8,
                    ..Meshing::default()
                },
                schedule: Schedule {
                    iteration,
                    ..Schedule::default()
                },
                ..Settings::default()
            };
            let show = |_: &str, _: f64| ControlFlow::Continue(());
            let told = forecast_solve(&scene, &settings, SolverChoice::Cpu, &show).unwrap();
            assert!(!told.stopped && told.work_ratio > 4.0, "{told:?}");
            let solved = scene.solve_once(&settings, SolverChoice::Cpu, &without_progress());
            let run = solved.unwrap().run;
            let [passes, shots] = told.passes.unwrap();
            let what = format!("{name}, {iteration:?}: {told:?}, {} in {}", run.shooters, run.passes);
            assert!(within_factor_three(shots, run.shooters as f64), "{what}");
            assert!(within_factor_three(passes, f64::from(run.passes)), "{what}");
            // A limit of shots shortens the solve.
            let mut limited = settings;
            limited.schedule.max_shots = (shots / 4.0) as u32;
            let few = forecast_solve(&scene, &limited, SolverChoice::Cpu, &show).unwrap();
            assert!(few.passes.unwrap()[1] <= limited.schedule.max_shots.into(), "{few:?}");
            assert!(few.work_ratio < told.work_ratio, "{few:?} {told:?}");
        }
    }
}

#[test]
fn counts_are_those_of_the_mesh() {
    // Its non-planar wall is split into triangles.
    let scene = bundled_scene("cornell_box.obj");
    for (texels, patches) in [(1, 1), (8, 4), (6, 4), (7, 3), (2, 8)] {
        let meshing = Meshing {
            texels,
            patches,
            ..Meshing::default()
        };
        let counts = SceneCounts::new(&scene, &meshing);
        let mesh = Mesh::uniform(&scene, texels, patches).unwrap();
        assert_eq!(counts.texels, mesh.texels.len() as u64);
        assert_eq!(counts.patches, mesh.patches.len() as u64, "{texels} {patches}");
    }
}

#[test]
fn forecast_of_a_solve_to_an_error_goes_with_its_inverse() {
    let scene = bundled_scene("furnace.obj");
    let forecast = |error, patient: bool| {
        let target = ErrorTarget { error, texels: Some(4) };
        let show = |_: &str, _: f64| match patient {
            true => ControlFlow::Continue(()),
            false => ControlFlow::Break(()),
        };
        forecast_solve(
            &scene,
            &Settings::default(),
            SolverChoice::to_error(None, target),
            &show,
        )
        .unwrap()
    };
    let [coarse, fine] = [0.1, 0.01].map(|error| forecast(error, true));
    assert!((coarse.work_ratio - 1.0).abs() < 1e-12 && (fine.work_ratio - 10.0).abs() < 1e-12);
    assert!(!fine.stopped && fine.passes.is_none() && fine.trial_seconds > 0.0);
    // A trial that is stopped tells the least time.
    let stopped = forecast(0.01, false);
    assert!(
        stopped.stopped && (stopped.work_ratio - 10.0).abs() < 1e-12,
        "{stopped:?}"
    );
}
