//! The latest solve made again on the browser's GPU, and compared with that of the CPU, which is made again if the GPU made it.

use crate::browser_gpu::{LiveShader, open_gpu};
use crate::gpu_stages::check_solve;
use crate::request::LiveSolver;
use crate::solve::{LatestSolve, LivePower, LiveScene};
use common::energy::EnergyBalance;
use common::mesh::Mesh;
use common::shooting::{RadiosityField, Shot, shoot_until_converged};
use common::{Error, Result};
use cpu::CpuSolver;
use glam::DVec3;
use gpu::GpuSolver;
use oracle::compare::checked_stages::CheckedStages;
use radiosity::report::view::interpolation::{CarriedLight, InterpolationSurface};
use radiosity::report::viewer::{SceneViewer, ViewerLayer};
use serde::Serialize;
use std::ops::ControlFlow;

/// Relative RMS difference of B − E within which two solves of the same shots agree: roundings of 24 bits, and single texels
/// whose sight ends at an edge.
const AGREEING_DIFFERENCE: f64 = 1e-3;

/// A solve on the GPU beside that on the CPU.
#[derive(Debug, Serialize)]
pub struct GpuComparison {
    /// Name of the adapter, as the browser tells it.
    pub adapter: String,
    /// Number of shots.
    pub shots: usize,
    /// Number of shots until the logs name different shooters; none if they never do.
    pub first_other_shooter: Option<usize>,
    /// Relative RMS difference of B − E from that of the CPU.
    pub difference: f64,
    /// True if that is within roundings.
    pub agrees: bool,
    /// First stage that errs where the solves differ, and how; none if they agree, or no stage shows it.
    pub wrong_stage: Option<String>,
    /// Powers of the GPU's solve.
    pub power: LivePower,
    /// The viewer of both solutions and their difference.
    pub html: String,
}

/// Makes the latest solve again on the GPU, with shaders of others in the place of the program's.
///
/// Errors: [`Error::Usage`] if nothing is solved yet; [`Error::NoAdapter`]; [`Error::Device`]; [`Error::Input`] of a shader that
/// the device refuses; [`Error::Fault`] of two solves by the same engine.
pub async fn compare_with_gpu(live: &LiveScene, shaders: &[LiveShader]) -> Result<GpuComparison> {
    let LatestSolve {
        scene,
        solved,
        view,
        solver: by,
    } = live.latest()?;
    let gpu = open_gpu(shaders).await?;
    let (mesh, settings) = (&solved.mesh, &solved.settings);
    let mut solver = GpuSolver::request(&gpu, mesh, &settings.transport, &[]).await?;
    // A shader at fault may never come to the end.
    let limit = 2 * solved.run.shots.len() + 100;
    let mut done = 0;
    let mut watch = |_: &Shot, _| {
        done += 1;
        match done >= limit {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        }
    };
    let run = solver.request_run(&settings.schedule, &mut watch).await?;
    let own;
    let cpu = match by {
        LiveSolver::Cpu => &solved.run,
        LiveSolver::Gpu => {
            let mut engine = CpuSolver::new(mesh, &settings.transport);
            own = shoot_until_converged(&mut engine, &settings.schedule, &mut |_, _| ControlFlow::Continue(()))?;
            &own
        }
    };
    check_origins(&run.field, &cpu.field)?;
    let surface = InterpolationSurface::new(scene, mesh);
    let (camera, exposure) = view.to_parts();
    let viewer = SceneViewer {
        scene,
        surface: &surface,
        layers: vec![make_layer("GPU", mesh, &run.field), make_layer("CPU", mesh, &cpu.field)],
        irradiance: true,
        carried: CarriedLight::Irradiance,
        texel_errors: None,
        camera,
        exposure,
    };
    let difference = relative_difference(mesh, &run.field, &cpu.field);
    let wrong_stage = match difference <= AGREEING_DIFFERENCE {
        true => None,
        false => find_wrong_stage(&check_solve(scene, solved, settings, &gpu).await?),
    };
    let shooters = cpu.shots.iter().zip(&run.shots);
    Ok(GpuComparison {
        adapter: gpu.line.name.clone(),
        shots: run.shots.len(),
        first_other_shooter: shooters.into_iter().position(|(a, b)| a.patch != b.patch),
        difference,
        agrees: difference <= AGREEING_DIFFERENCE,
        wrong_stage,
        power: LivePower::of_balance(&EnergyBalance::new(mesh, &run.field, &run.shots)),
        html: viewer.render_element().into_string(),
    })
}

/// Describes the first stage that errs; none if none does.
fn find_wrong_stage(checked: &CheckedStages) -> Option<String> {
    let wrong = checked.checks.iter().find(|check| !check.agree)?;
    Some(match &wrong.difference {
        Some(difference) => format!("{}: {difference}", wrong.name),
        None => format!("{}: {}", wrong.name, wrong.reason),
    })
}

/// Checks that two fields are of two engines.
///
/// Errors: [`Error::Fault`], which names the one.
pub fn check_origins(a: &RadiosityField, b: &RadiosityField) -> Result<()> {
    match a.origin == b.origin {
        true => Err(Error::Fault(format!("both solves are of {:?}", a.origin))),
        false => Ok(()),
    }
}

fn make_layer<'a>(name: &'a str, mesh: &'a Mesh, field: &'a RadiosityField) -> ViewerLayer<'a> {
    ViewerLayer {
        name,
        mesh,
        field: Some(field),
    }
}

/// Returns the RMS over the area of the difference of two radiosities, relative to that of the second without emission.
fn relative_difference(mesh: &Mesh, a: &RadiosityField, b: &RadiosityField) -> f64 {
    let (mut difference, mut size) = (0.0, 0.0);
    for ((texel, a), b) in mesh.texels.iter().zip(&a.radiosity).zip(&b.radiosity) {
        let [a, b]: [DVec3; 2] = [a, b].map(|value| value.truncate().as_dvec3());
        let area = f64::from(texel.area);
        difference += area * (a - b).length_squared();
        size += area * (b - texel.emission.as_dvec3()).length_squared();
    }
    (difference / size).sqrt()
}
