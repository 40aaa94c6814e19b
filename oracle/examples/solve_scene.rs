//! Solves a scene to an error of 1 %, and prints its energy balance and estimated error.
//!
//! `cargo run --release --example solve_scene [SCENE]`

use oracle::prelude::*;
use std::path::Path;

fn main() -> Result<()> {
    let scene = std::env::args().nth(1);
    let scene = scene.unwrap_or_else(|| "scenes/cornell_box.obj".into());
    println!("{}", solve_to_error(Path::new(&scene))?);
    Ok(())
}

/// Solves the scene at `path` and describes its energy balance and its error.
pub fn solve_to_error(path: &Path) -> Result<String> {
    let scene = load_scene(path, &ImportOptions::default())?;
    let target = ErrorTarget {
        error: 0.01,
        texels: Some(8),
    };
    let request = SolveRequest {
        task: &scene,
        settings: &Settings::default(),
        solver: SolverChoice::Hierarchy(target),
    };
    let answer = solve_request(&request, &without_progress())?;
    let Solved { mesh, run, .. } = &answer.solved;
    let energy = EnergyBalance::new(mesh, &run.field, &run.shots);
    let error = answer.estimate.as_ref().map_or(f64::NAN, |e| e.error);
    Ok(format!(
        "{}: absorbed {:.2} %, escaped {:.2} %, imbalance {:.1e}, about {:.2} % off",
        scene.name,
        100.0 * energy.share_of_emitted(energy.absorbed),
        100.0 * energy.share_of_emitted(energy.escaped),
        energy.imbalance,
        100.0 * error
    ))
}
