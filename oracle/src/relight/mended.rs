//! A relight, checked and mended as a solve is.

use super::warnings::estimate;
use super::work::{Done, Phases, Stage, Work};
use crate::solve::Given;
use crate::solve::check::Estimate;
use crate::solve::light::finite;
use crate::solve::mend::{Attempt, Size, mended};
use crate::solve::warnings::closure_in_doubt;
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
    let settings = work.settings.clone();
    let done = work.relight(stage, method, seconds)?;
    let mut first = looked_at(stage, settings, done, seconds)?;
    let mut notes = Vec::new();
    // Links with and without the objects are compared: scaling them is no mend here.
    let given = Given {
        form_factor: true,
        ..given
    };
    // A capture that was read has been made with cells of its own: others would not fit it.
    let ours = stage.captured.values.is_none();
    let whole = !work.stopped.get() && first.answer.complete;
    if ours && whole && work.settings.quality == Quality::Normal {
        let again = |settings: &Settings| {
            let finer = Work {
                settings,
                stopped: Cell::new(false),
                ..*work
            };
            let relit = finer.relight(stage, method, seconds);
            if finer.stopped.get() {
                work.stopped.set(true);
                return Ok(None);
            }
            looked_at(stage, settings.clone(), relit?, seconds).map(Some)
        };
        (first, notes) = mended(given, first, again)?;
    }
    finite(&stage.scene, &first.answer.run)?;
    Ok(Answer {
        done: first.answer,
        settings: first.settings,
        estimate: first.estimate,
        notes,
    })
}

fn looked_at(
    stage: &Stage,
    settings: Settings,
    done: Done,
    seconds: &mut Phases,
) -> Result<Attempt<Done>> {
    let found = seconds.of("check", || estimate(stage, &settings, &done))?;
    Ok(Attempt {
        size: Size::of(&done.mesh),
        closure: closure_in_doubt(&done.mesh, &done.run, found.as_ref()).abs(),
        stagnated: done.run.stagnated,
        converged: done.run.converged,
        estimate: found,
        answer: done,
        settings,
    })
}
