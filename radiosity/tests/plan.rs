//! Counts of a scene against its mesh, a forecast against the solve.

use common::mesh::Mesh;
use common::settings::{Iteration, Meshing, Settings};
use oracle::solve::progress::without_progress;
use oracle::solve::solver::{ErrorTarget, SolverChoice};
use oracle::solve::task::SolveTask;
use radiosity::plan::SceneCounts;
use radiosity::plan::forecast::forecast_solve;
use radiosity_tests::bundled_scene;
use std::ops::ControlFlow;

#[test]
fn shots_are_forecast_within_factor_three() {
    for name in ["cornell_box.obj", "furnace.obj"] {
        let scene = bundled_scene(name);
        for iteration in [Iteration::Southwell, Iteration::Chebyshev, Iteration::Cg] {
            let mut settings = Settings::default();
            (settings.meshing.patches, settings.meshing.samples) = (8, 8);
            settings.schedule.iteration = iteration;
            let show = |_: &str, _: f64| ControlFlow::Continue(());
            let told = forecast_solve(&scene, &settings, SolverChoice::Cpu, &show).unwrap();
            assert!(!told.stopped && told.work_ratio > 4.0, "{told:?}");
            let solved = scene.solve_once(&settings, SolverChoice::Cpu, &without_progress());
            let (shots, found) = (told.shots.unwrap(), solved.unwrap().run.shooters as f64);
            let what = format!("{name}, {iteration:?}: {told:?}, {found} shots");
            assert!((1.0 / 3.0..3.0).contains(&(shots / found)), "{what}");
            // A limit of shots shortens the solve.
            settings.schedule.max_shots = (shots / 4.0) as u32;
            let few = forecast_solve(&scene, &settings, SolverChoice::Cpu, &show).unwrap();
            assert!(few.shots.unwrap() <= settings.schedule.max_shots.into(), "{few:?}");
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
    assert!(!fine.stopped && fine.shots.is_none() && fine.trial_seconds > 0.0);
    // A trial that is stopped tells the least time.
    let stopped = forecast(0.01, false);
    assert!(
        stopped.stopped && (stopped.work_ratio - 10.0).abs() < 1e-12,
        "{stopped:?}"
    );
}
