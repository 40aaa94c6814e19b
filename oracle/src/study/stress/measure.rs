//! One method on one solver: solved under guard, timed and judged.

use super::judge;
use super::methods::{DEFAULT, Method, Way};
use super::trial::{Suite, Trial};
use super::{Side, UNJUDGED, Verdict};
use crate::judge::diff::reflected::Reflected;
use crate::relight::mended::answer as relight;
use crate::relight::room::Captured;
use crate::relight::warnings;
use crate::relight::work::{Phases, Stage, Work};
use crate::solve::dense;
use crate::solve::{Given, Question, answer};
use common::mesh::Mesh;
use common::relight::Method as Relighting;
use common::scene::Scene;
use common::settings::Settings;
use common::shooting::Field;
use common::solution::Warning;
use common::{Error, Result};
use cpu::matrix::Matrix;
use glam::DVec3;
use gpu::Gpu;
use std::any::Any;
use std::cell::Cell;
use std::ops::ControlFlow;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::Instant;

/// A solve that takes longer is given up, seconds.
pub const LONGEST: f64 = 60.0;

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

struct Solved {
    mesh: Mesh,
    field: Field,
    warnings: Vec<Warning>,
    notes: Vec<String>,
    estimate: Option<f64>,
}

type Watch<'a> = &'a dyn Fn() -> ControlFlow<()>;

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
    let watch = || {
        late.set(late.get() || start.elapsed().as_secs_f64() > LONGEST);
        if late.get() || stop() {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    };
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
        mended: Vec::new(),
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
        Ok(solved) => {
            side.warnings = solved
                .warnings
                .iter()
                .map(|w| w.code.text().into())
                .collect();
            side.mended = solved.notes;
            side.estimate = solved.estimate;
            let values = Reflected::of(&trial.scene, &solved.mesh, &solved.field).values;
            match judge::error(trial, &values, truth) {
                Ok((error, noise)) => {
                    side.error = Some(error);
                    side.noise = noise;
                    side.bias = judge::bias(trial, &values, truth);
                }
                Err(message) => side.message = Some(format!("{UNJUDGED}: {message}")),
            }
            Some(Seen {
                mesh: solved.mesh,
                field: solved.field,
                values,
            })
        }
    };
    Some(Tried { side, answer })
}

/// A panic is a verdict, not the end of the atlas.
fn guarded(solve: impl FnOnce() -> Result<Solved>) -> std::result::Result<Solved, String> {
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

fn solve(trial: &Trial, method: &Method, gpu: Option<&Gpu>, watch: Watch) -> Result<Solved> {
    let settings = method.settings(trial.texels, gpu.is_some());
    match method.way {
        Way::Default | Way::Reference => {
            shot(&trial.scene, &settings, Given::default(), gpu, watch)
        }
        Way::Given(_) => shot(&trial.scene, &settings, Given::ALL, gpu, watch),
        Way::Matrix => by_matrix(&trial.scene, &settings, watch),
        Way::Relight(relighting, _) => {
            let Suite::Relight(room) = trial.suite else {
                return Err(Error::Usage("there is no room to relight".into()));
            };
            let given = if method.name == DEFAULT {
                Given::default()
            } else {
                Given::ALL
            };
            relit(trial, (room, relighting, given), &settings, gpu, watch)
        }
    }
}

fn shot(
    scene: &Scene,
    settings: &Settings,
    given: Given,
    gpu: Option<&Gpu>,
    watch: Watch,
) -> Result<Solved> {
    let question = Question {
        scene,
        settings,
        given,
        gpu,
    };
    let answered = answer(&question, &|_| watch())?;
    Ok(Solved {
        mesh: answered.mesh,
        field: answered.run.field,
        estimate: answered.estimate.map(|estimate| estimate.error),
        warnings: answered.warnings,
        notes: answered.notes,
    })
}

fn by_matrix(scene: &Scene, settings: &Settings, watch: Watch) -> Result<Solved> {
    let mesh = Mesh::uniform(scene, settings.texels, 1)?;
    let (matrix, _) = Matrix::assemble(scene, &mesh, &mut |_, _| watch())?;
    let (run, _) = dense::solve(&mesh, &matrix)?;
    Ok(Solved {
        field: run.field,
        mesh,
        warnings: Vec::new(),
        notes: Vec::new(),
        estimate: None,
    })
}

fn relit(
    trial: &Trial,
    (room, method, given): (usize, Option<Relighting>, Given),
    settings: &Settings,
    gpu: Option<&Gpu>,
    watch: Watch,
) -> Result<Solved> {
    let resolutions = vec![[trial.texels; 2]; trial.scene.faces.len()];
    let empty = Scene {
        faces: trial.scene.faces[..room].to_vec(),
        ..trial.scene.clone()
    };
    let stage = Stage {
        captured: Captured {
            scene: empty,
            resolutions: resolutions[..room].to_vec(),
            values: None,
            panorama: None,
            notes: Vec::new(),
        },
        scene: trial.scene.clone(),
        room,
        resolutions,
        reflectance: None,
        notes: Vec::new(),
    };
    let work = Work {
        settings,
        device: gpu,
        watch: &|_, _| watch(),
        stopped: Cell::new(false),
    };
    let answered = relight(&stage, &work, method, given, &mut Phases::default())?;
    let paper = matches!(method, Some(Relighting::Paper(_)));
    let (done, estimate) = (answered.done, answered.estimate);
    Ok(Solved {
        warnings: warnings::of(&stage, &done, paper, estimate.as_ref()),
        estimate: estimate.map(|estimate| estimate.error),
        field: done.run.field,
        mesh: done.mesh,
        notes: answered.notes,
    })
}
