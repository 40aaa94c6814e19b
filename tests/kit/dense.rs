//! Dense matrices of small scenes, and two squares that face each other.

use common::mesh::Mesh;
use common::scene::{Face, Scene};
use cpu::dense::{AssemblyQuality, Matrix};
use glam::{DVec3, Vec3};
use std::ops::ControlFlow;

/// Assembles the dense matrix of a scene with `texels` per side.
pub fn assemble_dense(scene: &Scene, texels: u32) -> (Mesh, Matrix, AssemblyQuality) {
    let mesh = Mesh::uniform(scene, texels, 1).unwrap();
    let (matrix, quality) = Matrix::assemble(scene, &mesh, &mut |_, _| ControlFlow::Continue(())).unwrap();
    println!("{}, {} texels: {quality:?}", scene.name, matrix.len());
    (mesh, matrix, quality)
}

/// Makes a black rectangle from `corner` along `u` and `v`; its front is u × v.
pub fn black_rectangle(name: &str, corner: [f64; 3], u: [f64; 3], v: [f64; 3]) -> Face {
    let [c, u, v] = [corner, u, v].map(DVec3::from);
    Face::quad(name, [c, c + u, c + u + v, c + v], Vec3::ZERO, Vec3::ZERO)
}

/// Makes a unit floor and a unit ceiling at height 1 above it.
pub fn facing_squares() -> Vec<Face> {
    vec![
        black_rectangle("floor", [0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]),
        black_rectangle("ceiling", [0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]),
    ]
}
