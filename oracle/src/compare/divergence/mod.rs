//! First divergence: the shot, the face, the texel and the factor in which two solvers part, with both sides' numbers,
//! and the share of each stage in the difference of radiosity.
//!
//! Both solvers shoot the same patches, and the CPU continues after each shot from the GPU's field, so that a difference
//! belongs to its shot. The bound of a texel is that of the roundings of its link and deposit, and beside silhouettes of
//! an item buffer the change of its link by wrong visibility. At the worst texel of the first shot beyond it the chain
//! from the shooter to the texel is followed. Solves to an error have no shots in common: there, and where
//! no shot parts the solvers, the first check of a stage that fails is named.

mod chain;
mod deposit_cause;
mod field_difference;
mod form_factor_cause;
mod search;
mod shooter_links;
mod stage_shares;

use crate::compare::comparison::{Comparison, StageCheck};
use crate::compare::parting::{Factor, FirstDivergence, Parting};
use crate::solve::progress::ProgressMonitor;
use common::settings::Visibility;
use common::shooting::{Shoot, total_power};
use common::{Error, Result};
use cpu::CpuSolver;
use gpu::{Gpu, GpuSolver, ShaderFault};
use search::Search;
use std::collections::BTreeMap;

/// Largest number of shots that are followed.
const MAX_FOLLOWED_SHOTS: u32 = 64;
/// Largest number of shooters whose links are made on both sides: these take most of the time.
const MAX_FOLLOWED_SHOOTERS: usize = 16;

/// Finds where the solvers of `comparison` part; `faults` are those planted in its shaders. A result that the host refuses
/// ends the search.
///
/// Errors: `watch` interrupts.
pub fn find_first_divergence(
    comparison: &Comparison,
    (gpu, faults): (&Gpu, &[ShaderFault]),
    watch: &ProgressMonitor,
) -> Result<FirstDivergence> {
    let mut found = FirstDivergence::default();
    if comparison.error_target.is_none() {
        match search_shots(comparison, (gpu, faults), &mut found, watch) {
            Err(Error::Interrupted) => return Err(Error::Interrupted),
            Err(refused) => found.refusal = Some(refused.to_string()),
            Ok(()) => {}
        }
    }
    if found.parting.is_none() {
        found.parting = comparison
            .stages
            .iter()
            .find(|stage| !stage.agree)
            .map(parting_of_stage);
    }
    Ok(found)
}

fn search_shots(
    comparison: &Comparison,
    (gpu, faults): (&Gpu, &[ShaderFault]),
    found: &mut FirstDivergence,
    watch: &ProgressMonitor,
) -> Result<()> {
    let (mesh, settings) = (&comparison.mesh, &comparison.gpu_settings);
    let mut cpu = CpuSolver::new(mesh, &settings.with_visibility(Visibility::Rays).transport);
    let emitted = total_power(&cpu.patch_power()?);
    let mut search = Search {
        scene: &comparison.scene,
        mesh,
        transport: &settings.transport,
        threshold: (f64::from(emitted) * settings.schedule.epsilon) as f32,
        cpu,
        gpu: GpuSolver::with_faults(gpu, mesh, &settings.transport, faults)?,
        shooters: BTreeMap::new(),
    };
    search.follow_shots(found, watch)?;
    if found.parting.is_some() || found.silhouette.is_some() {
        found.shares = Some(search.measure_shares()?);
    }
    Ok(())
}

/// Returns the difference that the check of a stage has found.
fn parting_of_stage(stage: &StageCheck) -> Parting {
    let values = stage.difference.as_ref().map(|found| format!(": {found}"));
    Parting {
        shot: None,
        shooter: None,
        texel: None,
        factor: Factor::of_stage(&stage.name),
        stage: Some(stage.name.clone()),
        cause: format!(
            "the check of the stage {} fails{}",
            stage.name,
            values.unwrap_or_default()
        ),
        steps: Vec::new(),
    }
}
