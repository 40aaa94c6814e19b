//! Effort of a solve to a given error: shots of plain Southwell, ε of the default iteration. The truth
//! is the converged solution of the same texels, form factors and rays.

use common::mesh::Mesh;
use common::passes::Engine;
use common::passes::solve_by_schedule;
use common::settings::{Iteration, Schedule, Settings};
use common::shooting::{DepositRule, RadiosityField, SolveRun, initial_field};
use cpu::CpuSolver;
use glam::{DVec3, Vec3};
use std::ops::ControlFlow;

/// Share of unshot power at which a solution counts as converged.
const CONVERGED_EPSILON: f64 = 1e-6;
/// Factor of ε from one try to the next.
const EPSILON_STEP: f64 = 0.9;

/// Returns the settings with plain Southwell: one shot at a time, most unshot power first.
pub fn southwell_settings(settings: &Settings) -> Settings {
    Settings {
        schedule: Schedule {
            iteration: Iteration::Southwell,
            ..settings.schedule
        },
        ..*settings
    }
}

/// A mesh with the settings of its solve and its converged solution.
#[derive(Clone)]
pub struct AccuracyTarget {
    /// Mesh of the scene.
    pub mesh: Mesh,
    /// Settings of the solve, except ε.
    pub settings: Settings,
    truth: RadiosityField,
}

impl AccuracyTarget {
    /// Computes the converged solution. Panics if the solve does not converge.
    pub fn new(mesh: Mesh, settings: Settings) -> Self {
        let mut settings_of_truth = southwell_settings(&settings);
        settings_of_truth.schedule.epsilon = CONVERGED_EPSILON;
        let run = run_solve(
            &mut CpuSolver::new(&mesh, &settings_of_truth.transport),
            &mesh,
            &settings_of_truth,
        );
        assert!(run.converged, "the truth must have converged");
        Self {
            mesh,
            settings,
            truth: run.field,
        }
    }

    /// Returns the relative RMS error √(ΣA(a−b)² / ΣA b²) of B − E, worst channel.
    pub fn relative_rms(&self, field: &RadiosityField) -> f64 {
        let (mut difference, mut reflected) = (DVec3::ZERO, DVec3::ZERO);
        for (k, texel) in self.mesh.texels.iter().enumerate() {
            let truth = self.truth.radiosity[k].truncate().as_dvec3();
            let off = field.radiosity[k].truncate().as_dvec3() - truth;
            let area = f64::from(texel.area);
            difference += area * off * off;
            let own = truth - texel.emission.as_dvec3();
            reflected += area * own * own;
        }
        let share = difference / reflected;
        share.to_array().map(f64::sqrt).into_iter().fold(0.0, f64::max)
    }

    /// Returns the shooters of plain Southwell until the error is at most `bound`.
    pub fn southwell_shots(&self, bound: f64) -> Vec<u32> {
        let mut settings = southwell_settings(&self.settings);
        settings.schedule.epsilon = 0.0;
        settings.schedule.max_shots = 1;
        let mut engine = CpuSolver::new(&self.mesh, &settings.transport);
        let mut shots = Vec::new();
        loop {
            let run = run_solve(&mut engine, &self.mesh, &settings);
            assert!(!run.shots.is_empty(), "{bound} is never reached");
            shots.extend(run.shooter_log());
            if self.relative_rms(&run.field) <= bound {
                return shots;
            }
        }
    }

    /// Resets the engine to B = r = E; it keeps its links.
    pub fn restart_engine(&self, engine: &mut dyn Engine) {
        let start = initial_field(&self.mesh, "cpu");
        let reflectance: Vec<Vec3> = self.mesh.texels.iter().map(|t| t.reflectance).collect();
        engine
            .restart_from(DepositRule::FULL_DEPOSIT, &reflectance, &start)
            .expect("the CPU solver restarts");
    }

    /// Returns the settings with the largest ε of a geometric sequence whose error is at most `bound`.
    pub fn settings_to(&self, bound: f64) -> Settings {
        let mut settings = self.settings;
        settings.schedule.epsilon = 0.5;
        let mut engine = CpuSolver::new(&self.mesh, &settings.transport);
        loop {
            // The engine keeps its links, so that a try is fast.
            self.restart_engine(&mut engine);
            if self.relative_rms(&run_solve(&mut engine, &self.mesh, &settings).field) <= bound {
                return settings;
            }
            settings.schedule.epsilon *= EPSILON_STEP;
            assert!(
                settings.schedule.epsilon > CONVERGED_EPSILON,
                "{bound} is never reached"
            );
        }
    }
}

/// Solves until converged.
pub fn run_solve(engine: &mut dyn Engine, mesh: &Mesh, settings: &Settings) -> SolveRun {
    solve_by_schedule(engine, mesh, &settings.schedule, &mut |_| ControlFlow::Continue(())).expect("the CPU solves")
}
