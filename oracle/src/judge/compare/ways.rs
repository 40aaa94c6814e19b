//! Which ways of solving a scene are judged: the one that was asked for; with nothing asked, what
//! `solve` does by default and the paper's way. All are compared with one truth.

use super::truth::Truth;
use super::{Request, compare};
use crate::judge::comparison::{Comparison, Judged, Way};
use crate::solve::solver::Solver;
use crate::solve::watch::Watch;
use crate::solve::{Answer, Given, Question, answer};
use common::Result;
use common::scene::Scene;
use common::settings::{Quality, Settings, Visibility};
use gpu::{Fault, Gpu};

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
    watch: &Watch,
) -> Result<Judged> {
    let texels = match ways {
        Ways::Both { solve, .. } => solve.meshing.texels,
        Ways::One(settings, _) => settings.meshing.texels,
    };
    let truth = || Truth::new(scene, texels, watch);
    let request = |settings: &Settings| Request {
        settings: *settings,
        gpu,
        faults,
    };
    match ways {
        Ways::One(settings, given) => {
            let (settings, notes) = settled(scene, settings, *given, watch)?;
            let mut c = compare(scene, &request(&settings), watch)?;
            c.notes = notes;
            let truth = truth()?;
            Ok(Judged {
                first: against(c, truth.as_ref(), Way::Asked),
                as_solved: None,
            })
        }
        Ways::Both { paper, solve } => {
            let truth = truth()?;
            let answers = solved(scene, solve, gpu, watch)?;
            let as_solved = compare(scene, &request(&finest(&answers[1])), watch)?;
            let first = compare(scene, &request(paper), watch)?;
            Ok(Judged {
                first: against(first, truth.as_ref(), Way::Paper),
                as_solved: Some(by_answers(as_solved, &answers, truth.as_ref())),
            })
        }
    }
}

/// The settings of the last solve of an answer.
fn finest(answer: &Answer) -> Settings {
    let mut settings = answer.solved.settings;
    // Texels are never larger than cells.
    let meshing = &mut settings.meshing;
    meshing.texels *= meshing.cells.div_ceil(meshing.texels);
    settings
}

/// What `solve` answers, on the CPU and on the GPU.
fn solved(scene: &Scene, settings: &Settings, gpu: &Gpu, watch: &Watch) -> Result<[Answer; 2]> {
    let ask = |solver: Solver, settings: &Settings, phase: &str| {
        let question = Question {
            task: scene,
            settings,
            given: Given::default(),
            solver,
        };
        answer(&question, &Watch::new(&|_, done| watch.tell(phase, done)))
    };
    let rays = settings.by(Visibility::Rays);
    Ok([
        ask(Solver::Cpu, &rays, "solve on the CPU")?,
        ask(Solver::Gpu(gpu), settings, "solve on the GPU")?,
    ])
}

/// At reference quality the cells that the CPU's answer ended with.
fn settled(
    scene: &Scene,
    settings: &Settings,
    given: Given,
    watch: &Watch,
) -> Result<(Settings, Vec<String>)> {
    if settings.quality != Quality::Reference || given.cells {
        return Ok((*settings, Vec::new()));
    }
    let rays = settings.by(Visibility::Rays);
    let question = Question {
        task: scene,
        settings: &rays,
        given,
        solver: Solver::Cpu,
    };
    let refining = |_: &str, done| watch.tell("refining", done);
    let answered = answer(&question, &Watch::new(&refining))?;
    let settled = finest(&answered).by(settings.transport.visibility);
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
        let solved = &answers[k].solved;
        truth.map(|truth| truth.error(&solved.mesh, &solved.run.field))
    });
    for (name, answer) in ["CPU", "GPU"].into_iter().zip(answers) {
        let notes = answer.notes.iter();
        c.notes.extend(notes.map(|note| format!("{name}: {note}")));
    }
    c
}
