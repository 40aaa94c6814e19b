//! What `solve` answers, on few texels.

use common::scene::Scene;
use common::settings::{Iteration, Settings};
use oracle::solve::solver::Solver;
use oracle::solve::watch::unwatched;
use oracle::solve::{Answer, Given, Question, answer};

/// 8×8 texels, 4 samples.
pub fn settings() -> Settings {
    Settings {
        texels: 8,
        samples: 4,
        iteration: Iteration::Cg,
        ..Settings::default()
    }
}

/// The CPU's answer.
pub fn solved(scene: &Scene, settings: &Settings, given: Given) -> Answer {
    let question = Question {
        task: scene,
        settings,
        given,
        solver: Solver::Cpu,
    };
    answer(&question, &unwatched()).unwrap()
}
