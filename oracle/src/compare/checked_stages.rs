//! The checks of all stages of a comparison, each on equal input, and why the GPU is not asked further.

use super::comparison::{Criterion, StageCheck};
use super::criteria::stage_criteria;
use super::{ComparisonRequest, races, stages};
use crate::solve::progress::ProgressMonitor;
use common::mesh::Mesh;
use common::rays::Rays;
use common::scene::Scene;
use common::settings::{Settings, Transport};
use common::{Error, Result};
use gpu::GpuSolver;

/// Checks of the stages of a solver.
#[derive(Clone, Debug, Default)]
pub struct CheckedStages {
    /// Checks of the stages that were reached.
    pub checks: Vec<StageCheck>,
    /// Names of the others.
    pub unreached: Vec<&'static str>,
    /// Why the solver is not asked further: the host has refused a result.
    pub refusal: Option<String>,
}

impl CheckedStages {
    /// Returns a note on stages that were not reached, if there are any.
    pub fn describe_unreached(&self) -> Option<String> {
        let names = self.unreached.join(", ");
        (!names.is_empty()).then(|| format!("stages that this scene does not reach: {names}"))
    }

    /// Returns a criterion for each check, and one for a refused result.
    pub fn criteria(&self) -> Vec<Criterion> {
        let name = "results of the GPU that are refused";
        let refused = (self.refusal.as_ref()).map(|reason| Criterion::at_most(name, 1.0, 0.0, reason));
        let mut criteria = stage_criteria(&self.checks);
        criteria.extend(refused);
        criteria
    }

    /// Takes the error of work on the GPU into the verdict.
    ///
    /// Errors: the error, if it names no stage and no stage differs, or if the work was interrupted.
    pub fn take_refusal(&mut self, error: Error) -> Result<()> {
        match &error {
            Error::Interrupted => return Err(error),
            Error::Stage { stage, message } => {
                let of_stage = |check: &StageCheck| check.name == *stage;
                if !self.checks.iter().any(|check| of_stage(check) && !check.agree) {
                    self.checks.retain(|check| !of_stage(check));
                    self.checks.push(StageCheck::without_result(stage, message));
                }
            }
            _ if self.checks.iter().all(|check| check.agree) => return Err(error),
            _ => {}
        }
        self.refusal.get_or_insert(error.to_string());
        Ok(())
    }
}

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
    let watched = request.gpu.with_race_log();
    let mut solver = GpuSolver::with_faults(&watched, mesh, &settings.transport, request.faults)?;
    let mut checked = stages::check_stages(mesh, &settings.transport, rays, &mut solver)?;
    checked.checks.append(&mut races::race_checks(&watched)?);
    if checked.refusal.is_none() {
        match check_relit_scene(scene, settings, request) {
            Ok(mut checks) => checked.checks.append(&mut checks),
            Err(error) => checked.take_refusal(error)?,
        }
    }
    Ok(checked)
}

/// Checks the stages of a relight of the scene, with some of its faces as objects. Links that are compared are not scaled.
fn check_relit_scene(scene: &Scene, settings: &Settings, request: &ComparisonRequest) -> Result<Vec<StageCheck>> {
    let Some(mesh) = stages::relit_mesh(scene, settings.meshing.texels)? else {
        return Ok(Vec::new());
    };
    let transport = Transport {
        conserve: false,
        ..settings.transport
    };
    let mut solver = GpuSolver::with_faults(request.gpu, &mesh, &transport, request.faults)?;
    stages::check_relit_stages(&mesh, &transport, &mut solver)
}
