//! What a solve to a given error takes: shots of plain Southwell, ε and time of the default solve.
//! The truth is the converged solution of the same texels, form factors and rays.

use common::mesh::Mesh;
use common::passes::Engine;
use common::passes::solve;
use common::settings::{Iteration, Schedule, Settings};
use common::shooting::{Field, Rule, Run, initial};
use cpu::CpuSolver;
use glam::{DVec3, Vec3};
use std::ops::ControlFlow;

/// Unshot share at which a solution counts as converged.
const CONVERGED: f64 = 1e-6;
/// ε falls by this from one try to the next.
const STEP: f64 = 0.9;

/// Plain Southwell: one shot after the other, most unshot power first.
pub fn southwell(settings: &Settings) -> Settings {
    Settings {
        schedule: Schedule {
            iteration: Iteration::Southwell,
            ..settings.schedule
        },
        ..*settings
    }
}

/// A mesh, how it is solved, and where that must end.
#[derive(Clone)]
pub struct Target {
    /// The texels.
    pub mesh: Mesh,
    /// How it is solved, ε aside.
    pub settings: Settings,
    truth: Field,
}

impl Target {
    /// Solves until it has converged.
    pub fn new(mesh: Mesh, settings: Settings) -> Self {
        let mut settings_of_truth = southwell(&settings);
        settings_of_truth.schedule.epsilon = CONVERGED;
        let run = run(
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

    /// √(ΣA(a−b)² / ΣA b²) of B − E, the worst channel.
    pub fn error(&self, field: &Field) -> f64 {
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
        share
            .to_array()
            .map(f64::sqrt)
            .into_iter()
            .fold(0.0, f64::max)
    }

    /// The shooters of plain Southwell until the error is no larger than `bound`.
    pub fn southwell_shots(&self, bound: f64) -> Vec<u32> {
        let mut settings = southwell(&self.settings);
        settings.schedule.epsilon = 0.0;
        settings.schedule.max_shots = 1;
        let mut engine = CpuSolver::new(&self.mesh, &settings.transport);
        let mut shots = Vec::new();
        loop {
            let run = run(&mut engine, &self.mesh, &settings);
            assert!(!run.shots.is_empty(), "{bound} is never reached");
            shots.extend(run.cells());
            if self.error(&run.field) <= bound {
                return shots;
            }
        }
    }

    /// Back to B = r = E; links stay.
    pub fn restart(&self, engine: &mut dyn Engine) {
        let start = initial(&self.mesh, "cpu");
        let reflectance: Vec<Vec3> = self.mesh.texels.iter().map(|t| t.reflectance).collect();
        engine
            .restart(Rule::PLAIN, &reflectance, &start)
            .expect("the CPU solver restarts");
    }

    /// The settings whose ε is the largest of a ladder with an error no larger than `bound`.
    pub fn settings_to(&self, bound: f64) -> Settings {
        let mut settings = self.settings;
        settings.schedule.epsilon = 0.5;
        let mut engine = CpuSolver::new(&self.mesh, &settings.transport);
        loop {
            // Links stay, so that a try takes little.
            self.restart(&mut engine);
            if self.error(&run(&mut engine, &self.mesh, &settings).field) <= bound {
                return settings;
            }
            settings.schedule.epsilon *= STEP;
            assert!(
                settings.schedule.epsilon > CONVERGED,
                "{bound} is never reached"
            );
        }
    }
}

/// A solve to the end.
pub fn run(engine: &mut dyn Engine, mesh: &Mesh, settings: &Settings) -> Run {
    solve(engine, mesh, &settings.schedule, &mut |_| {
        ControlFlow::Continue(())
    })
    .expect("the CPU solves")
}
