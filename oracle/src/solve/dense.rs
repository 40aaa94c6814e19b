//! The matrix's answer, as a converged run with nothing unshot.

use super::solved::{Dense, Solved};
use super::watch::Watch;
use common::mesh::Mesh;
use common::scene::Scene;
use common::settings::{Meshing, Settings};
use common::shooting::{Field, Run};
use common::solution::{Code, Warning};
use common::{Error, Result};
use cpu::matrix::{self, Matrix, ledger};
use glam::{DVec3, Vec4};

/// All that the matrix obeys: every texel shoots, from its centre, and light goes as exactly as it can.
pub fn settings(texels: u32) -> Settings {
    let meshing = Meshing {
        texels,
        cells: 1,
        samples: 1,
    };
    Settings {
        meshing,
        ..Settings::default()
    }
}

/// Every texel shoots and receives.
///
/// Errors: the matrix's; [`Error::Usage`] of a mesh or a transport that are not [`settings`].
pub fn solve(scene: &Scene, settings: &Settings, watch: &Watch) -> Result<Solved> {
    let obeyed = self::settings(settings.meshing.texels);
    if (settings.meshing, settings.transport) != (obeyed.meshing, obeyed.transport) {
        return Err(Error::Usage(
            "the matrix has no cells, no samples, no item buffer and one form factor".into(),
        ));
    }
    let mesh = watch.of("prepare", || {
        Mesh::uniform(scene, settings.meshing.texels, 1)
    })?;
    let (matrix, quality) = watch.of("prepare", || {
        let mut told = |done, all| watch.count("form factors", done, all);
        Matrix::assemble(scene, &mesh, &mut told)
    })?;
    let (run, answer) = watch.of("solve", || by(&mesh, &matrix))?;
    Ok(Solved {
        settings: *settings,
        mesh,
        run,
        one_by_one: false,
        matrix: Some(Dense { quality, answer }),
        moved: None,
        relit: None,
    })
}

/// What `matrix` makes of what the texels of `mesh` emit.
pub fn by(mesh: &Mesh, matrix: &Matrix) -> Result<(Run, matrix::Answer)> {
    let emission: Vec<DVec3> = mesh.texels.iter().map(|t| t.emission.as_dvec3()).collect();
    let reflectance = mesh.texels.iter().map(|t| t.reflectance.as_dvec3());
    let answer = matrix.solve(&emission, &reflectance.collect::<Vec<_>>())?;
    Ok((finished(mesh, matrix, &emission, &answer), answer))
}

fn finished(mesh: &Mesh, matrix: &Matrix, emission: &[DVec3], answer: &matrix::Answer) -> Run {
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

/// The advice for shots does not help here.
pub fn advised(mut warnings: Vec<Warning>) -> Vec<Warning> {
    for warning in warnings.iter_mut().filter(|w| w.code == Code::Closure) {
        warning.message = "form factors and visibility leave more than 2 % of the power unexplained: use more --texels, and look for faces that pass through each other".into();
    }
    warnings
}
