//! Settings, and engines (CPU and GPU, rays and item buffer) made alike for tests that run on all of them.

use common::cover::sampled_mesh;
use common::mesh::Mesh;
use common::passes::{self, Engine, PatchClosure};
use common::scene::Scene;
use common::settings::{ItemBufferProjection, Meshing, Schedule, Settings, Transport, Visibility};
use common::shooting::{Shot, ShotOrder, SolveRun, shoot_until_converged};
use cpu::CpuSolver;
use gpu::{Gpu, GpuSolver, ShaderFault};
use std::ops::ControlFlow;
use std::sync::OnceLock;

/// Returns settings of so many texels and patches per side and samples, with ε.
pub fn settings_of([texels, patches, samples]: [u32; 3], visibility: Visibility, epsilon: f64) -> Settings {
    let mut settings = Settings::default().with_visibility(visibility);
    settings.meshing = Meshing {
        texels,
        patches,
        samples,
    };
    settings.schedule.epsilon = epsilon;
    settings
}

/// Returns settings small enough for a hundred runs.
pub fn engine_settings() -> Settings {
    settings_of([6, 2, 1], Visibility::Rays, Schedule::default().epsilon)
}

/// Returns visibility by a stereographic item buffer of `size` pixels per side.
pub const fn item_buffer(size: u32) -> Visibility {
    Visibility::with_item_buffer(ItemBufferProjection::Stereographic, size)
}

/// Returns visibility by a hemicube of `size` pixels per side.
pub const fn hemicube(size: u32) -> Visibility {
    Visibility::with_item_buffer(ItemBufferProjection::Hemicube, size)
}

/// Meshes a scene by these settings.
pub fn mesh_scene(scene: &Scene, settings: &Settings) -> Mesh {
    sampled_mesh(scene, &settings.meshing).unwrap()
}

/// Meshes a scene by [`engine_settings`].
pub fn mesh_of(scene: &Scene) -> Mesh {
    mesh_scene(scene, &engine_settings())
}

/// Returns the process's GPU; a machine without one fails the test.
pub fn shared_gpu() -> &'static Gpu {
    static GPU: OnceLock<Gpu> = OnceLock::new();
    GPU.get_or_init(|| Gpu::open(None).expect("the tests need an adapter: see scripts/driver.sh"))
}

/// Makes a solver on the GPU, with faults planted in its shaders.
pub fn gpu_solver<'m>(mesh: &'m Mesh, transport: &Transport, faults: &[ShaderFault]) -> GpuSolver<'m> {
    GpuSolver::with_faults(shared_gpu(), mesh, transport, faults).unwrap()
}

/// An engine of any kind.
pub type AnyEngine<'m> = Box<dyn Engine + 'm>;

/// Makes the CPU's engine and the GPU's.
pub fn both_engines<'m>(mesh: &'m Mesh, transport: &Transport) -> [AnyEngine<'m>; 2] {
    [
        Box::new(CpuSolver::new(mesh, transport)),
        Box::new(gpu_solver(mesh, transport, &[])),
    ]
}

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
            Box::new(gpu_solver(mesh, &transport, faults))
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

/// Shoots on the CPU until the schedule ends.
pub fn shoot_on_cpu(mesh: &Mesh, settings: &Settings) -> SolveRun {
    shoot_freely(&mut CpuSolver::new(mesh, &settings.transport), &settings.schedule)
}

/// Solves by the schedule's iteration until it ends.
pub fn solve_by_schedule(engine: &mut dyn Engine, mesh: &Mesh, schedule: &Schedule) -> SolveRun {
    passes::solve_by_schedule(engine, mesh, schedule, &mut |_| ControlFlow::Continue(())).unwrap()
}

/// Returns the shots of one call of `run`.
pub fn run_shots(engine: &mut dyn Engine, order: ShotOrder, max_shots: u32) -> Vec<Shot> {
    let mut shots = Vec::new();
    let mut keep_shot = |shot: &Shot| {
        shots.push(*shot);
        ControlFlow::Continue(())
    };
    engine.run(order, max_shots, &mut keep_shot).unwrap();
    shots
}

/// Order by largest unshot power until nothing is unshot.
pub const GREEDY_TO_ZERO: ShotOrder = ShotOrder::Greedy { threshold: 0.0 };

/// Returns the indices of all patches.
pub fn all_patches(mesh: &Mesh) -> Vec<u32> {
    (0..mesh.patches.len() as u32).collect()
}

/// Makes the links of these patches.
pub fn make_links(engine: &mut dyn Engine, patches: &[u32]) -> Vec<PatchClosure> {
    engine.make_links(patches, &mut |_| ControlFlow::Continue(())).unwrap()
}
