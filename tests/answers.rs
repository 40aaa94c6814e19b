//! What `solve` answers, on few texels.

use common::scene::Scene;
use common::settings::{Iteration, Settings};
use oracle::solve::{Answer, Given, Question, answer};
use std::ops::ControlFlow;

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
        scene,
        settings,
        given,
        gpu: None,
    };
    answer(&question, &|_| ControlFlow::Continue(())).unwrap()
}
