//! Furnace: in a closed room where every face emits E and reflects ρ, B = E/(1−ρ) everywhere.

use common::cover::sampled;
use common::energy::Energy;
use common::mesh::Mesh;
use common::passes::Engine;
use common::settings::Settings;
use common::shooting::solve;
use cpu::CpuSolver;
use gpu::{Gpu, GpuSolver};
use radiosity_tests::engines::drawn;
use radiosity_tests::furnace;
use std::ops::ControlFlow;

fn check(engine: &mut dyn Engine, mesh: &Mesh, settings: &Settings) {
    let run = solve(engine, &settings.schedule, &mut |_, _| {
        ControlFlow::Continue(())
    })
    .unwrap();
    let energy = Energy::new(mesh, &run.field, &run.shots);
    let worst = run
        .field
        .radiosity
        .iter()
        .map(|b| (b.x / 2.0 - 1.0).abs())
        .fold(0.0, f32::max);
    println!(
        "{} shots {} worst {worst} escaped {:?} closure {} imbalance {}",
        run.field.origin,
        run.shots.len(),
        energy.escaped,
        energy.share(energy.closure),
        energy.imbalance
    );
    assert!(run.converged);
    assert!(worst < 0.01, "{worst}");
    assert!(energy.escaped[0] == 0.0);
}

#[test]
fn cpu() {
    let scene = furnace(0.5);
    let settings = Settings::default();
    let mesh = sampled(&scene, &settings.meshing).unwrap();
    check(
        &mut CpuSolver::new(&mesh, &settings.transport),
        &mesh,
        &settings,
    );
    // The twin draws every pixel on the CPU.
    let settings = settings.by(drawn(256));
    check(
        &mut CpuSolver::new(&mesh, &settings.transport),
        &mesh,
        &settings,
    );
}

#[test]
fn gpu() {
    let scene = furnace(0.5);
    let settings = Settings::default().by(drawn(1024));
    let mesh = sampled(&scene, &settings.meshing).unwrap();
    let gpu = Gpu::open(None).unwrap();
    let mut solver = GpuSolver::new(&gpu, &mesh, &settings.transport).unwrap();
    check(&mut solver, &mesh, &settings);
    println!("{:?}", solver.counts());
}
