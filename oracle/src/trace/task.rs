//! Scenes whose solve is recorded: shot by shot, or link by link.

use super::ShotTrace;
use super::links::LinkRecord;
use super::recorder::{ShotRecorder, TraceLimits};
use crate::solve::gpu_linker::LinkerOnGpu;
use crate::solve::progress::ProgressMonitor;
use crate::solve::regather::ErrorEstimate;
use crate::solve::solve_to_error::solve_with_observer;
use crate::solve::solved::Solved;
use crate::solve::solver::SolverChoice;
use crate::solve::task::{SolveTask, solve_by_shooting};
use common::passes::solve_by_shots;
use common::scene::Scene;
use common::settings::Settings;
use common::solution::Warning;
use common::{Error, Result};
use cpu::hierarchy::linker::{LinkMethod, LinkerFactory};
use std::cell::RefCell;
use std::rc::Rc;

/// The place of a record that a solve with single shots fills.
pub struct TraceSlot {
    /// Limits of the record.
    pub limits: TraceLimits,
    trace: RefCell<Option<ShotTrace>>,
}

impl TraceSlot {
    /// Makes an empty place.
    pub fn new(limits: TraceLimits) -> Self {
        Self {
            limits,
            trace: RefCell::new(None),
        }
    }

    /// Puts a record there.
    pub fn put_trace(&self, trace: ShotTrace) {
        self.trace.replace(Some(trace));
    }

    /// Takes the record of the solve.
    ///
    /// Errors: the scene was not solved.
    pub fn take_trace(&self) -> Result<ShotTrace> {
        let trace = self.trace.borrow_mut().take();
        trace.ok_or_else(|| Error::Fault("no shots were recorded".into()))
    }
}

/// What is recorded of a solve.
pub enum SolveRecord<'a> {
    /// Single shots.
    Shots(&'a TraceSlot),
    /// The links of a solve to an error that does not trace light by rays.
    Links(Rc<LinkRecord>),
}

/// A scene whose solve is recorded.
pub struct TracedScene<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// Receives the record.
    pub record: SolveRecord<'a>,
}

impl TracedScene<'_> {
    fn record_shots(
        &self,
        slot: &TraceSlot,
        settings: &Settings,
        solver: SolverChoice,
        progress: &ProgressMonitor,
    ) -> Result<Solved> {
        solve_by_shooting(self.scene, settings, solver, progress, |engine, mesh, watch| {
            let mut recorder = ShotRecorder::new(engine, mesh, &settings.transport, slot.limits)?;
            let run = solve_by_shots(&mut recorder, &settings.schedule, watch)?;
            slot.put_trace(recorder.into_trace());
            Ok(run)
        })
    }

    fn record_links(
        &self,
        record: &Rc<LinkRecord>,
        settings: &Settings,
        solver: SolverChoice,
        progress: &ProgressMonitor,
    ) -> Result<Solved> {
        let Some(target) = solver.error_target() else {
            return Err(Error::Usage(format!("{} has no links to record", solver.name())));
        };
        let on_gpu = solver.gpu().map(|gpu| LinkerOnGpu::factory_on(gpu, &[]));
        let linkers = on_gpu.as_ref().map(|factory| factory as LinkerFactory);
        let recording = record.recording_factory(linkers);
        let method = LinkMethod::Custom(&recording);
        let observer = |step: &_, goal| record.end_step(step, goal);
        solve_with_observer(self.scene, settings, target, (method, &observer), progress)
    }
}

impl SolveTask for TracedScene<'_> {
    fn scene(&self) -> &Scene {
        self.scene
    }

    fn solve_once(&self, settings: &Settings, solver: SolverChoice, progress: &ProgressMonitor) -> Result<Solved> {
        match &self.record {
            SolveRecord::Shots(slot) => self.record_shots(slot, settings, solver, progress),
            SolveRecord::Links(record) => self.record_links(record, settings, solver, progress),
        }
    }

    fn estimate_error(&self, solved: &Solved) -> Result<Option<ErrorEstimate>> {
        self.scene.estimate_error(solved)
    }

    fn collect_warnings(&self, solved: &Solved, estimate: Option<&ErrorEstimate>) -> Vec<Warning> {
        self.scene.collect_warnings(solved, estimate)
    }

    fn explain_darkness(&self, solved: &Solved) -> Option<String> {
        self.scene.explain_darkness(solved)
    }
}
