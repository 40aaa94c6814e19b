//! Runs the checks of all stages of progressive shooting, of their races, of single functions, and of a relight.

use super::checked_stages::CheckedStages;
use super::comparison::StageCheck;
use super::function_calls::check_shooting_functions;
use super::{races, stages};
use common::Result;
use common::mesh::Mesh;
use common::rays::Rays;
use common::scene::Scene;
use common::settings::{Settings, Transport};
use gpu::{Gpu, GpuSolver, ShaderFault};

/// Checks all stages of a solver, those of a relight among them, and their races, each on equal inputs; `faults` are planted in
/// the shaders.
///
/// Errors: the device fails.
pub async fn check_all_stages(
    scene: &Scene,
    (mesh, rays): (&Mesh, &Rays),
    settings: &Settings,
    (gpu, faults): (&Gpu, &[ShaderFault]),
) -> Result<CheckedStages> {
    let watched = gpu.for_checks();
    let transport = &settings.transport;
    let mut solver = GpuSolver::request(&watched, mesh, transport, faults).await?;
    let mut checked = stages::check_stages(mesh, transport, rays, &mut solver).await?;
    checked.checks.append(&mut races::race_checks(&watched).await?);
    if checked.refusal.is_some() {
        return Ok(checked);
    }
    let mut others = check_shooting_functions(mesh, transport, (gpu, faults)).await;
    if let Ok(called) = &mut others {
        checked.checks.append(called);
        others = check_relit_scene(scene, settings, (&watched, faults)).await;
    }
    match others {
        Ok(mut relit) => checked.checks.append(&mut relit),
        Err(error) => checked.take_refusal(error)?,
    }
    Ok(checked)
}

/// Checks the stages of a relight of the scene, with some of its faces as objects. Links that are compared are not scaled.
async fn check_relit_scene(
    scene: &Scene,
    settings: &Settings,
    (watched, faults): (&Gpu, &[ShaderFault]),
) -> Result<Vec<StageCheck>> {
    let Some(mesh) = stages::relit_mesh(scene, settings.meshing.texels)? else {
        return Ok(Vec::new());
    };
    let transport = Transport {
        conserve: false,
        ..settings.transport
    };
    let mut solver = GpuSolver::request(watched, &mesh, &transport, faults).await?;
    stages::check_relit_stages(&mesh, &transport, &mut solver).await
}
