//! Matrices of small scenes, and two squares that face each other.

use common::mesh::Mesh;
use common::scene::{Face, Scene};
use cpu::matrix::{Matrix, Quality};
use glam::{DVec3, Vec3};
use std::ops::ControlFlow;

/// All pairs of a scene with `texels` a side.
pub fn assemble(scene: &Scene, texels: u32) -> (Mesh, Matrix, Quality) {
    let mesh = Mesh::uniform(scene, texels, 1).unwrap();
    let (matrix, quality) =
        Matrix::assemble(scene, &mesh, &mut |_, _| ControlFlow::Continue(())).unwrap();
    println!("{}, {} texels: {quality:?}", scene.name, matrix.len());
    (mesh, matrix, quality)
}

/// A black rectangle from `corner` along `u` and `v`; its front is u × v.
pub fn square(name: &str, corner: [f64; 3], u: [f64; 3], v: [f64; 3]) -> Face {
    let [c, u, v] = [corner, u, v].map(DVec3::from);
    Face::quad(name, [c, c + u, c + u + v, c + v], Vec3::ZERO, Vec3::ZERO)
}

/// Unit floor, and the unit ceiling at height 1 above it.
pub fn facing() -> Vec<Face> {
    vec![
        square("floor", [0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]),
        square("ceiling", [0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]),
    ]
}
