//! Runs the checks of all stages of progressive shooting, of their races, of single functions, and of a relight.

use super::checked_stages::CheckedStages;
use super::comparison::{ComparisonRequest, StageCheck};
use super::function_calls::check_shooting_functions;
use super::{races, stages};
use crate::solve::progress::ProgressMonitor;
use common::Result;
use common::mesh::Mesh;
use common::rays::Rays;
use common::scene::Scene;
use common::settings::{Settings, Transport};
use gpu::{Gpu, GpuSolver, ShaderFault};

/// Checks all stages of a solver, those of a relight among them, and their races, each on equal inputs.
///
/// Errors: the device fails; `watch` interrupts.
pub fn check_all_stages(
    scene: &Scene,
    mesh: &Mesh,
    rays: &Rays,
    (settings, request): (&Settings, &ComparisonRequest),
    watch: &ProgressMonitor,
) -> Result<CheckedStages> {
    watch.begin_phase("WGSL against twin")?;
    let watched = request.gpu.for_checks();
    let mut solver = GpuSolver::with_faults(&watched, mesh, &settings.transport, request.faults)?;
    let mut checked = stages::check_stages(mesh, &settings.transport, rays, &mut solver)?;
    checked.checks.append(&mut races::race_checks(&watched)?);
    if checked.refusal.is_none() {
        let called = check_shooting_functions(mesh, &settings.transport, (request.gpu, request.faults));
        let relit = called.and_then(|called| {
            checked.checks.extend(called);
            check_relit_scene(scene, settings, (&watched, request.faults))
        });
        match relit {
            Ok(mut checks) => checked.checks.append(&mut checks),
            Err(error) => checked.take_refusal(error)?,
        }
    }
    Ok(checked)
}

/// Checks the stages of a relight of the scene, with some of its faces as objects. Links that are compared are not scaled.
fn check_relit_scene(
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
    let mut solver = GpuSolver::with_faults(watched, &mesh, &transport, faults)?;
    stages::check_relit_stages(&mesh, &transport, &mut solver)
}
