//! Judges a stored result of any origin by its residual: its own light is gathered again at every texel, and
//! the residual r is propagated through all later bounces to an error e.
//!
//! ```text
//! r = E + ρKB − B      e = r + ρKr + (ρK)²r + …      B + e solves the equation
//! ```

use super::adaptive::follows_rays;
use super::progress::{ProgressMonitor, step_progress};
use super::solve_to_error::ESCAPE_POINTS;
use crate::diff::Diff;
use common::cover::sample_covers;
use common::energy::EnergyBalance;
use common::mesh::Mesh;
use common::scene::Scene;
use common::solution::StoredSolution;
use common::{Error, Result};
use cpu::hierarchy::linker::LinkMethod;
use cpu::hierarchy::residual::{GatheredResidual, gather_residual};
use cpu::hierarchy::shot_log;
use cpu::hierarchy::solver::{ErrorBudget, TexelSolution};
use cpu::ray_cast::residual::gather_residual_by_rays;
use glam::{DVec3, Vec3};

/// Relative error of light that is gathered over links; a smaller residual cannot be distinguished from 0.
pub const GATHER_ERROR: f32 = 0.005;
/// Noise of light that is gathered by rays. It is known, and taken off differences. Of N texels N^-1/4 of it
/// stays, less than [`GATHER_ERROR`] of the fewest faces for which rays are chosen.
const GATHER_NOISE: f32 = 0.01;

/// A stored result, its corrected solution and the difference.
pub struct JudgedResult {
    /// B + e, in the result's layout.
    pub truth: StoredSolution,
    /// Difference of the result from `truth`.
    pub diff: Diff,
    /// RMS of r over that of B − E, in the worst channel.
    pub one_bounce: f64,
    /// Energy balance of the result.
    pub energy: EnergyBalance,
}

impl JudgedResult {
    /// Returns the error of the result: its RMS difference from the truth, without the truth's noise, in the worst channel.
    pub fn error(&self) -> f64 {
        let noise = self.diff.standard_error.unwrap_or_default();
        let square = |c: usize| self.diff.relative_rms[c].powi(2) - noise[c].powi(2);
        (0..3).map(square).fold(0.0, f64::max).sqrt()
    }
}

/// Judges `stored`. If `scene` is given, reflectance and emission of the faces are taken from it.
///
/// Errors: missing reflectances, [`Error::Interrupted`].
pub fn judge_result(stored: &StoredSolution, scene: Option<Scene>, progress: &ProgressMonitor) -> Result<JudgedResult> {
    let mut truth = stored.clone();
    truth.dir = "its own light, gathered anew".into();
    truth.scene.notes.clear();
    // The corrected solution has no error estimate.
    truth.others.remove("error");
    if let Some(scene) = scene {
        if scene.faces.len() != stored.scene.faces.len() {
            return Err(Error::Usage(format!(
                "{} has {} faces, {} has {}: a result is judged with the scene it was solved from",
                scene.name,
                scene.faces.len(),
                stored.dir.display(),
                stored.scene.faces.len()
            )));
        }
        truth.scene = scene;
        truth.others.remove("reflectance");
    }
    let mut mesh = progress.time_phase("prepare", || mesh_of_result(&truth))?;
    let order = mesh.texels_in_face_order();
    if mesh.texels.iter().all(|t| t.reflectance == Vec3::ZERO) {
        return Err(Error::Usage(format!(
            "{} has no reflectances: give the scene, too",
            stored.dir.display()
        )));
    }
    let mut reflected = vec![Vec3::ZERO; mesh.texels.len()];
    for (k, value) in order.iter().zip(stored.reflected_radiosity()) {
        reflected[*k] = value.as_vec3();
    }
    let gathered = progress.time_phase("solve", || {
        let mut callback = step_progress(progress, "gathering");
        if follows_rays(&truth.scene, f64::from(GATHER_ERROR), LinkMethod::Shafts) {
            return gather_residual_by_rays(&truth.scene, &mesh, &reflected, GATHER_NOISE, &mut callback);
        }
        let budget = ErrorBudget::for_error(GATHER_ERROR);
        gather_residual(&truth.scene, &mesh, &reflected, budget, &mut callback)
    })?;
    let (mut squares, mut light) = (DVec3::ZERO, DVec3::ZERO);
    let mut errors = Vec::with_capacity(order.len());
    for (n, k) in order.iter().enumerate() {
        let texel = &mesh.texels[*k];
        let once = texel.reflectance * gathered.irradiance[*k];
        truth.radiosity[n] = truth.emission[n] + once + texel.reflectance * gathered.later[*k];
        let area = f64::from(texel.area);
        let [noise, all] = [0, 1].map(|n| texel.reflectance * texel.reflectance * gathered.variance[n][*k]);
        squares += area * ((once - reflected[*k]).as_dvec3().powf(2.0) - noise.as_dvec3());
        errors.push(all.map(f32::sqrt));
        light += area * reflected[*k].as_dvec3().powf(2.0);
    }
    let share = |c: usize| {
        if squares[c] <= 0.0 {
            0.0
        } else {
            (squares[c] / light[c]).sqrt()
        }
    };
    if errors.iter().any(|error| *error != Vec3::ZERO) {
        truth.others.insert("error", errors);
    }
    Ok(JudgedResult {
        one_bounce: (0..3).map(share).fold(0.0, f64::max),
        diff: Diff::new(stored, &truth)?,
        energy: energy_balance(stored, &mut mesh, &reflected, &gathered),
        truth,
    })
}

/// Makes a mesh with the texels, reflectances and emissions of a result.
fn mesh_of_result(stored: &StoredSolution) -> Result<Mesh> {
    let mut mesh = Mesh::new(&stored.scene, &stored.resolutions, 1)?;
    let order = mesh.texels_in_face_order();
    for (n, k) in order.into_iter().enumerate() {
        let texel = &mut mesh.texels[k];
        texel.emission = stored.emission[n];
        texel.sky = stored.others.get("sky").map_or(Vec3::ZERO, |sky| sky[n]);
        if let Some(reflectance) = stored.others.get("reflectance") {
            texel.reflectance = reflectance[n];
        }
    }
    sample_covers(&mut mesh, ESCAPE_POINTS);
    Ok(mesh)
}

/// Computes the energy balance of the result's own light. Missing irradiance is derived as (B − E)/ρ; for a
/// texel with ρ = 0 it is the gathered irradiance.
fn energy_balance(
    stored: &StoredSolution,
    mesh: &mut Mesh,
    reflected: &[Vec3],
    gathered: &GatheredResidual,
) -> EnergyBalance {
    let mut irradiance = gathered.irradiance.clone();
    let mut residual = vec![Vec3::ZERO; mesh.texels.len()];
    for (n, k) in mesh.texels_in_face_order().into_iter().enumerate() {
        let rho = mesh.texels[k].reflectance;
        let own = Vec3::select(rho.cmpgt(Vec3::ZERO), reflected[k] / rho, irradiance[k]);
        let of = |name: &str| stored.others.get(name).map(|values| values[n]);
        irradiance[k] = of("irradiance").unwrap_or(own);
        residual[k] = of("residual").unwrap_or_default();
    }
    let outcome = TexelSolution {
        irradiance,
        residual,
        open: gathered.open.clone(),
        converged: true,
        ..TexelSolution::default()
    };
    shot_log::set_open_shares(mesh, &outcome);
    let run = shot_log::record_run(mesh, &outcome, &shot_log::measure_escape(mesh, &outcome));
    EnergyBalance::new(mesh, &run.field, &run.shots)
}
