//! Rooms and engines of the benchmarks.

pub mod accuracy;
pub mod rays;

use accuracy::{AccuracyTarget, run_solve};
use common::form_factor::FormFactor;
use common::import::{ImportOptions, load_scene};
use common::mesh::Mesh;
use common::passes::Engine;
use common::scene::Scene;
use common::settings::{ItemBufferSettings, Iteration, Meshing, Schedule, Settings, Transport, Visibility};
use common::shooting::{ShotOrder, SolveRun};
use cpu::CpuSolver;
use gpu::{Gpu, GpuSolver};
use radiosity_tests::{furnace, paper_room};
use std::ops::ControlFlow;
use std::path::Path;
use std::time::{Duration, Instant};

/// Error of a timed solve: relative RMS of B − E.
const ERROR_BOUND: f64 = 0.1;

/// A room on a given resolution.
pub struct BenchRoom {
    /// Name in the tables.
    pub name: String,
    /// Mesh and truth.
    pub target: AccuracyTarget,
    /// Settings of a solve to 10 %.
    settings: Settings,
}

/// Engine under test.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BenchSolver {
    /// CPU, rays.
    Rays,
    /// CPU, scalar item buffer: the twin of the shaders.
    Twin,
    /// GPU, item buffer.
    Gpu,
}

impl BenchSolver {
    /// All engines.
    pub const ALL: [Self; 3] = [Self::Rays, Self::Twin, Self::Gpu];

    /// Returns the name in the tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Rays => "CPU rays",
            Self::Twin => "CPU twin",
            Self::Gpu => "GPU",
        }
    }
}

/// Loads the bundled scene of this file name.
pub fn bundled_scene(name: &str) -> Scene {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes");
    load_scene(&folder.join(name), &ImportOptions::default()).expect("bundled scenes are sound")
}

/// Returns three scenes and their texels per side: 1 536, 39 936 and 172 032 texels in all.
pub fn bench_scenes() -> [(Scene, u32); 3] {
    [
        (furnace(0.7), 16),
        (paper_room(), 16),
        (bundled_scene("paper_room_objects.obj"), 32),
    ]
}

/// Returns the rooms of all scenes.
pub fn bench_rooms() -> Vec<BenchRoom> {
    bench_scenes().into_iter().map(make_room).collect()
}

fn make_room((scene, texels): (Scene, u32)) -> BenchRoom {
    let mesh = Mesh::uniform(&scene, texels, 1).expect("the rooms are sound");
    let target = AccuracyTarget::new(mesh, whole_faces(texels));
    BenchRoom {
        name: format!("{} faces {texels}²", scene.faces.len()),
        settings: target.settings_to(ERROR_BOUND),
        target,
    }
}

/// Returns the paper's settings: whole faces, disc factors between centres, rays.
pub fn whole_faces(texels: u32) -> Settings {
    Settings {
        meshing: Meshing {
            texels,
            patches: 1,
            ..Meshing::default()
        },
        transport: Transport {
            form_factor: FormFactor::Disc,
            ..Transport::default()
        },
        schedule: Schedule {
            iteration: Iteration::Cg,
            ..Schedule::default()
        },
        ..Settings::default()
    }
}

fn solver_settings(room: &BenchRoom, solver: BenchSolver) -> Settings {
    let visibility = if solver == BenchSolver::Rays {
        Visibility::Rays
    } else {
        Visibility::ItemBuffer(ItemBufferSettings::DEFAULT)
    };
    Settings {
        transport: Transport {
            visibility,
            ..room.settings.transport
        },
        ..room.settings
    }
}

fn make_engine<'a>(room: &'a BenchRoom, solver: BenchSolver, gpu: &Gpu) -> Box<dyn Engine + 'a> {
    let (mesh, settings) = (&room.target.mesh, solver_settings(room, solver));
    match solver {
        BenchSolver::Gpu => Box::new(GpuSolver::new(gpu, mesh, &settings.transport).expect("the rooms fit any GPU")),
        _ => Box::new(CpuSolver::new(mesh, &settings.transport)),
    }
}

/// Times `count` shots in one run on a fresh engine.
pub fn time_shots(room: &BenchRoom, solver: BenchSolver, gpu: &Gpu, count: u32) -> Duration {
    let mut engine = make_engine(room, solver, gpu);
    let log: Vec<u32> = (0..count).map(|k| k % room.target.mesh.patches.len() as u32).collect();
    let start = Instant::now();
    engine
        .run(ShotOrder::Replay(&log), count, &mut |_| ControlFlow::Continue(()))
        .expect("shots succeed");
    start.elapsed()
}

/// Times a solve to 10 % on a fresh engine and returns it.
pub fn time_solve(room: &BenchRoom, solver: BenchSolver, gpu: &Gpu) -> (Duration, SolveRun) {
    let mut engine = make_engine(room, solver, gpu);
    let start = Instant::now();
    let run = run_solve(&mut *engine, &room.target.mesh, &solver_settings(room, solver));
    (start.elapsed(), run)
}
