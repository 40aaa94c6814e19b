//! Dense matrices of small scenes, their solutions, and two squares that face each other.

use crate::factor_cases::rectangle;
use common::mesh::{Mesh, Texel};
use common::scene::{Face, Scene};
use cpu::dense::{AssemblyQuality, DenseSolution, Matrix};
use glam::{DVec3, Vec3};
use std::ops::ControlFlow;

/// Assembles the dense matrix of a scene with `texels` per side.
pub fn assemble_dense(scene: &Scene, texels: u32) -> (Mesh, Matrix, AssemblyQuality) {
    let mesh = Mesh::uniform(scene, texels, 1).unwrap();
    let (matrix, quality) = Matrix::assemble(scene, &mesh, &mut |_, _| ControlFlow::Continue(())).unwrap();
    println!("{}, {} texels: {quality:?}", scene.name, matrix.len());
    (mesh, matrix, quality)
}

/// Returns a colour of each texel.
pub fn texel_values(mesh: &Mesh, of: impl Fn(&Texel) -> Vec3) -> Vec<DVec3> {
    mesh.texels.iter().map(|texel| of(texel).as_dvec3()).collect()
}

/// Solves for the radiosity of the texels.
pub fn solve_matrix(mesh: &Mesh, matrix: &Matrix) -> DenseSolution {
    let emission = texel_values(mesh, |texel| texel.emission);
    let reflectance = texel_values(mesh, |texel| texel.reflectance);
    let answer = matrix.solve(&emission, &reflectance).unwrap();
    assert!(answer.residual < 1e-12, "{}", answer.residual);
    answer
}

/// Makes a black parallelogram from `corner` along `u` and `v`; its front is u × v.
pub fn black_rectangle(corner: [f64; 3], u: [f64; 3], v: [f64; 3]) -> Face {
    Face::quad("black", rectangle(corner, u, v), Vec3::ZERO, Vec3::ZERO)
}

/// Makes a unit floor and a unit ceiling at height 1 above it.
pub fn facing_squares() -> Vec<Face> {
    vec![
        black_rectangle([0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]),
        black_rectangle([0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]),
    ]
}
