//! The pipeline: mesh → engine → run → estimate → warn, and what is written of it. Everything that
//! solves goes this way: `solve`, `relight`, `compare`, the studies and `plan`.

pub mod anew;
pub mod change;
pub mod check;
pub mod climb;
pub mod dense;
pub mod finder;
mod foot;
mod gap;
pub mod interrupt;
pub mod ladder;
pub mod left;
pub mod light;
pub mod moved;
pub mod near;
pub mod sides;
pub mod solved;
pub mod solver;
pub mod step;
pub mod task;
pub mod warnings;
pub mod watch;

use check::Estimate;
use common::Result;
use common::scene::Scene;
use common::settings::Settings;
use common::solution::{Seconds, Solution, Warning};
use light::finite;
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
    /// Who solves it.
    pub solver: Solver<'a>,
}

/// What is answered.
pub struct Answer {
    /// The solve, on the texels that were asked for.
    pub solved: Solved,
    /// What may be more than 2 % off.
    pub warnings: Vec<Warning>,
    /// How far it may be off; none where that was not looked at.
    pub estimate: Option<Estimate>,
    /// What was chosen and why, a line each.
    pub notes: Vec<String>,
}

impl Answer {
    /// How far each texel may be off, where that is known.
    pub fn off(&self, scene: &Scene) -> Option<Vec<f32>> {
        let moved = self.solved.moved.as_ref()?;
        moved.map(&scene.faces, &self.solved.mesh)
    }

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
            off: self.off(question.task.scene()),
            warnings: &self.warnings,
            notes,
            matrix: self.solved.matrix.as_ref().map(Dense::described),
            relit: None,
            error: question.solver.asked().map(|asked| asked.error),
            seconds,
        }
    }
}

/// Solves, and looks at the answer. Stopped, the answer is what there was.
pub fn answer(question: &Question, watch: &Watch) -> Result<Answer> {
    let Question {
        task,
        settings,
        solver,
    } = *question;
    let solved = task.once(settings, solver, watch)?;
    let mut estimate = watch.of("check", || task.estimate(&solved))?;
    finite(task.scene(), &solved.run)?;
    let mut notes = Vec::new();
    if let Some(dark) = task.dark(&solved) {
        estimate = None;
        notes.push(dark);
    }
    if let (Some(asked), Some(moved)) = (solver.asked(), &solved.moved) {
        notes.extend(moved.short_of(asked.error, estimate.as_ref()));
        notes.extend(estimate.as_ref().and_then(Estimate::worse));
    }
    if watch.stopped() {
        notes.push(if solved.run.converged {
            "interrupted: the last whole solve was kept".into()
        } else {
            "interrupted: the result holds what had been shot by then".into()
        });
    }
    let warnings = task.warnings(&solved, estimate.as_ref());
    Ok(Answer {
        solved,
        warnings,
        estimate,
        notes,
    })
}
