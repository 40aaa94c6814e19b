//! The same test of every engine.

use common::cover::sampled;
use common::mesh::Mesh;
use common::passes::Engine;
use common::scene::Scene;
use common::settings::{Meshing, Projection, Raster, Schedule, Settings, Visibility};
use common::shooting::{Order, Run, Shot, solve};
use cpu::CpuSolver;
use gpu::{Fault, Gpu, GpuSolver};
use std::ops::ControlFlow;
use std::sync::OnceLock;

/// Small enough for a hundred runs.
pub fn settings() -> Settings {
    Settings {
        meshing: Meshing {
            texels: 6,
            cells: 2,
            ..Meshing::default()
        },
        ..Settings::default()
    }
}

/// The same with the item buffer.
pub fn gpu_settings() -> Settings {
    settings().by(drawn(128))
}

/// By a stereographic item buffer of so many pixels a side.
pub const fn drawn(size: u32) -> Visibility {
    Visibility::drawn(Projection::Stereographic(Raster::Pixel), size)
}

/// The scene at these settings.
pub fn mesh_of(scene: &Scene) -> Mesh {
    sampled(scene, &settings().meshing).unwrap()
}

/// The GPU; a machine without one fails the test, it does not skip it.
pub fn gpu() -> Gpu {
    Gpu::open(None).unwrap()
}

/// The one device of a program, for tests that make many solvers.
pub fn shared_gpu() -> &'static Gpu {
    static GPU: OnceLock<Gpu> = OnceLock::new();
    GPU.get_or_init(gpu)
}

/// A solver of any kind.
pub type AnyEngine<'m> = Box<dyn Engine + 'm>;

/// Who solves, and how it sees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kind {
    /// For messages.
    pub name: &'static str,
    /// Or on the CPU.
    pub on_gpu: bool,
    /// By rays, or by an item buffer.
    pub visibility: Visibility,
}

/// Every engine. On the CPU an item buffer is drawn by its scalar twin.
pub const KINDS: [Kind; 4] = [
    kind("cpu rays", false, Visibility::Rays),
    kind("cpu twin", false, drawn(128)),
    kind("gpu item buffer", true, drawn(128)),
    kind("gpu rays", true, Visibility::Rays),
];

const fn kind(name: &'static str, on_gpu: bool, visibility: Visibility) -> Kind {
    Kind {
        name,
        on_gpu,
        visibility,
    }
}

impl Kind {
    /// A fresh solver.
    pub fn engine<'m>(
        &self,
        mesh: &'m Mesh,
        settings: &Settings,
        faults: &[Fault],
    ) -> AnyEngine<'m> {
        let transport = settings.by(self.visibility).transport;
        if self.on_gpu {
            Box::new(GpuSolver::with_faults(shared_gpu(), mesh, &transport, faults).unwrap())
        } else {
            assert!(faults.is_empty(), "faults are planted in shaders");
            Box::new(CpuSolver::new(mesh, &transport))
        }
    }
}

/// The same test of every engine, each a fresh one whenever `test` asks.
pub fn each_engine<'m>(mesh: &'m Mesh, test: impl Fn(&str, &mut dyn FnMut() -> AnyEngine<'m>)) {
    for kind in KINDS {
        test(kind.name, &mut || kind.engine(mesh, &settings(), &[]));
    }
}

/// A free run.
pub fn free(engine: &mut dyn Engine, schedule: &Schedule) -> Run {
    solve(engine, schedule, &mut |_, _| ControlFlow::Continue(())).unwrap()
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
