//! Counts of a scene against its mesh, a forecast against the solve.

use common::mesh::Mesh;
use common::scene::{Face, Scene};
use common::settings::{Iteration, Meshing, Settings};
use glam::{DVec3, Vec3};
use oracle::solve::progress::without_progress;
use oracle::solve::solver::{ErrorTarget, SolverChoice};
use oracle::solve::task::SolveTask;
use radiosity::plan::SceneCounts;
use radiosity::plan::forecast::forecast_solve;
use radiosity_tests::factor_cases::rectangle;
use radiosity_tests::{ball, box_faces, bundled_scene, named_scene};
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

/// A closed room with a lamp, and a ball of 264 triangles in it.
fn room_with_ball() -> Scene {
    let grey = Vec3::splat(0.6);
    let mut faces = box_faces(DVec3::splat(-2.0), DVec3::splat(2.0), true, Vec3::ZERO, grey);
    let lamp = rectangle([-0.4, 1.9, -0.4], [0.8, 0.0, 0.0], [0.0, 0.0, 0.8]);
    faces.push(Face::quad("lamp", lamp, Vec3::splat(20.0), Vec3::ZERO));
    let body = ball(DVec3::ZERO, 1.0, [12, 12]).into_iter();
    faces.extend(body.map(|face| Face {
        reflectance: grey,
        ..face
    }));
    named_scene("ball", faces)
}

#[test]
fn forecast_tells_texels_and_rays_of_a_solve_to_an_error_within_factor_two() {
    let [few, many] = [bundled_scene("cornell_box.obj"), room_with_ball()];
    let cases = [
        (&few, 0.05, None),
        (&few, 0.02, None),
        (&few, 0.005, None),
        (&few, 0.02, Some(8)),
        (&many, 0.05, None),
        (&many, 0.02, None),
        (&many, 0.02, Some(2)),
    ];
    for (scene, error, texels) in cases {
        let solver = SolverChoice::to_error(None, ErrorTarget { error, texels });
        let settings = Settings::default();
        let go_on = |_: &str, _: f64| ControlFlow::Continue(());
        let told = forecast_solve(scene, &settings, solver, &go_on).unwrap();
        let solved = scene.solve_once(&settings, solver, &without_progress()).unwrap();
        let [told_texels, told_rays] = told.kept.unwrap();
        let by_rays = scene.faces.len() > 200;
        assert_eq!(told_rays > 0, by_rays, "{told:?}");
        let mut pairs = vec![];
        if texels.is_none() {
            pairs.push((told_texels, solved.mesh.texels.len() as u64));
        }
        if by_rays {
            pairs.push((told_rays, solved.history.unwrap().links));
        }
        for (told, found) in pairs {
            let ratio = told as f64 / found as f64;
            assert!(
                (0.5..2.0).contains(&ratio),
                "{} to {error}: {told} for {found}",
                scene.name
            );
        }
        assert!(told.work_ratio >= 1.0 && told.seconds > told.trial_seconds, "{told:?}");
        // Two more steps follow, on three times and on five times as many texels.
        assert!(error > 0.005 || told.work_ratio > 3.0, "{told:?}");
        // Steps that are stopped tell the least time.
        let stop = |_: &str, _: f64| ControlFlow::Break(());
        let stopped = forecast_solve(scene, &settings, solver, &stop).unwrap();
        assert!(stopped.stopped && stopped.kept.is_none(), "{stopped:?}");
    }
}
