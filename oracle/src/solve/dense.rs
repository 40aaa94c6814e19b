//! Solves a scene with the dense matrix, and converts the solution to a converged run with nothing unshot.

use super::progress::ProgressMonitor;
use super::solved::{DenseReport, Solved};
use common::mesh::Mesh;
use common::scene::Scene;
use common::settings::{Meshing, Settings};
use common::shooting::{RadiosityField, SolveRun};
use common::solution::{Warning, WarningCode};
use common::{Error, Result};
use cpu::dense::{self, Matrix, shot_log};
use cpu::hierarchy::sky::{SKY_ERROR, receive_sky};
use glam::{DVec3, Vec3, Vec4};

/// Returns the settings that the dense matrix supports: every texel is a patch with one sample, and transport
/// is as exact as possible.
pub fn dense_settings(texels: u32) -> Settings {
    let meshing = Meshing {
        texels,
        patches: 1,
        samples: 1,
    };
    Settings {
        meshing,
        ..Settings::default()
    }
}

/// Solves the dense system in which every texel shoots and receives.
///
/// Errors: those of the matrix; [`Error::Usage`] if mesh or transport differ from [`dense_settings`].
pub fn solve_dense(scene: &Scene, settings: &Settings, progress: &ProgressMonitor) -> Result<Solved> {
    let obeyed = self::dense_settings(settings.meshing.texels);
    if (settings.meshing, settings.transport) != (obeyed.meshing, obeyed.transport) {
        return Err(Error::Usage(
            "the dense matrix has no patches, no samples, no item buffer and only one form factor".into(),
        ));
    }
    let mut mesh = progress.time_phase("prepare", || Mesh::uniform(scene, settings.meshing.texels, 1))?;
    let mut callback = |done| progress.report_share("light from outside", done);
    progress.time_phase("prepare", || receive_sky(scene, &mut mesh, SKY_ERROR, &mut callback))?;
    let (matrix, quality) = progress.time_phase("prepare", || {
        let mut callback = |done, all| progress.report_count("form factors", done, all);
        Matrix::assemble(scene, &mesh, &mut callback)
    })?;
    let (run, answer) = progress.time_phase("solve", || solve_system(&mesh, &matrix))?;
    Ok(Solved {
        dense: Some(DenseReport {
            quality,
            solution: answer,
        }),
        ..Solved::new(settings, mesh, run)
    })
}

/// Solves `matrix` for the emission of the texels of `mesh`.
pub fn solve_system(mesh: &Mesh, matrix: &Matrix) -> Result<(SolveRun, dense::DenseSolution)> {
    let texels = mesh.texels.iter().zip(&matrix.open);
    let emission: Vec<DVec3> = texels
        .map(|(t, open)| t.source_radiosity(*open as f32).as_dvec3())
        .collect();
    let reflectance = mesh.texels.iter().map(|t| t.reflectance.as_dvec3());
    let answer = matrix.solve(&emission, &reflectance.collect::<Vec<_>>())?;
    Ok((converged_run(mesh, matrix, &emission, &answer), answer))
}

fn converged_run(mesh: &Mesh, matrix: &Matrix, emission: &[DVec3], answer: &dense::DenseSolution) -> SolveRun {
    let single = |values: &[DVec3]| -> Vec<Vec4> { values.iter().map(|v| v.as_vec3().extend(0.0)).collect() };
    let power = |(e, a): (&DVec3, &f64)| e.element_sum() * a;
    let mut field = RadiosityField {
        origin: "matrix".to_owned(),
        radiosity: single(&answer.radiosity),
        residual: vec![Vec4::ZERO; mesh.texels.len()],
        irradiance: single(&answer.irradiance),
    };
    for (k, texel) in mesh.texels.iter().enumerate().filter(|(_, t)| t.sky != Vec3::ZERO) {
        let irradiance = field.irradiance[k].truncate() + texel.sky;
        field.irradiance[k] = irradiance.extend(0.0);
        field.radiosity[k] = (texel.emission + texel.reflectance * irradiance).extend(0.0);
    }
    SolveRun {
        shots: shot_log::texel_shots(mesh, matrix, emission, answer),
        emitted: emission.iter().zip(&matrix.areas).map(power).sum::<f64>() as f32,
        converged: true,
        field,
        ..SolveRun::default()
    }
}

/// Replaces the warnings' advice for shooting by advice for the matrix.
pub fn adapt_advice(mut warnings: Vec<Warning>) -> Vec<Warning> {
    for warning in warnings.iter_mut().filter(|w| w.code == WarningCode::Closure) {
        warning.message = "form factors and visibility leave more than 2 % of the power unexplained: use more --texels, and look for faces that pass through each other".into();
    }
    warnings
}
