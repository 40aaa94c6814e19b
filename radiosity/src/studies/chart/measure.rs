//! Times one method by wall clock and computes its error.

use super::methods::SolveMethod;
use super::truth::ChartTruth;
use super::{Measurement, SolveFigures, SolverKind};
use crate::plan::memory_limit::{MemoryLimit, check_memory};
use common::energy::EnergyBalance;
use common::resample::{area_average, shared_pieces};
use common::scene::Scene;
use common::texel::first_texels;
use common::texel::texel_count;
use common::{Error, Result};
use glam::DVec3;
use gpu::Gpu;
use oracle::diff::pair::{GridPair, SceneMismatch};
use oracle::diff::reflected::ReflectedField;
use oracle::solve::progress::ProgressMonitor;
use oracle::solve::solved::Solved;
use oracle::solve::solver::{self, ErrorTarget};
use oracle::solve::task::SolveTask;
use std::cell::Cell;
use std::ops::ControlFlow;
use std::time::Instant;

/// Scene, GPU, truth and limits of the measurements of one chart.
pub struct MeasurementSetup<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The GPU, where there is one.
    pub gpu: Option<&'a Gpu>,
    /// The truth that errors are measured against.
    pub truth: &'a ChartTruth,
    /// Texels per side of a face on which errors are measured.
    pub texels: u32,
    /// Time limit of a solve, seconds.
    pub time_limit: f64,
}

/// Reason that a solve was stopped.
#[derive(Clone, Copy, PartialEq)]
enum StopReason {
    No,
    Late,
    Asked,
}

impl MeasurementSetup<'_> {
    /// Solves once and measures time and error; a failed solve is a measurement too. Returns none if
    /// `watch` asked to stop.
    pub fn measure_method(&self, method: &SolveMethod, watch: &ProgressMonitor) -> Option<Measurement> {
        let start = Instant::now();
        let stop = Cell::new(StopReason::No);
        let progress = |phase: &str, done: f64| {
            if watch.report_share(phase, done).is_break() {
                stop.set(StopReason::Asked);
            } else if stop.get() == StopReason::No && start.elapsed().as_secs_f64() > self.time_limit {
                stop.set(StopReason::Late);
            }
            if stop.get() == StopReason::No {
                ControlFlow::Continue(())
            } else {
                ControlFlow::Break(())
            }
        };
        let inner_watch = ProgressMonitor::new(&progress);
        let solved = self.solve_method(method, &inner_watch);
        let seconds = start.elapsed().as_secs_f64();
        let result = match (stop.get(), solved) {
            (StopReason::Asked, _) => return None,
            (StopReason::Late, _) => Err(format!("took longer than {} s", self.time_limit)),
            (StopReason::No, Ok(solved)) => self.compute_figures(&solved),
            (StopReason::No, Err(error)) => Err(error.to_string()),
        };
        let prepare = inner_watch.phase_seconds(&["prepare"]);
        Some(Measurement {
            prepare,
            solve: seconds - prepare,
            result,
        })
    }

    fn solve_method(&self, method: &SolveMethod, watch: &ProgressMonitor) -> Result<Solved> {
        let settings = &method.settings;
        let gpu = match method.solver {
            SolverKind::Gpu => Some(self.gpu.ok_or_else(|| Error::Device("no adapter".into()))?),
            SolverKind::Cpu | SolverKind::Matrix => None,
        };
        let texels = Some(self.texels);
        let solver = match (method.target_error, method.solver) {
            (Some(error), _) => solver::SolverChoice::to_error(gpu, ErrorTarget { error, texels }),
            (None, SolverKind::Matrix) => solver::SolverChoice::Dense,
            (None, _) => solver::SolverChoice::shooting_on(gpu),
        };
        if solver.is_shooting() {
            check_memory(self.scene, settings, solver.gpu(), MemoryLimit::of_this_machine())?;
        }
        let solved = self.scene.solve_once(settings, solver, watch)?;
        if solved.one_by_one && method.sweep == "iteration" {
            return Err(Error::Usage(
                "this engine shoots patch by patch, so this would repeat the base".into(),
            ));
        }
        Ok(solved)
    }

    /// Computes a solution's figures. Errors: the solution cannot be compared with the truth.
    fn compute_figures(&self, solved: &Solved) -> std::result::Result<SolveFigures, String> {
        let (mesh, run) = (&solved.mesh, &solved.run);
        let reflected = ReflectedField::from_field(self.scene, mesh, &run.field);
        if !reflected.values.iter().all(|v| v.is_finite()) {
            return Err("some texels are not finite numbers".into());
        }
        let truth = ReflectedField::from(&self.truth.stored);
        if truth.resolutions == reflected.resolutions && truth.values == reflected.values {
            return Err("equals the truth bit for bit, so there is nothing to compare".into());
        }
        let lit = |values: &[DVec3]| values.iter().any(|v| *v != DVec3::ZERO);
        if lit(&truth.values) && !lit(&reflected.values) {
            return Err("reflects no light".into());
        }
        if !run.converged {
            return Err(format!(
                "has not converged: {:.2} % unshot after {} shots",
                100.0 * run.unshot_fraction(),
                run.shooters
            ));
        }
        let compared = |a: &ReflectedField| compare_fields(a, &truth).map_err(|m| m.message);
        let (error, bias) = compared(&resample_finer(&reflected, self.texels))?;
        let (own_error, _) = compared(&reflected)?;
        if !error.is_finite() {
            return Err("the truth is black in a channel in which the solution is not".into());
        }
        Ok(solve_figures(solved, error, own_error, bias))
    }
}

/// Returns relative RMS error and bias on common texels, worst channel of each. Errors: the fields
/// are of different scenes.
pub fn compare_fields(a: &ReflectedField, truth: &ReflectedField) -> std::result::Result<(f64, f64), SceneMismatch> {
    Ok(GridPair::new(a, truth, None)?.worst_channel())
}

/// Returns a solve's figures with the errors given.
pub fn solve_figures(solved: &Solved, error: f64, own_error: f64, bias: f64) -> SolveFigures {
    let (mesh, run) = (&solved.mesh, &solved.run);
    let mut linked = vec![false; mesh.patches.len()];
    for shot in &run.shots {
        linked[shot.patch as usize] = true;
    }
    SolveFigures {
        error,
        own_error,
        bias,
        imbalance: EnergyBalance::new(mesh, &run.field, &run.shots).imbalance,
        unshot: run.unshot_fraction(),
        shots: run.shooters,
        passes: run.passes,
        linked: linked.iter().filter(|linked| **linked).count() as u64,
        one_by_one: solved.one_by_one,
    }
}

/// Resamples to at least N×N texels per face; a coarse texel's value is constant over it.
fn resample_finer<'a>(a: &ReflectedField<'a>, texels: u32) -> ReflectedField<'a> {
    let resolutions: Vec<[u32; 2]> = a
        .resolutions
        .iter()
        .map(|r| r.map(|side| if side < texels { texels } else { side }))
        .collect();
    let first = first_texels(&a.resolutions);
    let mut values = Vec::with_capacity(resolutions.iter().map(|r| texel_count(*r) as usize).sum());
    for (k, face) in a.scene.faces.iter().enumerate() {
        let coarse = &a.values[first[k]..first[k + 1]];
        if resolutions[k] == a.resolutions[k] {
            values.extend_from_slice(coarse);
        } else {
            let shared = shared_pieces(face, a.resolutions[k], resolutions[k]);
            values.extend(area_average(coarse, &shared, resolutions[k]));
        }
    }
    ReflectedField {
        scene: a.scene,
        resolutions,
        values,
    }
}
