//! What is measured: two rooms, two resolutions, three engines.

pub mod accuracy;
pub mod rays;

use common::mesh::Mesh;
use common::scene::Scene;
use common::settings::{Settings, Visibility};
use common::shooting::{Engine, Order, solve};
use cpu::CpuSolver;
use gpu::{Gpu, GpuSolver};
use radiosity_tests::{furnace, paper_room};
use std::ops::ControlFlow;
use std::time::{Duration, Instant};

/// A room at a resolution.
pub struct Room {
    /// For the tables.
    pub name: String,
    /// Its texels.
    pub mesh: Mesh,
    /// Unshot share at which a solve ends: the larger room takes hundreds of shots to the usual one.
    pub epsilon: f64,
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

/// The cube of 6 and the paper's room of 156 faces, at 16² and 32² texels a face.
pub fn rooms() -> Vec<Room> {
    let scenes: [(Scene, f64); 2] = [(furnace(0.7), 0.3), (paper_room(), 0.5)];
    scenes
        .iter()
        .flat_map(|(scene, epsilon)| [16, 32].map(|texels| (scene, *epsilon, texels)))
        .map(|(scene, epsilon, texels)| Room {
            name: format!("{} faces {texels}²", scene.faces.len()),
            mesh: Mesh::uniform(scene, texels, 1).expect("the rooms are sound"),
            epsilon,
        })
        .collect()
}

fn settings(room: &Room, solver: Solver) -> Settings {
    let visibility = if solver == Solver::Rays {
        Visibility::Rays
    } else {
        Visibility::Stereographic
    };
    Settings {
        cells: 1,
        visibility,
        epsilon: room.epsilon,
        ..Settings::default()
    }
}

fn engine<'a>(room: &'a Room, solver: Solver, gpu: &Gpu) -> Box<dyn Engine + 'a> {
    let settings = settings(room, solver);
    match solver {
        Solver::Gpu => {
            Box::new(GpuSolver::new(gpu, &room.mesh, &settings).expect("the rooms fit any GPU"))
        }
        _ => Box::new(CpuSolver::new(&room.mesh, &settings)),
    }
}

/// The time of `count` shots in one run on a fresh engine.
pub fn shots(room: &Room, solver: Solver, gpu: &Gpu, count: u32) -> Duration {
    let mut engine = engine(room, solver, gpu);
    let log: Vec<u32> = (0..count)
        .map(|k| k % room.mesh.cells.len() as u32)
        .collect();
    let start = Instant::now();
    engine
        .run(Order::Replay(&log), count, &mut |_| {
            ControlFlow::Continue(())
        })
        .expect("shots succeed");
    start.elapsed()
}

/// The time of a solve on a fresh engine, and its shots.
pub fn whole(room: &Room, solver: Solver, gpu: &Gpu) -> (Duration, usize) {
    let mut engine = engine(room, solver, gpu);
    let start = Instant::now();
    let run = solve(&mut *engine, &settings(room, solver), &mut |_, _| {
        ControlFlow::Continue(())
    })
    .expect("solves succeed");
    (start.elapsed(), run.shots.len())
}
