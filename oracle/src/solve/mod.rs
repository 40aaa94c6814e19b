//! A scene solved as `solve` does it: refined on request, checked, mended, and with a warning where
//! the answer may be more than 2 % off.

pub mod check;
pub mod dense;
mod gap;
pub mod interrupt;
pub mod light;
pub mod mend;
pub mod refine;
pub mod warnings;

use crate::solve::interrupt::interrupted;
use crate::solve::refine::{Rung, refine};
use check::Estimate;
use common::mesh::Mesh;
use common::passes::Engine;
use common::passes::solve;
use common::scene::Scene;
use common::settings::{Quality, Settings};
use common::shooting::Run;
use common::solution::Warning;
use common::{Error, Result};
use cpu::CpuSolver;
use cpu::occlusion::cover::sampled_until;
use gpu::{Gpu, GpuSolver};
use light::{finite, missing};
use mend::{Attempt, Size, mended};
use std::cell::Cell;
use std::ops::ControlFlow;
use std::time::Instant;

/// What is asked.
#[derive(Clone, Copy)]
pub struct Question<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The options in force.
    pub settings: &'a Settings,
    /// Those that the user gave: they are kept as they are.
    pub given: Given,
    /// The GPU; none: the CPU.
    pub gpu: Option<&'a Gpu>,
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
    /// The options of the solve; `texels` as they were asked for.
    pub settings: Settings,
    /// Texels of the answer.
    pub mesh: Mesh,
    /// The run, its field on those texels.
    pub run: Run,
    /// What may be more than 2 % off.
    pub warnings: Vec<Warning>,
    /// How far it may be off; none where that was not looked at.
    pub estimate: Option<Estimate>,
    /// What was chosen, mended and why, a line each.
    pub notes: Vec<String>,
    /// Seconds before shooting.
    pub prepare: f64,
    /// Seconds of shooting.
    pub solve: f64,
}

/// Told the share done, 0…1; may break: then the answer is what there was.
pub type Watch<'a> = &'a dyn Fn(f64) -> ControlFlow<()>;

/// Solves, looks at the answer, and mends it where that is cheap.
pub fn answer(question: &Question, watch: Watch) -> Result<Answer> {
    let seconds = Cell::new((0.0, 0.0));
    let stopped = Cell::new(false);
    let solved = |settings: &Settings| rung(question, settings, watch, &stopped, &seconds);
    let (scene, settings) = (question.scene, question.settings);
    let mut notes = Vec::new();
    let (rung, mut refined) = if settings.quality == Quality::Reference && !question.given.cells {
        let refined = refine(scene, settings, solved, || stopped.get())?;
        notes.extend(refined.notes);
        (refined.rung, Some((refined.answer, refined.field)))
    } else {
        (solved(settings)?, None)
    };
    let mut first = looked_at(scene, rung)?;
    let healthy = first.answer.run.converged || first.stagnated;
    if settings.quality == Quality::Normal && healthy && !stopped.get() {
        let again = |settings: &Settings| {
            let next = match solved(settings) {
                Err(Error::Interrupted) => return Ok(None),
                next => next?,
            };
            (!stopped.get()).then(|| looked_at(scene, next)).transpose()
        };
        let (best, tried) = mended(question.given, first, again)?;
        notes.extend(tried);
        first = best;
    }
    let Attempt {
        answer: rung,
        estimate,
        ..
    } = first;
    finite(scene, &rung.run)?;
    let mut estimate = estimate;
    if let Some(dark) = missing(&rung.mesh, &rung.run) {
        // Of no light there is nothing to estimate.
        estimate = None;
        notes.push(dark);
    }
    notes.extend(fewer_cells(&rung.settings));
    if stopped.get() {
        notes.push(if rung.run.converged {
            "interrupted: the last whole solve was kept".into()
        } else {
            "interrupted: the result is what had been shot by then".into()
        });
    }
    let warnings = warnings::of(scene, &rung.mesh, &rung.run, estimate.as_ref());
    let (mesh, field) = refined
        .take()
        .unwrap_or_else(|| (rung.mesh.clone(), rung.run.field.clone()));
    let (prepare, solve) = seconds.get();
    Ok(Answer {
        warnings,
        estimate,
        settings: Settings {
            texels: settings.texels,
            ..rung.settings
        },
        mesh,
        run: Run { field, ..rung.run },
        notes,
        prepare,
        solve,
    })
}

fn looked_at(scene: &Scene, rung: Rung) -> Result<Attempt<Rung>> {
    let (mesh, run) = (&rung.mesh, &rung.run);
    let estimate = Some(check::estimate(scene, &rung.settings, mesh, &run.field)?);
    Ok(Attempt {
        settings: rung.settings.clone(),
        size: Size::of(mesh),
        closure: warnings::closure_in_doubt(mesh, run, estimate.as_ref()).abs(),
        stagnated: run.stagnated,
        converged: run.converged,
        estimate,
        answer: rung,
    })
}

/// One solve at given settings.
fn rung(
    question: &Question,
    settings: &Settings,
    watch: Watch,
    stopped: &Cell<bool>,
    seconds: &Cell<(f64, f64)>,
) -> Result<Rung> {
    let start = Instant::now();
    let mesh =
        sampled_until(question.scene, settings, &interrupted).inspect_err(|_| stopped.set(true))?;
    let mut engine: Box<dyn Engine> = match question.gpu {
        Some(gpu) => Box::new(GpuSolver::new(gpu, &mesh, settings)?),
        None => Box::new(CpuSolver::new(&mesh, settings)),
    };
    let prepared = start.elapsed().as_secs_f64();
    let run = solve(engine.as_mut(), &mesh, settings, &mut |done| {
        let flow = watch(done);
        stopped.set(stopped.get() || flow.is_break());
        flow
    })?;
    let (before, shooting) = seconds.get();
    let all = start.elapsed().as_secs_f64();
    seconds.set((before + prepared, shooting + all - prepared));
    drop(engine);
    Ok(Rung {
        settings: settings.clone(),
        mesh,
        run,
    })
}

/// Cells are blocks of whole texels.
fn fewer_cells(settings: &Settings) -> Option<String> {
    let Settings { cells, texels, .. } = settings;
    (cells > texels).then(|| {
        format!(
            "{texels}×{texels} cells a face instead of {cells}×{cells}: each has a texel at least"
        )
    })
}
