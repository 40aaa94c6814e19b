//! What `solve` answers, on few texels.

use crate::matrices::assemble;
use crate::{lit_room, room, scene};
use common::mesh::Mesh;
use common::scene::{Face, Scene};
use common::settings::{Iteration, Meshing, Schedule, Settings};
use common::shooting::Field;
use glam::{DVec3, Vec3};
use oracle::judge::diff::pair::Pair;
use oracle::judge::diff::reflected::Reflected;
use oracle::solve::dense;
use oracle::solve::solver::Solver;
use oracle::solve::watch::unwatched;
use oracle::solve::{Answer, Question, answer};

const GREY: Vec3 = Vec3::splat(0.7);

/// 8×8 texels, 4 samples.
pub fn settings() -> Settings {
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

/// The CPU's answer.
pub fn solved(scene: &Scene, settings: &Settings) -> Answer {
    let question = Question {
        task: scene,
        settings,
        solver: Solver::Cpu,
    };
    answer(&question, &unwatched()).unwrap()
}

/// A lit room, cut in two by a wall with a slit.
pub fn slit() -> Scene {
    let mut all = room(DVec3::ZERO, DVec3::ONE, true, Vec3::ZERO, GREY);
    all[1].emission = Vec3::splat(3.0);
    for [x0, x1] in [[0.0, 0.45], [0.55, 1.0]] {
        let p = |x, z| DVec3::new(x, 0.5, z);
        let corners = [p(x0, 0.0), p(x0, 1.0), p(x1, 1.0), p(x1, 0.0)];
        let up = Face::quad("wall", corners, Vec3::ZERO, GREY);
        all.push(up.reversed());
        all.push(up);
    }
    scene("a slit", all)
}

/// The lit room with its box on the floor.
pub fn standing() -> Scene {
    let mut scene = lit_room();
    scene.name = "a box on the floor".into();
    for face in &mut scene.faces[6..] {
        for corner in &mut face.corners {
            corner.y -= 0.25;
        }
    }
    scene
}

/// Relative RMS against a matrix of twice the texels.
pub fn error(scene: &Scene, answer: &Answer, truth: &(Mesh, Field)) -> f64 {
    let ours = Reflected::of(scene, &answer.solved.mesh, &answer.solved.run.field);
    let theirs = Reflected::of(scene, &truth.0, &truth.1);
    Pair::new(&ours, &theirs, None).unwrap().worst().0
}

/// The matrix's, on sixteen texels a side.
pub fn truth(scene: &Scene) -> (Mesh, Field) {
    truth_on(scene, 16)
}

/// The matrix's, on that many.
pub fn truth_on(scene: &Scene, side: u32) -> (Mesh, Field) {
    let (mesh, matrix, _) = assemble(scene, side);
    let field = dense::by(&mesh, &matrix).unwrap().0.field;
    (mesh, field)
}
