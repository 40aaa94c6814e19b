//! Which ways of solving a scene are judged: the one that was asked for; with nothing asked, what
//! `solve` does by default and the paper's way. All are compared with one truth.

use super::truth::Truth;
use super::{Progress, Request, compare};
use crate::judge::comparison::{Comparison, Judged, Way};
use crate::solve::{Answer, Given, Question, answer};
use common::Result;
use common::scene::Scene;
use common::settings::{Quality, Settings, Visibility};
use gpu::{Fault, Gpu};
use std::cell::RefCell;

/// What is judged; `visibility` is the GPU's.
pub enum Ways {
    /// The paper's way, and what `solve` does by default with these settings.
    Both {
        /// Whole faces, discs, single shots.
        paper: Settings,
        /// Before it mends itself.
        solve: Settings,
    },
    /// One way, as it is; at reference quality cells are halved first until the CPU settles, unless
    /// they were given.
    One(Settings, Given),
}

/// Judges `scene` in all its ways.
pub fn judge(
    scene: &Scene,
    ways: &Ways,
    gpu: &Gpu,
    faults: &[Fault],
    progress: Progress,
) -> Result<Judged> {
    let texels = match ways {
        Ways::Both { solve, .. } => solve.texels,
        Ways::One(settings, _) => settings.texels,
    };
    let truth = |progress: Progress| {
        Truth::new(scene, texels, &mut |done, all| progress("truth", done, all))
    };
    let request = |settings: &Settings| Request {
        settings: settings.clone(),
        gpu,
        faults,
    };
    match ways {
        Ways::One(settings, given) => {
            let (settings, notes) = settled(scene, settings, *given, progress)?;
            let mut c = compare(scene, &request(&settings), progress)?;
            c.notes = notes;
            let truth = truth(progress)?;
            Ok(Judged {
                first: against(c, truth.as_ref(), Way::Asked),
                as_solved: None,
            })
        }
        Ways::Both { paper, solve } => {
            let truth = truth(progress)?;
            let answers = solved(scene, solve, gpu, progress)?;
            let as_solved = compare(scene, &request(&finest(&answers[1])), progress)?;
            let first = compare(scene, &request(paper), progress)?;
            Ok(Judged {
                first: against(first, truth.as_ref(), Way::Paper),
                as_solved: Some(by_answers(as_solved, &answers, truth.as_ref())),
            })
        }
    }
}

/// The settings of the last solve of an answer.
fn finest(answer: &Answer) -> Settings {
    let settings = &answer.settings;
    Settings {
        // Texels are never larger than cells.
        texels: settings.texels * settings.cells.div_ceil(settings.texels),
        ..settings.clone()
    }
}

/// What `solve` answers, on the CPU and on the GPU.
fn solved(
    scene: &Scene,
    settings: &Settings,
    gpu: &Gpu,
    progress: Progress,
) -> Result<[Answer; 2]> {
    let shared = RefCell::new(progress);
    let ask = |gpu: Option<&Gpu>, settings: &Settings| {
        let question = Question {
            scene,
            settings,
            given: Given::default(),
            gpu,
        };
        let phase = if gpu.is_some() {
            "solve on the GPU"
        } else {
            "solve on the CPU"
        };
        answer(&question, &|done| {
            (*shared.borrow_mut())(phase, (done * 1000.0) as u64, 1000)
        })
    };
    let rays = Settings {
        visibility: Visibility::Rays,
        ..settings.clone()
    };
    Ok([ask(None, &rays)?, ask(Some(gpu), settings)?])
}

/// At reference quality the cells that the CPU's answer ended with.
fn settled(
    scene: &Scene,
    settings: &Settings,
    given: Given,
    progress: Progress,
) -> Result<(Settings, Vec<String>)> {
    if settings.quality != Quality::Reference || given.cells {
        return Ok((settings.clone(), Vec::new()));
    }
    let rays = Settings {
        visibility: Visibility::Rays,
        ..settings.clone()
    };
    let shared = RefCell::new(progress);
    let question = Question {
        scene,
        settings: &rays,
        given,
        gpu: None,
    };
    let answered = answer(&question, &|done| {
        (*shared.borrow_mut())("refining", (done * 1000.0) as u64, 1000)
    })?;
    let settled = Settings {
        visibility: settings.visibility,
        ..finest(&answered)
    };
    Ok((settled, answered.notes))
}

/// The runs of `c` held against the truth.
fn against(mut c: Comparison, truth: Option<&Truth>, way: Way) -> Comparison {
    c.way = way;
    c.truth = truth.map(|truth| truth.told.clone());
    c.error = [&c.cpu, &c.gpu].map(|run| truth.map(|truth| truth.error(&c.mesh, &run.field)));
    c
}

/// The answers of `solve` held against the truth; `c` judges the settings that the GPU's ended with.
fn by_answers(mut c: Comparison, answers: &[Answer; 2], truth: Option<&Truth>) -> Comparison {
    c.way = Way::Solve;
    c.truth = truth.map(|truth| truth.told.clone());
    c.error = [0, 1].map(|k| {
        let answer = &answers[k];
        truth.map(|truth| truth.error(&answer.mesh, &answer.run.field))
    });
    for (name, answer) in ["CPU", "GPU"].into_iter().zip(answers) {
        let notes = answer.notes.iter();
        c.notes.extend(notes.map(|note| format!("{name}: {note}")));
    }
    c
}
