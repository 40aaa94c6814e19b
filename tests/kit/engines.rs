//! Every engine (CPU and GPU, rays and item buffer), made alike for tests that run on all of them.

use common::cover::sampled_mesh;
use common::mesh::Mesh;
use common::passes::Engine;
use common::scene::Scene;
use common::settings::{ItemBufferProjection, Meshing, Raster, Schedule, Settings, Visibility};
use common::shooting::{Shot, ShotOrder, SolveRun, shoot_until_converged};
use cpu::CpuSolver;
use gpu::{Gpu, GpuSolver, ShaderFault};
use std::ops::ControlFlow;
use std::sync::OnceLock;

/// Returns settings small enough for a hundred runs.
pub fn engine_settings() -> Settings {
    Settings {
        meshing: Meshing {
            texels: 6,
            patches: 2,
            ..Meshing::default()
        },
        ..Settings::default()
    }
}

/// Returns the same settings with an item buffer.
pub fn item_buffer_settings() -> Settings {
    engine_settings().with_visibility(item_buffer(128))
}

/// Returns visibility by a stereographic item buffer of `size` pixels per side.
pub const fn item_buffer(size: u32) -> Visibility {
    Visibility::with_item_buffer(ItemBufferProjection::Stereographic(Raster::Pixel), size)
}

/// Meshes a scene by [`engine_settings`].
pub fn mesh_of(scene: &Scene) -> Mesh {
    sampled_mesh(scene, &engine_settings().meshing).unwrap()
}

/// Opens the GPU; a machine without one fails the test.
pub fn open_gpu() -> Gpu {
    Gpu::open(None).unwrap()
}

/// Returns the process's shared device, for tests that make many engines.
pub fn shared_gpu() -> &'static Gpu {
    static GPU: OnceLock<Gpu> = OnceLock::new();
    GPU.get_or_init(open_gpu)
}

/// An engine of any kind.
pub type AnyEngine<'m> = Box<dyn Engine + 'm>;

/// Device and visibility of an engine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EngineKind {
    /// For messages.
    pub name: &'static str,
    /// True on the GPU, false on the CPU.
    pub on_gpu: bool,
    /// Rays or an item buffer.
    pub visibility: Visibility,
}

/// All engines. On the CPU an item buffer is drawn by its scalar twin.
pub const ENGINE_KINDS: [EngineKind; 4] = [
    engine_kind("cpu rays", false, Visibility::Rays),
    engine_kind("cpu twin", false, item_buffer(128)),
    engine_kind("gpu item buffer", true, item_buffer(128)),
    engine_kind("gpu rays", true, Visibility::Rays),
];

const fn engine_kind(name: &'static str, on_gpu: bool, visibility: Visibility) -> EngineKind {
    EngineKind {
        name,
        on_gpu,
        visibility,
    }
}

impl EngineKind {
    /// Makes an engine.
    pub fn fresh_engine<'m>(&self, mesh: &'m Mesh, settings: &Settings, faults: &[ShaderFault]) -> AnyEngine<'m> {
        let transport = settings.with_visibility(self.visibility).transport;
        if self.on_gpu {
            Box::new(GpuSolver::with_faults(shared_gpu(), mesh, &transport, faults).unwrap())
        } else {
            assert!(faults.is_empty(), "faults are planted in shaders");
            Box::new(CpuSolver::new(mesh, &transport))
        }
    }
}

/// Runs `test` with the name of every engine and a function that makes one.
pub fn each_engine<'m>(mesh: &'m Mesh, test: impl Fn(&str, &mut dyn FnMut() -> AnyEngine<'m>)) {
    for kind in ENGINE_KINDS {
        test(kind.name, &mut || kind.fresh_engine(mesh, &engine_settings(), &[]));
    }
}

/// Shoots until the schedule ends.
pub fn shoot_freely(engine: &mut dyn Engine, schedule: &Schedule) -> SolveRun {
    shoot_until_converged(engine, schedule, &mut |_, _| ControlFlow::Continue(())).unwrap()
}

/// Returns the shots of one call of `run`.
pub fn run_shots(engine: &mut dyn Engine, order: ShotOrder, max_shots: u32) -> Vec<Shot> {
    let mut shots = Vec::new();
    engine
        .run(order, max_shots, &mut |shot| {
            shots.push(*shot);
            ControlFlow::Continue(())
        })
        .unwrap();
    shots
}

/// Order by largest unshot power until nothing is unshot.
pub const GREEDY_TO_ZERO: ShotOrder = ShotOrder::Greedy { threshold: 0.0 };
