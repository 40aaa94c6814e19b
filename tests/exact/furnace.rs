//! Furnace: in a closed room where every face emits E and reflects ρ, B = E/(1−ρ) everywhere.

use common::cover::sampled_mesh;
use common::energy::EnergyBalance;
use common::mesh::Mesh;
use common::passes::Engine;
use common::settings::Settings;
use common::shooting::shoot_until_converged;
use cpu::CpuSolver;
use gpu::{Gpu, GpuSolver};
use radiosity_tests::engines::item_buffer;
use radiosity_tests::furnace;
use std::ops::ControlFlow;

fn check_furnace(engine: &mut dyn Engine, mesh: &Mesh, settings: &Settings) {
    let run = shoot_until_converged(engine, &settings.schedule, &mut |_, _| ControlFlow::Continue(())).unwrap();
    let energy = EnergyBalance::new(mesh, &run.field, &run.shots);
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
        energy.share_of_emitted(energy.closure),
        energy.imbalance
    );
    assert!(run.converged);
    assert!(worst < 0.01, "{worst}");
    assert!(energy.escaped[0] == 0.0);
}

#[test]
fn cpu_furnace_radiosity_is_exact() {
    let scene = furnace(0.5);
    let settings = Settings::default();
    let mesh = sampled_mesh(&scene, &settings.meshing).unwrap();
    check_furnace(&mut CpuSolver::new(&mesh, &settings.transport), &mesh, &settings);
    // The shader twin draws every pixel on the CPU.
    let settings = settings.with_visibility(item_buffer(256));
    check_furnace(&mut CpuSolver::new(&mesh, &settings.transport), &mesh, &settings);
}

#[test]
fn gpu_furnace_radiosity_is_exact() {
    let scene = furnace(0.5);
    let settings = Settings::default().with_visibility(item_buffer(1024));
    let mesh = sampled_mesh(&scene, &settings.meshing).unwrap();
    let gpu = Gpu::open(None).unwrap();
    let mut solver = GpuSolver::new(&gpu, &mesh, &settings.transport).unwrap();
    check_furnace(&mut solver, &mesh, &settings);
    println!("{:?}", solver.queue_counts());
}
