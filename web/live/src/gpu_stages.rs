//! The stages of the GPU's solvers beside their twins, on the texels of the latest solve.

use crate::browser_gpu::{LiveShader, open_gpu};
use crate::request::find_visibility;
use crate::solve::{LatestSolve, LiveScene};
use common::Result;
use common::rays::Rays;
use common::scene::Scene;
use common::settings::Settings;
use gpu::Gpu;
use oracle::compare::all_stages::check_all_stages;
use oracle::compare::checked_stages::CheckedStages;
use oracle::compare::comparison::StageCheck;
use oracle::solve::solved::Solved;
use serde::Serialize;

/// Checks of all stages by one visibility.
#[derive(Debug, Serialize)]
pub struct StageReport {
    /// Name of the adapter, as the browser tells it.
    pub adapter: String,
    /// Its backend and driver.
    pub driver: String,
    /// True for an adapter that runs on the CPU.
    pub software: bool,
    /// Checks of the stages that were reached.
    pub checks: Vec<StageCheck>,
    /// Names of the others.
    pub unreached: Vec<&'static str>,
    /// Why the solver was not asked further; none if it was.
    pub refusal: Option<String>,
}

/// Checks all stages by a visibility, an item buffer of so many pixels a side, with shaders of others in the place of the
/// program's.
///
/// Errors: [`common::Error::Usage`] if nothing is solved yet, or of an unknown visibility; those of the device.
pub async fn check_stages(
    live: &LiveScene,
    (visibility, pixels): (&str, u32),
    shaders: &[LiveShader],
) -> Result<StageReport> {
    let LatestSolve { scene, solved, .. } = live.latest()?;
    let settings = solved.settings.with_visibility(find_visibility(visibility, pixels)?);
    let gpu = open_gpu(shaders).await?;
    let checked = check_solve(scene, solved, &settings, &gpu).await?;
    Ok(StageReport {
        adapter: gpu.line.name.clone(),
        driver: format!("{} {}", gpu.line.backend, gpu.line.driver).trim().to_owned(),
        software: gpu.line.software,
        checks: checked.checks,
        unreached: checked.unreached,
        refusal: checked.refusal,
    })
}

/// Checks all stages on the texels of a solve, by other settings.
///
/// Errors: those of the device.
pub async fn check_solve(scene: &Scene, solved: &Solved, settings: &Settings, gpu: &Gpu) -> Result<CheckedStages> {
    let rays = Rays::new(&solved.mesh);
    check_all_stages(scene, (&solved.mesh, &rays), settings, (gpu, &[])).await
}
