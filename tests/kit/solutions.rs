//! Solutions of small scenes by the CPU and by the dense solver.

use crate::dense::assemble_dense;
use crate::{box_faces, lit_room, named_scene};
use common::mesh::Mesh;
use common::scene::{Face, Scene};
use common::settings::{Iteration, Meshing, Schedule, Settings};
use common::shooting::RadiosityField;
use glam::{DVec3, Vec3};
use oracle::diff::pair::GridPair;
use oracle::diff::reflected::ReflectedField;
use oracle::solve::dense;
use oracle::solve::progress::without_progress;
use oracle::solve::solver::SolverChoice;
use oracle::solve::{SolveAnswer, SolveRequest, solve_request};

const GREY: Vec3 = Vec3::splat(0.7);

/// Returns settings of 8×8 texels and 4 samples.
pub fn solve_settings() -> Settings {
    Settings {
        meshing: Meshing {
            texels: 8,
            samples: 4,
            ..Meshing::default()
        },
        schedule: Schedule {
            iteration: Iteration::Cg,
            ..Schedule::default()
        },
        ..Settings::default()
    }
}

/// Solves a scene by shooting on the CPU.
pub fn solve_on_cpu(scene: &Scene, settings: &Settings) -> SolveAnswer {
    let question = SolveRequest {
        task: scene,
        settings,
        solver: SolverChoice::Cpu,
    };
    solve_request(&question, &without_progress()).unwrap()
}

/// Makes a lit room, divided by a wall with a slit.
pub fn slit_room() -> Scene {
    let mut all = box_faces(DVec3::ZERO, DVec3::ONE, true, Vec3::ZERO, GREY);
    all[1].emission = Vec3::splat(3.0);
    for [x0, x1] in [[0.0, 0.45], [0.55, 1.0]] {
        let p = |x, z| DVec3::new(x, 0.5, z);
        let corners = [p(x0, 0.0), p(x0, 1.0), p(x1, 1.0), p(x1, 0.0)];
        let up = Face::quad("wall", corners, Vec3::ZERO, GREY);
        all.push(up.reversed());
        all.push(up);
    }
    named_scene("a slit", all)
}

/// Makes the lit room with its box on the floor.
pub fn room_with_standing_box() -> Scene {
    let mut scene = lit_room();
    scene.name = "a box on the floor".into();
    for face in &mut scene.faces[6..] {
        for corner in &mut face.corners {
            corner.y -= 0.25;
        }
    }
    scene
}

/// Returns the relative RMS error of an answer against `truth`.
pub fn error_against(scene: &Scene, answer: &SolveAnswer, truth: &(Mesh, RadiosityField)) -> f64 {
    let ours = ReflectedField::from_field(scene, &answer.solved.mesh, &answer.solved.run.field);
    let theirs = ReflectedField::from_field(scene, &truth.0, &truth.1);
    GridPair::new(&ours, &theirs, None).unwrap().worst_channel().0
}

/// Solves a scene by the dense solver on 16×16 texels.
pub fn dense_truth(scene: &Scene) -> (Mesh, RadiosityField) {
    dense_truth_on(scene, 16)
}

/// Solves a scene by the dense solver on `side`×`side` texels.
pub fn dense_truth_on(scene: &Scene, side: u32) -> (Mesh, RadiosityField) {
    let (mesh, matrix, _) = assemble_dense(scene, side);
    let field = dense::solve_system(&mesh, &matrix).unwrap().0.field;
    (mesh, field)
}
