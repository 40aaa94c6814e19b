//! Solutions of small scenes by the CPU and by the dense solver.

use crate::dense::assemble_dense;
use crate::engines::settings_of;
use crate::factor_cases::rectangle;
use crate::{box_faces, lit_room, named_scene};
use common::mesh::Mesh;
use common::scene::{Face, Scene};
use common::settings::{Iteration, Settings, Visibility};
use common::shooting::RadiosityField;
use glam::{DVec3, Vec3};
use oracle::diff::pair::GridPair;
use oracle::diff::reflected::ReflectedField;
use oracle::solve::dense;
use oracle::solve::progress::without_progress;
use oracle::solve::solver::{ErrorTarget, SolverChoice};
use oracle::solve::{SolveAnswer, SolveRequest, solve_request};
use radiosity::studies::random::{FaceShapes, draw_scene};

const GREY_REFLECTANCE: Vec3 = Vec3::splat(0.7);

/// Returns settings of 8×8 texels and 4 samples.
pub fn solve_settings() -> Settings {
    let mut settings = settings_of([8, 4, 4], Visibility::Rays, 1e-3);
    settings.schedule.iteration = Iteration::Cg;
    settings
}

/// All shapes of random scenes' faces.
pub const FACE_SHAPES: [FaceShapes; 3] = [FaceShapes::Quads, FaceShapes::Triangles, FaceShapes::Mixed];

/// Draws a random scene of such faces.
pub fn drawn_scene(seed: u64, faces: FaceShapes) -> Scene {
    draw_scene(seed, faces).scene
}

/// Solves a scene by shooting on the CPU.
pub fn solve_on_cpu(scene: &Scene, settings: &Settings) -> SolveAnswer {
    solve_by(scene, settings, SolverChoice::Cpu)
}

/// Solves a scene by the hierarchical solver to this error on `texels`×`texels`.
pub fn solve_to_error(scene: &Scene, error: f64, texels: u32) -> SolveAnswer {
    let mut settings = solve_settings();
    settings.meshing.texels = texels;
    let target = ErrorTarget {
        error,
        texels: Some(texels),
    };
    solve_by(scene, &settings, SolverChoice::Hierarchy(target))
}

fn solve_by(scene: &Scene, settings: &Settings, solver: SolverChoice) -> SolveAnswer {
    let question = SolveRequest {
        task: scene,
        settings,
        solver,
    };
    solve_request(&question, &without_progress()).unwrap()
}

/// Makes a closed room with a lit ceiling and thin horizontal plates at heights y, given by their ranges of x and z.
pub fn room_with_plates(name: &str, plates: &[(f64, [f64; 4])]) -> Scene {
    let mut faces = box_faces(DVec3::ZERO, DVec3::ONE, true, Vec3::ZERO, GREY_REFLECTANCE);
    faces[1].emission = Vec3::splat(3.0);
    for (y, [x0, x1, z0, z1]) in plates {
        let corners = rectangle([*x0, *y, *z0], [0.0, 0.0, z1 - z0], [x1 - x0, 0.0, 0.0]);
        let up = Face::quad("plate", corners, Vec3::ZERO, GREY_REFLECTANCE);
        // Two quads back to back make a thin wall.
        faces.extend([up.reversed(), up]);
    }
    named_scene(name, faces)
}

/// Makes a lit room, divided by a wall with a slit.
pub fn slit_room() -> Scene {
    room_with_plates("a slit", &[(0.5, [0.0, 0.45, 0.0, 1.0]), (0.5, [0.55, 1.0, 0.0, 1.0])])
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

/// Returns the relative RMS error and the bias of a field against `truth`, of the worst channel.
pub fn rms_and_bias(
    scene: &Scene,
    (mesh, field): (&Mesh, &RadiosityField),
    truth: &(Mesh, RadiosityField),
) -> (f64, f64) {
    let ours = ReflectedField::from_field(scene, mesh, field);
    let theirs = ReflectedField::from_field(scene, &truth.0, &truth.1);
    GridPair::new(&ours, &theirs, None).unwrap().worst_channel()
}

/// Returns the relative RMS error of an answer against `truth`.
pub fn error_against(scene: &Scene, answer: &SolveAnswer, truth: &(Mesh, RadiosityField)) -> f64 {
    rms_and_bias(scene, (&answer.solved.mesh, &answer.solved.run.field), truth).0
}

/// Solves a scene by the dense solver on `side`×`side` texels.
pub fn dense_truth_on(scene: &Scene, side: u32) -> (Mesh, RadiosityField) {
    let (mesh, matrix, _) = assemble_dense(scene, side);
    let field = dense::solve_system(&mesh, &matrix).unwrap().0.field;
    (mesh, field)
}
