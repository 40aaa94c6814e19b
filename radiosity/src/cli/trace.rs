//! `--trace`: records a solve and renders trace.html.

use super::console::message;
use crate::plan::SceneCounts;
use crate::report::solution_view::RenderedView;
use crate::report::trace::links::{LinkPage, MAX_RECORDED_LINKS};
use crate::report::trace::{TRACE_LIMITS, TracePage, check_trace_limits};
use common::scene::Scene;
use common::settings::Settings;
use common::solution::Solution;
use common::{Error, Result};
use cpu::hierarchy::linker::LinkMethod;
use oracle::solve::adaptive::follows_rays;
use oracle::solve::solver::SolverChoice;
use oracle::trace::links::LinkRecord;
use oracle::trace::task::{SolveRecord, TraceSlot, TracedScene};
use std::rc::Rc;

/// Page of a traced solve.
pub const TRACE_FILE: &str = "trace.html";

/// The record that a solve leaves for `trace.html`.
pub enum Recorder {
    /// None.
    Nothing,
    /// Its shots.
    Shots(Box<TraceSlot>),
    /// Its links.
    Links(Rc<LinkRecord>),
}

impl Recorder {
    /// Makes an empty record of shots.
    pub fn of_shots() -> Self {
        Self::Shots(Box::new(TraceSlot::new(TRACE_LIMITS)))
    }

    /// Makes an empty record of links.
    pub fn of_links() -> Self {
        Self::Links(LinkRecord::new(MAX_RECORDED_LINKS))
    }

    /// Returns the scene as a task whose solve is recorded; none if nothing is.
    ///
    /// Errors: [`Error::Usage`] of a scene that a page cannot show, or that rays solve.
    pub fn record_scene<'a>(
        &'a self,
        scene: &'a Scene,
        settings: &Settings,
        solver: SolverChoice,
    ) -> Result<Option<TracedScene<'a>>> {
        let SceneCounts { faces, texels, .. } = SceneCounts::new(scene, &settings.meshing);
        Ok(match self {
            Self::Nothing => None,
            Self::Shots(slot) => {
                check_trace_limits(&scene.name, faces, texels)?;
                Some(TracedScene {
                    scene,
                    record: SolveRecord::Shots(slot),
                })
            }
            Self::Links(record) => {
                let target = solver.error_target().filter(|_| solver.gpu().is_none());
                if target.is_some_and(|target| follows_rays(scene, target.error, LinkMethod::Shafts)) {
                    return Err(Error::Usage(format!(
                        "{}: --trace shows links, and rays solve a scene of {faces} faces to this error: trace a smaller scene, or its shots with `radiosity shoot --trace`",
                        scene.name
                    )));
                }
                Some(TracedScene {
                    scene,
                    record: SolveRecord::Links(Rc::clone(record)),
                })
            }
        })
    }

    /// Renders trace.html; prints a note if it does not show all, and returns none if it would show nothing.
    pub fn render_page(&self, solution: &Solution, seen: &RenderedView) -> Result<Option<String>> {
        match self {
            Self::Nothing => Ok(None),
            Self::Shots(slot) => render_trace(solution, slot, seen),
            Self::Links(record) => {
                let page = LinkPage::new(solution, &record.take_trace(), &seen.preview);
                if let Some(note) = page.describe_missing_steps() {
                    message!("note: {note}");
                }
                Ok((page.steps > 0).then_some(page.html))
            }
        }
    }
}

/// Renders trace.html; prints a note if not all shots fit, and returns none if not even the first does.
pub fn render_trace(solution: &Solution, slot: &TraceSlot, seen: &RenderedView) -> Result<Option<String>> {
    let page = TracePage::new(solution, &slot.take_trace()?, &seen.preview);
    if let Some(note) = page.describe_missing_shots() {
        message!("note: {note}");
    }
    Ok((page.shots > 0 || page.shot_count == 0).then_some(page.html))
}
