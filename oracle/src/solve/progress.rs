//! Progress of a solve: reports to a callback, cancellation, and the time of each phase. The program shows bars by it,
//! and studies stop solves by it.

use super::interrupt::is_interrupted;
use common::{Error, Result};
use std::cell::{Cell, RefCell};
use std::ops::ControlFlow;
use web_time::Instant;

/// Callback with a phase's name and its finished share, 0…1; a break cancels the work.
pub type PhaseCallback<'a> = &'a dyn Fn(&str, f64) -> ControlFlow<()>;

/// Reports the progress of one piece of work and records the time of its phases.
pub struct ProgressMonitor<'a> {
    callback: PhaseCallback<'a>,
    stopped: Cell<bool>,
    phases: RefCell<Vec<(&'static str, f64)>>,
}

impl<'a> ProgressMonitor<'a> {
    /// Makes a monitor that reports to `show`.
    pub fn new(show: PhaseCallback<'a>) -> Self {
        Self {
            callback: show,
            stopped: Cell::new(false),
            phases: RefCell::default(),
        }
    }

    /// Reports the finished share of a phase. A break is remembered.
    pub fn report_share(&self, phase: &str, done: f64) -> ControlFlow<()> {
        let flow = (self.callback)(phase, done);
        if flow.is_break() {
            self.mark_stopped();
        }
        flow
    }

    /// Reports that `done` of `all` steps of a phase are finished.
    pub fn report_count(&self, phase: &str, done: u64, all: u64) -> ControlFlow<()> {
        self.report_share(phase, done as f64 / all.max(1) as f64)
    }

    /// Reports the start of a phase.
    ///
    /// Errors: [`Error::Interrupted`].
    pub fn begin_phase(&self, phase: &str) -> Result<()> {
        match self.report_share(phase, 0.0) {
            ControlFlow::Continue(()) => Ok(()),
            ControlFlow::Break(()) => Err(Error::Interrupted),
        }
    }

    /// Marks the work as stopped.
    pub fn mark_stopped(&self) {
        self.stopped.set(true);
    }

    /// True if the work was stopped.
    pub fn is_stopped(&self) -> bool {
        self.stopped.get()
    }

    /// Does the work and records its time under `phase`.
    pub fn time_phase<T>(&self, phase: &'static str, work: impl FnOnce() -> T) -> T {
        let start = Instant::now();
        let result = work();
        let seconds = start.elapsed().as_secs_f64();
        self.phases.borrow_mut().push((phase, seconds));
        result
    }

    /// Total seconds of the named phases.
    pub fn phase_seconds(&self, phases: &[&str]) -> f64 {
        let all = self.phases.borrow();
        let named = all.iter().filter(|(name, _)| phases.contains(name));
        named.map(|(_, seconds)| seconds).sum()
    }
}

/// Makes a monitor that reports nothing.
pub fn without_progress() -> ProgressMonitor<'static> {
    ProgressMonitor::new(&|_, _| ControlFlow::Continue(()))
}

/// Returns a callback that reports a step's progress and breaks on an interruption.
pub fn step_progress<'a>(progress: &'a ProgressMonitor, phase: &'a str) -> impl FnMut(f64) -> ControlFlow<()> + 'a {
    move |done| {
        if is_interrupted() {
            progress.mark_stopped();
            return ControlFlow::Break(());
        }
        progress.report_share(phase, done)
    }
}
