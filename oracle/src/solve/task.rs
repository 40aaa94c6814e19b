//! What can be solved: a scene, or objects put into a captured room ([`crate::relight::work`]).

use super::check::Estimate;
use super::finder::OnGpu;
use super::interrupt::interrupted;
use super::left::made_up;
use super::light::missing;
use super::solved::Solved;
use super::solver::Solver;
use super::warnings;
use super::watch::Watch;
use super::{check, climb, dense};
use common::Result;
use common::cover::sampled_until;
use common::passes;
use common::scene::Scene;
use common::settings::{Iteration, Settings};
use common::solution::Warning;
use cpu::hierarchy::find::Way;

/// A task of the pipeline.
pub trait Task {
    /// All its faces.
    fn scene(&self) -> &Scene;

    /// Solved once, at these settings.
    fn once(&self, settings: &Settings, solver: Solver, watch: &Watch) -> Result<Solved>;

    /// How far the answer may be off; none where nobody can tell.
    fn estimate(&self, solved: &Solved) -> Result<Option<Estimate>>;

    /// What may be more than 2 % off.
    fn warnings(&self, solved: &Solved, estimate: Option<&Estimate>) -> Vec<Warning>;

    /// Why all is dark, if it is: there is nothing to estimate then.
    fn dark(&self, solved: &Solved) -> Option<String>;
}

impl Task for Scene {
    fn scene(&self) -> &Scene {
        self
    }

    fn once(&self, settings: &Settings, solver: Solver, watch: &Watch) -> Result<Solved> {
        match solver {
            Solver::Matrix => return dense::solve(self, settings, watch),
            Solver::Hierarchy(asked) => {
                return climb::climb(self, settings, asked, Way::Shafts, watch);
            }
            Solver::Linking(gpu, asked) => {
                let maker = OnGpu::maker(gpu, &[]);
                return climb::climb(self, settings, asked, Way::By(&maker), watch);
            }
            Solver::Cpu | Solver::Gpu(_) => {}
        }
        let mesh = watch.of("prepare", || {
            sampled_until(self, &settings.meshing, &interrupted)
        });
        let mesh = mesh.inspect_err(|_| watch.stop())?;
        let mut engine = watch.of("prepare", || solver.engine(&mesh, &settings.transport))?;
        let one_by_one = settings.schedule.iteration != Iteration::Southwell && !engine.has_room();
        let run = watch.of("solve", || {
            let mut told = |done| watch.tell("shooting", done);
            passes::solve(engine.as_mut(), &mesh, &settings.schedule, &mut told)
        })?;
        drop(engine);
        Ok(Solved {
            settings: *settings,
            mesh,
            run,
            one_by_one,
            matrix: None,
            moved: None,
            relit: None,
        })
    }

    fn estimate(&self, solved: &Solved) -> Result<Option<Estimate>> {
        if solved.matrix.is_some() {
            return Ok(None);
        }
        if let Some(moved) = &solved.moved {
            let (mesh, run) = (&solved.mesh, &solved.run);
            return Ok(moved.estimate(mesh, run, made_up(mesh, run)));
        }
        let Solved {
            settings,
            mesh,
            run,
            ..
        } = solved;
        check::estimate(self, settings, mesh, &run.field).map(Some)
    }

    fn warnings(&self, solved: &Solved, estimate: Option<&Estimate>) -> Vec<Warning> {
        let warnings = warnings::of(self, &solved.mesh, &solved.run, estimate);
        match solved.matrix {
            Some(_) => dense::advised(warnings),
            None if solved.moved.is_some() => climb::advised(warnings),
            None => warnings,
        }
    }

    fn dark(&self, solved: &Solved) -> Option<String> {
        missing(&solved.mesh, &solved.run)
    }
}
