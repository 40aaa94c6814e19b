//! Few passes reach the answer of many shots, whatever the iteration.

use approx::abs_diff_eq;
use common::cover;
use common::energy::Energy;
use common::mesh::Mesh;
use common::passes::solve;
use common::scene::Scene;
use common::settings::{Iteration, Meshing, Schedule, Settings};
use common::shooting::Run;
use cpu::CpuSolver;
use glam::Vec3;
use radiosity_tests::{box_in_room, furnace, lit_room, paper_room};
use std::ops::ControlFlow;

const ALL: [Iteration; 3] = [Iteration::Southwell, Iteration::Chebyshev, Iteration::Cg];

fn settings(iteration: Iteration, epsilon: f64) -> Settings {
    Settings {
        meshing: Meshing {
            texels: 4,
            cells: 2,
            ..Meshing::default()
        },
        schedule: Schedule {
            iteration,
            epsilon,
            ..Schedule::default()
        },
        ..Settings::default()
    }
}

fn mesh(scene: &Scene, samples: u32) -> Mesh {
    let mut mesh = Mesh::uniform(scene, 4, 2).unwrap();
    cover::sample(&mut mesh, samples);
    mesh
}

fn run(mesh: &Mesh, settings: &Settings) -> Run {
    let mut solver = CpuSolver::new(mesh, &settings.transport);
    solve(&mut solver, mesh, &settings.schedule, &mut |_| {
        ControlFlow::Continue(())
    })
    .unwrap()
}

/// Σ|H − H'|A over Σ H' A, all channels.
fn distance(mesh: &Mesh, a: &Run, b: &Run) -> f64 {
    let (mut difference, mut all) = (0.0, 0.0);
    for (k, texel) in mesh.texels.iter().enumerate() {
        let area = f64::from(texel.area);
        let [a, b] = [a, b].map(|run| run.field.irradiance[k].truncate().as_dvec3());
        difference += (a - b).abs().element_sum() * area;
        all += b.element_sum() * area;
    }
    assert!(all > 0.0 && difference.is_finite());
    difference / all
}

#[test]
fn every_iteration_reaches_the_answer_of_single_shots() {
    for scene in [box_in_room(), lit_room(), paper_room()] {
        for samples in [1, 3] {
            let mesh = mesh(&scene, samples);
            let limit = run(&mesh, &settings(Iteration::Southwell, 1e-6));
            for iteration in ALL {
                let run = run(&mesh, &settings(iteration, 1e-4));
                let name = format!("{}, {samples} samples, {iteration:?}", scene.name);
                assert!(run.converged && run.unshot_fraction() <= 1e-4, "{name}");
                assert!(!run.stagnated, "{name}");
                // What is unshot is reflected at most 1/(1 − ρ) times more: ρ ≤ 0.8, and light
                // that arrives is at least what is emitted here.
                let bound = 2e-4 / (1.0 - 0.8);
                let off = distance(&mesh, &run, &limit);
                assert!(off > 0.0 || iteration == Iteration::Southwell, "{name}");
                assert!(off < bound, "{name}: {off:e} of {bound:e}");
                let energy = Energy::new(&mesh, &run.field, &run.shots);
                // f32 sums over a thousand texels and the links.
                assert!(energy.imbalance < 1e-5, "{name}: {:e}", energy.imbalance);
                assert!(run.shooters >= u64::from(run.passes), "{name}");
            }
        }
    }
}

#[test]
fn passes_are_few_where_reflectance_is_high() {
    let mut scene = lit_room();
    for face in &mut scene.faces {
        face.reflectance = Vec3::splat(0.9);
    }
    let mesh = mesh(&scene, 1);
    let passes = ALL.map(|iteration| run(&mesh, &settings(iteration, 1e-3)).passes);
    let [southwell, chebyshev, cg] = passes;
    assert!(chebyshev * 8 < southwell, "{passes:?}");
    assert!(cg <= 12, "{passes:?}");
}

