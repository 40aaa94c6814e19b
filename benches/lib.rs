//! What is measured: three rooms, three engines.

pub mod accuracy;
pub mod rays;

use accuracy::{Target, run};
use common::form_factor::FormFactor;
use common::import::{ImportOptions, load};
use common::mesh::Mesh;
use common::passes::Engine;
use common::scene::Scene;
use common::settings::{Drawing, Iteration, Meshing, Schedule, Settings, Transport, Visibility};
use common::shooting::{Order, Run};
use cpu::CpuSolver;
use gpu::{Gpu, GpuSolver};
use radiosity_tests::{furnace, paper_room};
use std::ops::ControlFlow;
use std::path::Path;
use std::time::{Duration, Instant};

/// The error of a solve: relative RMS of B − E.
const BOUND: f64 = 0.1;

/// A room at a resolution.
pub struct Room {
    /// For the tables.
    pub name: String,
    /// Its texels and where a solve must end.
    pub target: Target,
    /// How it is solved to 10 %.
    settings: Settings,
}

/// Who computes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Solver {
    /// CPU, rays.
    Rays,
    /// CPU, item buffer: the twin of the shaders.
    Twin,
    /// GPU, item buffer.
    Gpu,
}

impl Solver {
    /// All three.
    pub const ALL: [Self; 3] = [Self::Rays, Self::Twin, Self::Gpu];

    /// For the tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Rays => "CPU rays",
            Self::Twin => "CPU twin",
            Self::Gpu => "GPU",
        }
    }
}

/// The bundled scene of this file name.
pub fn bundled(name: &str) -> Scene {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes");
    load(&folder.join(name), &ImportOptions::default()).expect("bundled scenes are sound")
}

/// Three sizes of scene and texels a side: 1 536, 39 936 and 172 032 texels.
pub fn sizes() -> [(Scene, u32); 3] {
    [
        (furnace(0.7), 16),
        (paper_room(), 16),
        (bundled("paper_room_objects.obj"), 32),
    ]
}

/// All sizes as rooms.
pub fn rooms() -> Vec<Room> {
    sizes().into_iter().map(room).collect()
}

fn room((scene, texels): (Scene, u32)) -> Room {
    let mesh = Mesh::uniform(&scene, texels, 1).expect("the rooms are sound");
    let target = Target::new(mesh, whole_faces(texels));
    Room {
        name: format!("{} faces {texels}²", scene.faces.len()),
        settings: target.settings_to(BOUND),
        target,
    }
}

/// The paper's way: whole faces, disc factors, centre to centre, rays.
pub fn whole_faces(texels: u32) -> Settings {
    Settings {
        meshing: Meshing {
            texels,
            cells: 1,
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

fn settings(room: &Room, solver: Solver) -> Settings {
    let visibility = if solver == Solver::Rays {
        Visibility::Rays
    } else {
        Visibility::Drawn(Drawing::DEFAULT)
    };
    Settings {
        transport: Transport {
            visibility,
            ..room.settings.transport
        },
        ..room.settings
    }
}

fn engine<'a>(room: &'a Room, solver: Solver, gpu: &Gpu) -> Box<dyn Engine + 'a> {
    let (mesh, settings) = (&room.target.mesh, settings(room, solver));
    match solver {
        Solver::Gpu => {
            Box::new(GpuSolver::new(gpu, mesh, &settings.transport).expect("the rooms fit any GPU"))
        }
        _ => Box::new(CpuSolver::new(mesh, &settings.transport)),
    }
}

/// The time of `count` shots in one run on a fresh engine.
pub fn shots(room: &Room, solver: Solver, gpu: &Gpu, count: u32) -> Duration {
    let mut engine = engine(room, solver, gpu);
    let log: Vec<u32> = (0..count)
        .map(|k| k % room.target.mesh.cells.len() as u32)
        .collect();
    let start = Instant::now();
    engine
        .run(Order::Replay(&log), count, &mut |_| {
            ControlFlow::Continue(())
        })
        .expect("shots succeed");
    start.elapsed()
}

/// The time of a solve to 10 % on a fresh engine, and the solve.
pub fn whole(room: &Room, solver: Solver, gpu: &Gpu) -> (Duration, Run) {
    let mut engine = engine(room, solver, gpu);
    let start = Instant::now();
    let run = run(&mut *engine, &room.target.mesh, &settings(room, solver));
    (start.elapsed(), run)
}
