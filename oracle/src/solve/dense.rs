//! The matrix's answer as a converged run with nothing unshot.

use common::Result;
use common::mesh::Mesh;
use common::shooting::{Field, Run};
use cpu::matrix::{Answer, Matrix, ledger};
use glam::{DVec3, Vec4};

/// Solves for what the texels of `mesh` emit.
pub fn solve(mesh: &Mesh, matrix: &Matrix) -> Result<(Run, Answer)> {
    let emission: Vec<DVec3> = mesh.texels.iter().map(|t| t.emission.as_dvec3()).collect();
    let reflectance = mesh.texels.iter().map(|t| t.reflectance.as_dvec3());
    let answer = matrix.solve(&emission, &reflectance.collect::<Vec<_>>())?;
    Ok((finished(mesh, matrix, &emission, &answer), answer))
}

fn finished(mesh: &Mesh, matrix: &Matrix, emission: &[DVec3], answer: &Answer) -> Run {
    let single = |values: &[DVec3]| -> Vec<Vec4> {
        values.iter().map(|v| v.as_vec3().extend(0.0)).collect()
    };
    let power = |(e, a): (&DVec3, &f64)| e.element_sum() * a;
    Run {
        shots: ledger::shots(mesh, matrix, emission, answer),
        emitted: emission.iter().zip(&matrix.areas).map(power).sum::<f64>() as f32,
        converged: true,
        stagnated: false,
        passes: 0,
        shooters: 0,
        field: Field {
            origin: "matrix".to_owned(),
            radiosity: single(&answer.radiosity),
            residual: vec![Vec4::ZERO; mesh.texels.len()],
            irradiance: single(&answer.irradiance),
        },
    }
}
