//! A relight, looked at and mended as a solve is.

use super::warnings::estimate;
use super::work::{Done, Phases, Stage, Work};
use crate::answer::Given;
use crate::answer::check::Estimate;
use crate::answer::light::finite;
use crate::answer::mend::{Solved, had_to_help, mend};
use common::Result;
use common::relight::Method;
use common::settings::{Quality, Settings};
use std::cell::Cell;

/// What is answered.
pub struct Answer {
    /// The relit room.
    pub done: Done,
    /// With which options.
    pub settings: Settings,
    /// How far it may be off.
    pub estimate: Option<Estimate>,
    /// What was mended.
    pub notes: Vec<String>,
}

/// Relights by `method` (none: everything again); options that were not `given` may be changed.
pub fn answer(
    stage: &Stage,
    work: &Work,
    method: Option<Method>,
    given: Given,
    seconds: &mut Phases,
) -> Result<Answer> {
    let mut settings = work.settings.clone();
    let mut done = work.relight(stage, method, seconds)?;
    let mut found = seconds.of("check", || estimate(stage, &settings, &done))?;
    let mut notes = Vec::new();
    let mut before = None;
    // Links with and without the objects are compared: scaling them is no mend here.
    let given = Given {
        form_factor: true,
        ..given
    };
    // A capture that was read has been made with cells of its own: others would not fit it.
    let ours = stage.captured.values.is_none();
    while ours && settings.quality == Quality::Normal && !work.stopped.get() && done.complete {
        let solved = Solved {
            settings: &settings,
            mesh: &done.mesh,
            run: &done.run,
        };
        let better = found
            .as_ref()
            .and_then(|found| mend(given, work.device, &solved, found, before));
        let Some((next, note)) = better else { break };
        let finer = Work {
            settings: &next,
            stopped: Cell::new(false),
            ..*work
        };
        let relit = finer.relight(stage, method, seconds);
        if finer.stopped.get() {
            work.stopped.set(true);
            break;
        }
        done = relit?;
        before = found
            .map(|found| found.error)
            .filter(|_| had_to_help(&settings, &next));
        found = seconds.of("check", || estimate(stage, &next, &done))?;
        settings = next;
        notes.push(note);
    }
    finite(&stage.scene, &done.run)?;
    Ok(Answer {
        done,
        settings,
        estimate: found,
        notes,
    })
}
