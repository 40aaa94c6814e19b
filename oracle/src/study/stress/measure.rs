//! One method on one solver: solved under guard, timed and judged.

use super::judge;
use super::methods::{DEFAULT, Method, Way};
use super::trial::{Suite, Trial};
use super::{Side, UNJUDGED, Verdict};
use crate::judge::diff::reflected::Reflected;
use crate::relight::stage::Stage;
use crate::relight::work::Relighting;
use crate::solve::solved::Solved;
use crate::solve::solver::{Asked, REFERENCE, Solver, USUAL};
use crate::solve::watch::Watch;
use crate::solve::{Answer, Question, answer};
use common::mesh::Mesh;
use common::shooting::Field;
use common::{Error, Result};
use glam::DVec3;
use gpu::Gpu;
use std::any::Any;
use std::cell::Cell;
use std::ops::ControlFlow;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::Instant;

/// A solve that takes longer is given up, seconds: ten times what the longest takes, since a verdict must not
/// hang on what else the machine does.
pub const LONGEST: f64 = 200.0;

/// What a solve came to.
pub struct Tried {
    /// For the row.
    pub side: Side,
    /// The answer, if there is one.
    pub answer: Option<Seen>,
}

/// An answer to be looked at.
pub struct Seen {
    /// Its texels.
    pub mesh: Mesh,
    /// Its state.
    pub field: Field,
    /// B − E in face order.
    pub values: Vec<DVec3>,
}

/// Tries; none where `stop` said so.
pub fn try_on(
    trial: &Trial,
    method: &Method,
    gpu: Option<&Gpu>,
    truth: &[DVec3],
    stop: &dyn Fn() -> bool,
) -> Option<Tried> {
    let start = Instant::now();
    let late = Cell::new(false);
    let show = |_: &str, _| {
        late.set(late.get() || start.elapsed().as_secs_f64() > LONGEST);
        if late.get() || stop() {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    };
    let watch = Watch::new(&show);
    let solved = guarded(|| solve(trial, method, gpu, &watch));
    let seconds = start.elapsed().as_secs_f64();
    if stop() {
        return None;
    }
    let mut side = Side {
        error: None,
        noise: 0.0,
        bias: None,
        estimate: None,
        // Until its row judges it by the measure of the case.
        verdict: Verdict::Fails,
        warnings: Vec::new(),
        notes: Vec::new(),
        message: None,
        seconds,
    };
    let solved = match solved {
        _ if late.get() => Err(format!("took longer than {LONGEST} s")),
        other => other,
    };
    let answer = match solved {
        Err(message) => {
            side.message = Some(message);
            None
        }
        Ok(answer) => {
            side.warnings = answer
                .warnings
                .iter()
                .map(|w| w.code.text().into())
                .collect();
            side.notes = answer.notes;
            side.estimate = answer.estimate.map(|estimate| estimate.error);
            let Solved { mesh, run, .. } = answer.solved;
            let values = Reflected::of(&trial.scene, &mesh, &run.field).values;
            match judge::error(trial, &values, truth) {
                Ok((error, noise)) => {
                    side.error = Some(error);
                    side.noise = noise;
                    side.bias = judge::bias(trial, &values, truth);
                }
                Err(message) => side.message = Some(format!("{UNJUDGED}: {message}")),
            }
            Some(Seen {
                mesh,
                field: run.field,
                values,
            })
        }
    };
    Some(Tried { side, answer })
}

/// A panic is a verdict, not the end of the atlas.
fn guarded(solve: impl FnOnce() -> Result<Answer>) -> std::result::Result<Answer, String> {
    match catch_unwind(AssertUnwindSafe(solve)) {
        Ok(result) => result.map_err(|error| error.to_string()),
        Err(payload) => Err(format!("panic: {}", said(payload.as_ref()))),
    }
}

fn said(payload: &(dyn Any + Send)) -> &str {
    let text = payload.downcast_ref::<String>().map(String::as_str);
    text.or_else(|| payload.downcast_ref::<&str>().copied())
        .unwrap_or("without a word")
}

fn solve(trial: &Trial, method: &Method, gpu: Option<&Gpu>, watch: &Watch) -> Result<Answer> {
    let settings = method.settings(trial.texels, gpu.is_some());
    let question = |task, solver| Question {
        task,
        settings: &settings,
        solver,
    };
    let to = |error| {
        let texels = Some(trial.texels);
        Solver::to_error(gpu, Asked { error, texels })
    };
    let name = method.name;
    match method.way {
        Way::Default => answer(&question(&trial.scene, to(USUAL)), watch),
        Way::Reference => answer(&question(&trial.scene, to(REFERENCE)), watch),
        Way::Matrix => answer(&question(&trial.scene, Solver::Matrix), watch),
        Way::Given(_) => answer(&question(&trial.scene, Solver::on(gpu)), watch),
        Way::Relight(way, _) => {
            let stage = stage(trial)?;
            let task = Relighting {
                stage: &stage,
                method: way,
            };
            let solver = match name {
                DEFAULT => to(USUAL),
                _ => Solver::on(gpu),
            };
            answer(&question(&task, solver), watch)
        }
    }
}

/// The trial's room with its objects.
fn stage(trial: &Trial) -> Result<Stage> {
    let Suite::Relight(room) = trial.suite else {
        return Err(Error::Usage("there is no room to relight".into()));
    };
    Ok(Stage::new(&trial.scene, room, trial.texels))
}
