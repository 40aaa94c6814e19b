//! Effort of a solve to a given error: shots of plain Southwell, ε of the default iteration. The truth
//! is the converged solution of the same texels, form factors and rays.

use common::mesh::Mesh;
use common::passes::Engine;
use common::settings::{Schedule, Settings};
use common::shooting::{DepositRule, RadiosityField, initial_field};
use cpu::CpuSolver;
use glam::Vec3;
use radiosity_tests::engines::solve_by_schedule;
use radiosity_tests::relighting::relative_error;

/// Share of unshot power at which a solution counts as converged.
const CONVERGED_EPSILON: f64 = 1e-6;
/// Factor of ε from one try to the next.
const EPSILON_STEP: f64 = 0.9;

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
        let mut schedule = settings.schedule.with_southwell();
        schedule.epsilon = CONVERGED_EPSILON;
        let run = solve_by_schedule(&mut CpuSolver::new(&mesh, &settings.transport), &mesh, &schedule);
        assert!(run.converged, "the truth must have converged");
        Self {
            mesh,
            settings,
            truth: run.field,
        }
    }

    /// Returns the relative RMS error √(ΣA(a−b)² / ΣA b²) of B − E, worst channel.
    pub fn relative_rms(&self, field: &RadiosityField) -> f64 {
        relative_error(&self.mesh, field, &self.truth)
    }

    /// Returns the shooters of plain Southwell until the error is at most `bound`.
    pub fn southwell_shots(&self, bound: f64) -> Vec<u32> {
        let schedule = Schedule {
            epsilon: 0.0,
            max_shots: 1,
            ..self.settings.schedule.with_southwell()
        };
        let mut engine = CpuSolver::new(&self.mesh, &self.settings.transport);
        let mut shots = Vec::new();
        loop {
            let run = solve_by_schedule(&mut engine, &self.mesh, &schedule);
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
            if self.relative_rms(&solve_by_schedule(&mut engine, &self.mesh, &settings.schedule).field) <= bound {
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
