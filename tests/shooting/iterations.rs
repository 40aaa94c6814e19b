//! Iterations by passes: all converge to the solution of single shots, in few passes.

use approx::abs_diff_eq;
use common::cover;
use common::energy::EnergyBalance;
use common::mesh::Mesh;
use common::passes::solve_by_schedule;
use common::scene::Scene;
use common::settings::{Iteration, Meshing, Schedule, Settings};
use common::shooting::SolveRun;
use cpu::CpuSolver;
use glam::Vec3;
use radiosity_tests::{box_in_room, furnace, lit_room, paper_room};
use std::ops::ControlFlow;

const ALL: [Iteration; 3] = [Iteration::Southwell, Iteration::Chebyshev, Iteration::Cg];

fn settings(iteration: Iteration, epsilon: f64) -> Settings {
    Settings {
        meshing: Meshing {
            texels: 4,
            patches: 2,
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
    cover::sample_covers(&mut mesh, samples);
    mesh
}

fn run(mesh: &Mesh, settings: &Settings) -> SolveRun {
    let mut solver = CpuSolver::new(mesh, &settings.transport);
    solve_by_schedule(
        &mut solver,
        mesh,
        &settings.schedule,
        &mut |_| ControlFlow::Continue(()),
    )
    .unwrap()
}

/// Σ|H − H'|A over Σ H' A, all channels.
fn distance(mesh: &Mesh, a: &SolveRun, b: &SolveRun) -> f64 {
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
fn every_iteration_converges_to_the_solution_of_single_shots() {
    for scene in [box_in_room(), lit_room(), paper_room()] {
        for samples in [1, 3] {
            let mesh = mesh(&scene, samples);
            let limit = run(&mesh, &settings(Iteration::Southwell, 1e-6));
            for iteration in ALL {
                let run = run(&mesh, &settings(iteration, 1e-4));
                let name = format!("{}, {samples} samples, {iteration:?}", scene.name);
                assert!(run.converged && run.unshot_fraction() <= 1e-4, "{name}");
                assert!(!run.stagnated, "{name}");
                // Unshot light adds at most 1/(1 − ρ) times itself: ρ ≤ 0.8, and the received light is
                // at least the emitted light here.
                let bound = 2e-4 / (1.0 - 0.8);
                let off = distance(&mesh, &run, &limit);
                assert!(off > 0.0 || iteration == Iteration::Southwell, "{name}");
                assert!(off < bound, "{name}: {off:e} of {bound:e}");
                let energy = EnergyBalance::new(&mesh, &run.field, &run.shots);
                // f32 sums over a thousand texels and the links.
                assert!(energy.imbalance < 1e-5, "{name}: {:e}", energy.imbalance);
                assert!(run.shooters >= u64::from(run.passes), "{name}");
            }
        }
    }
}

#[test]
fn high_reflectance_needs_few_passes() {
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
fn furnace_converges_to_exact_radiosity() {
    // With two samples or more, near texels integrate their form factors.
    let scene = furnace(0.5);
    let mesh = mesh(&scene, 4);
    for iteration in ALL {
        let mut settings = settings(iteration, 1e-6);
        settings.transport.conserve = true;
        let run = run(&mesh, &settings);
        let mean = |v: &[glam::Vec4]| v.iter().map(|v| f64::from(v.x)).sum::<f64>() / v.len() as f64;
        // Every shot closes exactly, so the mean is exact within ε and f32.
        let b = mean(&run.field.radiosity);
        assert!(abs_diff_eq!(b, 2.0, epsilon = 1e-5), "{iteration:?}: {b}");
    }
}

#[test]
fn stopped_solve_keeps_its_energy_balance() {
    let mesh = mesh(&paper_room(), 1);
    for iteration in &ALL[1..] {
        for most in [1, 5, 40] {
            let mut settings = settings(*iteration, 1e-4);
            settings.schedule.max_shots = most;
            let run = run(&mesh, &settings);
            assert!(run.shooters == u64::from(most) && !run.converged);
            let energy = EnergyBalance::new(&mesh, &run.field, &run.shots);
            assert!(energy.imbalance < 1e-5, "{iteration:?}, {most}");
        }
        let settings = settings(*iteration, 1e-4);
        let mut solver = CpuSolver::new(&mesh, &settings.transport);
        let mut reported = Vec::new();
        let run = solve_by_schedule(&mut solver, &mesh, &settings.schedule, &mut |done| {
            reported.push(done);
            if done > 0.2 {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(())
            }
        })
        .unwrap();
        assert!(reported.last().is_some_and(|done| *done > 0.2) && !run.converged);
        let energy = EnergyBalance::new(&mesh, &run.field, &run.shots);
        assert!(energy.imbalance < 1e-5, "{iteration:?}");
        assert!(energy.share_of_emitted(energy.unshot) > 0.001);
    }
}

#[test]
fn dark_scene_needs_no_pass() {
    let mut scene = lit_room();
    for face in &mut scene.faces {
        face.emission = Vec3::ZERO;
    }
    let mesh = mesh(&scene, 1);
    let run = run(&mesh, &settings(Iteration::Cg, 1e-3));
    assert!(run.converged && run.passes == 0 && run.shots.is_empty());
}

#[test]
fn repeated_solve_is_bit_identical() {
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
fn stagnating_solve_ends_unconverged() {
    let mesh = mesh(&white(0.99999), 1);
    // Single samples scaled to closures of 1 are not reciprocal, which conjugate gradients need.
    let mut settings = settings(Iteration::Cg, 1e-6);
    settings.transport.conserve = true;
    settings.schedule.max_shots = 3000 * mesh.patches.len() as u32;
    let stuck = run(&mesh, &settings);
    assert!(stuck.stagnated && !stuck.converged);
    assert!((64..1500).contains(&stuck.passes), "{}", stuck.passes);
}

#[test]
fn residual_that_rises_before_it_falls_converges() {
    let mesh = mesh(&white(0.99), 1);
    let mut settings = settings(Iteration::Cg, 1e-6);
    settings.transport.conserve = true;
    let run = run(&mesh, &settings);
    assert!(run.converged && !run.stagnated && run.passes > 64);
}

#[test]
fn slow_convergence_is_not_stagnation() {
    let mesh = mesh(&white(0.9999), 1);
    let mut settings = settings(Iteration::Chebyshev, 1e-6);
    settings.transport.conserve = true;
    settings.schedule.max_shots = 100 * mesh.patches.len() as u32;
    let run = run(&mesh, &settings);
    assert!(!run.stagnated && !run.converged);
    assert!(run.passes >= 100, "{}", run.passes);
}
