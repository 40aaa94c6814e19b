//! Iterations by passes: all converge to the solution of single shots, in few passes.

use approx::abs_diff_eq;
use common::energy::EnergyBalance;
use common::mesh::Mesh;
use common::passes;
use common::scene::Scene;
use common::settings::{Iteration, Settings, Visibility};
use common::shooting::SolveRun;
use cpu::CpuSolver;
use glam::Vec3;
use radiosity_tests::bounds::U;
use radiosity_tests::engines::{
    ENGINE_KINDS, all_patches, both_engines, item_buffer, mesh_scene, settings_of, solve_by_schedule,
};
use radiosity_tests::{box_in_room, furnace, lit_room, paper_room};
use std::ops::ControlFlow;

const ALL: [Iteration; 3] = [Iteration::Southwell, Iteration::Chebyshev, Iteration::Cg];

fn settings(iteration: Iteration, epsilon: f64) -> Settings {
    let mut settings = settings_of([4, 2, 1], Visibility::Rays, epsilon);
    settings.schedule.iteration = iteration;
    settings
}

fn mesh(scene: &Scene, samples: u32) -> Mesh {
    mesh_scene(scene, &settings_of([4, 2, samples], Visibility::Rays, 1.0))
}

fn run(mesh: &Mesh, settings: &Settings) -> SolveRun {
    let mut solver = CpuSolver::new(mesh, &settings.transport);
    solve_by_schedule(&mut solver, mesh, &settings.schedule)
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
    let [cpu_rays, _, gpu_buffer, _] = ENGINE_KINDS;
    for (scene, samples, kind) in [
        (box_in_room(), 1, cpu_rays),
        (box_in_room(), 3, cpu_rays),
        (lit_room(), 1, cpu_rays),
        (lit_room(), 3, cpu_rays),
        (lit_room(), 3, gpu_buffer),
        (paper_room(), 1, cpu_rays),
        (paper_room(), 3, cpu_rays),
    ] {
        let mesh = mesh(&scene, samples);
        let solve = |settings: Settings| {
            let mut engine = kind.fresh_engine(&mesh, &settings, &[]);
            solve_by_schedule(engine.as_mut(), &mesh, &settings.schedule)
        };
        let limit = solve(settings(Iteration::Southwell, 1e-6));
        for iteration in ALL {
            let run = solve(settings(iteration, 1e-4));
            let name = format!("{}, {samples} samples, {}, {iteration:?}", scene.name, kind.name);
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
fn solve_that_ends_early_keeps_its_energy_balance() {
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
    }
}

/// The callback is called after every link and every pass: some of these stops are during linking, others after it.
#[test]
fn stopped_solve_keeps_its_energy_balance() {
    for (iteration, visibility) in [
        (Iteration::Cg, Visibility::Rays),
        (Iteration::Cg, item_buffer(128)),
        (Iteration::Chebyshev, Visibility::Rays),
    ] {
        let mut settings = settings_of([6, 2, 3], visibility, 1e-4);
        settings.schedule.iteration = iteration;
        let mesh = mesh_scene(&lit_room(), &settings);
        for mut engine in both_engines(&mesh, &settings.transport) {
            for stop in [1, 3, 30, mesh.patches.len() + 2] {
                let mut reported = 0;
                let run = passes::solve_by_schedule(engine.as_mut(), &mesh, &settings.schedule, &mut |_| {
                    reported += 1;
                    if reported < stop {
                        ControlFlow::Continue(())
                    } else {
                        ControlFlow::Break(())
                    }
                })
                .unwrap();
                assert!(!run.converged && reported >= stop);
                let energy = EnergyBalance::new(&mesh, &run.field, &run.shots);
                // Roundings: one per patch in H, one per texel in a sum; some are two.
                let bound = 4.0 * (mesh.patches.len() + 64) as f64 * U;
                assert!(energy.imbalance <= bound, "{stop}: {energy:?}");
            }
            let mut reported = Vec::new();
            let mut stop = |made| {
                reported.push(made);
                ControlFlow::Break(())
            };
            let closures = engine.make_links(&all_patches(&mesh), &mut stop).unwrap();
            // Two batches of eight patches may be under way, or eight patches per thread.
            let threads = std::thread::available_parallelism().map_or(1, |n| n.get());
            assert!((1..=8 * threads.max(2)).contains(&closures.len()));
            assert_eq!(reported, (1..=closures.len()).collect::<Vec<_>>());
        }
    }
}

/// Solves the lit room with this reflectance everywhere, in so many passes at most. Single samples scaled to closures
/// of 1 are not reciprocal, which conjugate gradients need.
fn run_in_white_room(reflectance: f32, iteration: Iteration, most_passes: u32) -> SolveRun {
    let mut scene = lit_room();
    for face in &mut scene.faces {
        face.reflectance = Vec3::splat(reflectance);
    }
    let mesh = mesh(&scene, 1);
    let mut settings = settings(iteration, 1e-6);
    settings.transport.conserve = true;
    settings.schedule.max_shots = most_passes * mesh.patches.len() as u32;
    run(&mesh, &settings)
}

#[test]
fn only_stagnation_ends_a_solve_before_its_last_pass() {
    let stuck = run_in_white_room(0.99999, Iteration::Cg, 3000);
    assert!(stuck.stagnated && !stuck.converged);
    assert!((64..1500).contains(&stuck.passes), "{}", stuck.passes);
    // The residual rises before it falls.
    let rising = run_in_white_room(0.99, Iteration::Cg, 3000);
    assert!(rising.converged && !rising.stagnated && rising.passes > 64);
    let slow = run_in_white_room(0.9999, Iteration::Chebyshev, 100);
    assert!(!slow.stagnated && !slow.converged);
    assert!(slow.passes >= 100, "{}", slow.passes);
}
