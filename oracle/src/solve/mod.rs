//! The pipeline: mesh → engine → run → estimate → mend → warn, and what is written of it. Everything
//! that solves goes this way: `solve`, `relight`, `compare`, the studies and `plan`.

pub mod check;
pub mod dense;
mod gap;
pub mod interrupt;
pub mod ladder;
pub mod light;
pub mod mend;
pub mod refine;
pub mod solved;
pub mod solver;
pub mod task;
pub mod warnings;
pub mod watch;

use check::Estimate;
use common::settings::{Quality, Settings};
use common::solution::{Seconds, Solution, Warning};
use common::{Error, Result};
use light::finite;
use mend::{Attempt, Size, mended};
use refine::refine;
use solved::{Dense, Solved};
use solver::Solver;
use task::Task;
use watch::Watch;

/// What is asked.
#[derive(Clone, Copy)]
pub struct Question<'a> {
    /// What is to be solved.
    pub task: &'a dyn Task,
    /// The options in force.
    pub settings: &'a Settings,
    /// Those that the user gave: they are kept as they are.
    pub given: Given,
    /// Who solves it.
    pub solver: Solver<'a>,
}

/// Which options the user gave.
#[derive(Clone, Copy, Debug, Default)]
pub struct Given {
    /// `--visibility`.
    pub visibility: bool,
    /// `--form-factor`.
    pub form_factor: bool,
    /// `--cells`.
    pub cells: bool,
    /// `--samples`.
    pub samples: bool,
}

impl Given {
    /// Every one of them: nothing is changed.
    pub const ALL: Self = Self {
        visibility: true,
        form_factor: true,
        cells: true,
        samples: true,
    };
}

/// What is answered.
pub struct Answer {
    /// The best solve, on the texels that were asked for.
    pub solved: Solved,
    /// What may be more than 2 % off.
    pub warnings: Vec<Warning>,
    /// How far it may be off; none where that was not looked at.
    pub estimate: Option<Estimate>,
    /// What was chosen, mended and why, a line each.
    pub notes: Vec<String>,
}

impl Answer {
    /// As it is written.
    pub fn solution<'a>(
        &'a self,
        question: &Question<'a>,
        notes: &'a [String],
        seconds: Seconds,
    ) -> Solution<'a> {
        Solution {
            scene: question.task.scene(),
            mesh: &self.solved.mesh,
            solver: question.solver.name(),
            adapter: question.solver.adapter(),
            settings: &self.solved.settings,
            run: &self.solved.run,
            certificate: self.estimate.as_ref().map(Estimate::certificate),
            warnings: &self.warnings,
            notes,
            matrix: self.solved.matrix.as_ref().map(Dense::described),
            relit: None,
            error: question.solver.error(),
            seconds,
        }
    }
}

/// Solves, looks at the answer, and mends it where that is cheap. Stopped, the answer is what there
/// was.
pub fn answer(question: &Question, watch: &Watch) -> Result<Answer> {
    let Question {
        task,
        settings,
        given,
        solver,
    } = *question;
    let once = |settings: &Settings| task.once(settings, solver, watch);
    let (mut notes, mut asked) = (Vec::new(), None);
    let halves = settings.quality == Quality::Reference && !given.cells && task.refines();
    let first = if halves && solver.shoots() {
        let refined = refine(task.scene(), settings, once, || watch.stopped())?;
        notes.extend(refined.notes);
        asked = Some((refined.answer, refined.field));
        refined.rung
    } else {
        once(settings)?
    };
    let mut best = looked_at(task, first, watch)?;
    let may = task.mendable(&best.answer, given);
    if let Some(given) = may.filter(|_| settings.quality == Quality::Normal && !watch.stopped()) {
        let again = |settings: &Settings| {
            let next = once(settings);
            if watch.stopped() || matches!(next, Err(Error::Interrupted)) {
                return Ok(None);
            }
            looked_at(task, next?, watch).map(Some)
        };
        let (found, tried) = mended(given, best, again)?;
        notes.extend(tried);
        best = found;
    }
    let Attempt {
        answer: mut solved,
        mut estimate,
        ..
    } = best;
    finite(task.scene(), &solved.run)?;
    if let Some(dark) = task.dark(&solved) {
        estimate = None;
        notes.push(dark);
    }
    if let (Some(asked), Some(moved)) = (solver.error(), &solved.moved) {
        notes.extend(moved.short_of(asked));
    }
    if watch.stopped() {
        notes.push(if solved.run.converged {
            "interrupted: the last whole solve was kept".into()
        } else {
            "interrupted: the result holds what had been shot by then".into()
        });
    }
    let warnings = task.warnings(&solved, estimate.as_ref());
    if let Some((mesh, field)) = asked {
        (solved.mesh, solved.run.field) = (mesh, field);
    }
    // As they were asked for: more cells may have needed more of them.
    solved.settings.meshing.texels = settings.meshing.texels;
    Ok(Answer {
        solved,
        warnings,
        estimate,
        notes,
    })
}

fn looked_at(task: &dyn Task, solved: Solved, watch: &Watch) -> Result<Attempt<Solved>> {
    let estimate = watch.of("check", || task.estimate(&solved))?;
    let Solved { mesh, run, .. } = &solved;
    Ok(Attempt {
        settings: solved.settings,
        size: Size::of(mesh),
        closure: warnings::closure_in_doubt(mesh, run, estimate.as_ref()).abs(),
        stagnated: run.stagnated,
        converged: run.converged,
        estimate,
        answer: solved,
    })
}
