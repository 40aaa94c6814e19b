//! Who is told how far the work has come, may stop it, and learns how long each part of it took.

use common::{Error, Result};
use std::cell::{Cell, RefCell};
use std::ops::ControlFlow;
use std::time::Instant;

/// Told a phase and the share of it that is done, 0…1; may break.
pub type Show<'a> = &'a dyn Fn(&str, f64) -> ControlFlow<()>;

/// One for a piece of work.
pub struct Watch<'a> {
    show: Show<'a>,
    stopped: Cell<bool>,
    phases: RefCell<Vec<(&'static str, f64)>>,
}

impl<'a> Watch<'a> {
    /// One that tells `show`.
    pub fn new(show: Show<'a>) -> Self {
        Self {
            show,
            stopped: Cell::new(false),
            phases: RefCell::default(),
        }
    }

    /// So much of a phase is done; a break lasts.
    pub fn tell(&self, phase: &str, done: f64) -> ControlFlow<()> {
        let flow = (self.show)(phase, done);
        if flow.is_break() {
            self.stop();
        }
        flow
    }

    /// `done` of `all` steps are done.
    pub fn count(&self, phase: &str, done: u64, all: u64) -> ControlFlow<()> {
        self.tell(phase, done as f64 / all.max(1) as f64)
    }

    /// A phase begins, unless it is to stop.
    ///
    /// Errors: [`Error::Interrupted`].
    pub fn begin(&self, phase: &str) -> Result<()> {
        match self.tell(phase, 0.0) {
            ControlFlow::Continue(()) => Ok(()),
            ControlFlow::Break(()) => Err(Error::Interrupted),
        }
    }

    /// From now on it is stopped.
    pub fn stop(&self) {
        self.stopped.set(true);
    }

    /// Whether it was stopped.
    pub fn stopped(&self) -> bool {
        self.stopped.get()
    }

    /// Does the work and notes how long it took.
    pub fn of<T>(&self, phase: &'static str, work: impl FnOnce() -> T) -> T {
        let start = Instant::now();
        let result = work();
        let seconds = start.elapsed().as_secs_f64();
        self.phases.borrow_mut().push((phase, seconds));
        result
    }

    /// Seconds of some phases.
    pub fn seconds(&self, phases: &[&str]) -> f64 {
        let all = self.phases.borrow();
        let asked = all.iter().filter(|(name, _)| phases.contains(name));
        asked.map(|(_, seconds)| seconds).sum()
    }

    /// Seconds of every piece of work, in order.
    pub fn phases(&self) -> Vec<(&'static str, f64)> {
        self.phases.borrow().clone()
    }
}

/// For work at which nobody looks.
pub fn unwatched() -> Watch<'static> {
    Watch::new(&|_, _| ControlFlow::Continue(()))
}