#[test]
fn a_furnace_ends_at_its_exact_answer() {
    // Two samples and more: near texels then integrate their form factors.
    let scene = furnace(0.5);
    let mesh = mesh(&scene, 4);
    for iteration in ALL {
        let mut settings = settings(iteration, 1e-6);
        settings.transport.conserve = true;
        let run = run(&mesh, &settings);
        let mean =
            |v: &[glam::Vec4]| v.iter().map(|v| f64::from(v.x)).sum::<f64>() / v.len() as f64;
        // Every shot closes exactly, so the mean is exact but for ε and f32.
        let b = mean(&run.field.radiosity);
        assert!(abs_diff_eq!(b, 2.0, epsilon = 1e-5), "{iteration:?}: {b}");
    }
}

#[test]
fn a_solve_stops_where_it_is_told_and_nothing_is_lost() {
    let mesh = mesh(&paper_room(), 1);
    for iteration in &ALL[1..] {
        for most in [1, 5, 40] {
            let mut settings = settings(*iteration, 1e-4);
            settings.schedule.max_shots = most;
            let run = run(&mesh, &settings);
            assert!(run.shooters == u64::from(most) && !run.converged);
            let energy = Energy::new(&mesh, &run.field, &run.shots);
            assert!(energy.imbalance < 1e-5, "{iteration:?}, {most}");
        }
        let settings = settings(*iteration, 1e-4);
        let mut solver = CpuSolver::new(&mesh, &settings.transport);
        let mut told = Vec::new();
        let run = solve(&mut solver, &mesh, &settings.schedule, &mut |done| {
            told.push(done);
            if done > 0.2 {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(())
            }
        })
        .unwrap();
        assert!(told.last().is_some_and(|done| *done > 0.2) && !run.converged);
        let energy = Energy::new(&mesh, &run.field, &run.shots);
        assert!(energy.imbalance < 1e-5, "{iteration:?}");
        assert!(energy.share(energy.unshot) > 0.001);
    }
}

#[test]
fn darkness_needs_no_pass() {
    let mut scene = lit_room();
    for face in &mut scene.faces {
        face.emission = Vec3::ZERO;
    }
    let mesh = mesh(&scene, 1);
    let run = run(&mesh, &settings(Iteration::Cg, 1e-3));
    assert!(run.converged && run.passes == 0 && run.shots.is_empty());
}

#[test]
fn the_same_solve_twice_gives_the_same_bits() {
    let mesh = mesh(&lit_room(), 3);
    let runs = [(); 2].map(|()| run(&mesh, &settings(Iteration::Cg, 1e-4)));
    assert_eq!(runs[0].field, runs[1].field);
}

fn white(reflectance: f32) -> Scene {
    let mut scene = lit_room();
    for face in &mut scene.faces {
        face.reflectance = Vec3::splat(reflectance);
    }
    scene
}

#[test]
fn what_does_not_converge_is_given_up() {
    let mesh = mesh(&white(0.99999), 1);
    // Single samples scaled to closures of 1 are not reciprocal, as conjugate gradients need them.
    let mut settings = settings(Iteration::Cg, 1e-6);
    settings.transport.conserve = true;
    settings.schedule.max_shots = 3000 * mesh.cells.len() as u32;
    let stuck = run(&mesh, &settings);
    assert!(stuck.stagnated && !stuck.converged);
    assert!((64..1500).contains(&stuck.passes), "{}", stuck.passes);
}

#[test]
fn what_rises_before_it_falls_is_not_given_up() {
    let mesh = mesh(&white(0.99), 1);
    let mut settings = settings(Iteration::Cg, 1e-6);
    settings.transport.conserve = true;
    let run = run(&mesh, &settings);
    assert!(run.converged && !run.stagnated && run.passes > 64);
}

#[test]
fn what_converges_slowly_is_not_given_up() {
    let mesh = mesh(&white(0.9999), 1);
    let mut settings = settings(Iteration::Chebyshev, 1e-6);
    settings.transport.conserve = true;
    settings.schedule.max_shots = 100 * mesh.cells.len() as u32;
    let run = run(&mesh, &settings);
    assert!(!run.stagnated && !run.converged);
    assert!(run.passes >= 100, "{}", run.passes);
}
