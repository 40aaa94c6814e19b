//! The same test of every engine.

use common::mesh::Mesh;
use common::passes::Engine;
use common::scene::Scene;
use common::settings::{Settings, Visibility};
use common::shooting::{Order, Run, Shot, solve};
use cpu::CpuSolver;
use gpu::{Gpu, GpuSolver};
use std::ops::ControlFlow;

/// Small enough for a hundred runs.
pub fn settings() -> Settings {
    Settings {
        texels: 6,
        cells: 2,
        item_buffer: 128,
        ..Settings::default()
    }
}

/// The same with the item buffer.
pub fn gpu_settings() -> Settings {
    Settings {
        visibility: Visibility::Stereographic,
        ..settings()
    }
}

/// The scene at these settings.
pub fn mesh_of(scene: &Scene) -> Mesh {
    let settings = settings();
    Mesh::uniform(scene, settings.texels, settings.cells).unwrap()
}

/// The GPU; a machine without one fails the test, it does not skip it.
pub fn gpu() -> Gpu {
    Gpu::open(None).unwrap()
}

/// A solver of either kind.
pub type AnyEngine<'m> = Box<dyn Engine + 'm>;

/// The same test of the CPU and of the GPU, each on a fresh engine whenever `test` asks.
pub fn each_engine<'m>(mesh: &'m Mesh, test: impl Fn(&str, &mut dyn FnMut() -> AnyEngine<'m>)) {
    let (cpu_settings, gpu_settings, gpu) = (settings(), gpu_settings(), gpu());
    test("cpu", &mut || Box::new(CpuSolver::new(mesh, &cpu_settings)));
    test("gpu", &mut || {
        Box::new(GpuSolver::new(&gpu, mesh, &gpu_settings).unwrap())
    });
}

/// A free run.
pub fn free(engine: &mut dyn Engine, settings: &Settings) -> Run {
    solve(engine, settings, &mut |_, _| ControlFlow::Continue(())).unwrap()
}

/// The shots of one call of `run`.
pub fn run(engine: &mut dyn Engine, order: Order, max_shots: u32) -> Vec<Shot> {
    let mut shots = Vec::new();
    engine
        .run(order, max_shots, &mut |shot| {
            shots.push(*shot);
            ControlFlow::Continue(())
        })
        .unwrap();
    shots
}

/// Greedy to the last watt.
pub const ALL: Order = Order::Greedy { threshold: 0.0 };
