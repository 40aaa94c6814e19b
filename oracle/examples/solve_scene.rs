//! Solves a scene to 1 %, and says where its light went and how far off the answer may be.
//!
//! `cargo run --release --example solve_scene [SCENE]`

use oracle::prelude::*;
use std::path::Path;

fn main() -> Result<()> {
    let scene = std::env::args().nth(1);
    let scene = scene.unwrap_or_else(|| "scenes/cornell_box.obj".into());
    println!("{}", solved(Path::new(&scene))?);
    Ok(())
}

/// The energy balance and the error of a solve.
pub fn solved(path: &Path) -> Result<String> {
    let scene = load(path, &ImportOptions::default())?;
    let asked = Asked {
        error: 0.01,
        texels: Some(8),
    };
    let question = Question {
        task: &scene,
        settings: &Settings::default(),
        solver: Solver::Hierarchy(asked),
    };
    let answer = answer(&question, &unwatched())?;
    let Solved { mesh, run, .. } = &answer.solved;
    let energy = Energy::new(mesh, &run.field, &run.shots);
    let error = answer.estimate.as_ref().map_or(f64::NAN, |e| e.error);
    Ok(format!(
        "{}: absorbed {:.2} %, escaped {:.2} %, imbalance {:.1e}, about {:.2} % off",
        scene.name,
        100.0 * energy.share(energy.absorbed),
        100.0 * energy.share(energy.escaped),
        energy.imbalance,
        100.0 * error
    ))
}
