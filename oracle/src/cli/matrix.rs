//! `radiosity solve --solver matrix`.

use super::Outcome;
use super::progress::{Progress, listen};
use super::solve::{Arguments, FILES, judged, write_maps, wrote};
use super::tell::say;
use crate::solve::dense;
use crate::solve::warnings;
use common::Result;
use common::energy::Energy;
use common::form_factor::FormFactor;
use common::import::load;
use common::mesh::Mesh;
use common::scene::Scene;
use common::settings::{Settings, Visibility};
use common::shooting::Run;
use common::solution::{Code, Seconds, Solution, Warning, prepare};
use cpu::matrix::memory::check;
use cpu::matrix::{Answer, Matrix, Quality};
use serde_json::{Value, json};
use std::time::Instant;

/// Solves and writes.
pub fn run(arguments: &Arguments) -> Result<Outcome> {
    let common = &arguments.common;
    common.not_for_matrix()?;
    let start = Instant::now();
    let scene = load(&arguments.scene, &common.import())?;
    let load_seconds = start.elapsed().as_secs_f64();
    for note in &scene.notes {
        say!("note: {}: {note}", scene.name);
    }
    // Every texel shoots: cells are texels.
    let shooting = common.settings(Visibility::Rays, FormFactor::Polygon);
    let settings = Settings {
        cells: 1,
        ..shooting?
    };
    check(&scene, settings.texels)?;
    prepare(&arguments.out)?;
    listen();

    let start = Instant::now();
    let mesh = Mesh::uniform(&scene, settings.texels, settings.cells)?;
    let (matrix, quality) = assemble(&scene, &mesh, common.quiet)?;
    let prepare_seconds = start.elapsed().as_secs_f64();

    let start = Instant::now();
    let (run, answer) = dense::solve(&mesh, &matrix)?;
    let solve_seconds = start.elapsed().as_secs_f64();

    let solution = Solution {
        scene: &scene,
        mesh: &mesh,
        solver: "matrix",
        adapter: None,
        settings: &settings,
        run: &run,
        certificate: None,
        warnings: &warnings_of(&scene, &mesh, &run),
        notes: &scene.notes,
        matrix: Some(description(&quality, &answer)),
        relit: None,
        seconds: Seconds {
            load: load_seconds,
            prepare: prepare_seconds,
            solve: solve_seconds,
        },
    };
    solution.write(&arguments.out)?;
    if arguments.maps {
        write_maps(&scene, &mesh, &run.field, &arguments.out)?;
    }
    if !common.quiet {
        summary(&solution, &quality, &answer);
        wrote(&solution, FILES, &arguments.out);
    }
    Ok(judged(&solution, arguments.strict))
}

fn assemble(scene: &Scene, mesh: &Mesh, quiet: bool) -> Result<(Matrix, Quality)> {
    let mut progress = Progress::new(&scene.name, quiet);
    Matrix::assemble(scene, mesh, &mut |done, all| {
        progress.show("form factors", done, all)
    })
}

/// The advice for shots does not help here.
fn warnings_of(scene: &Scene, mesh: &Mesh, run: &Run) -> Vec<Warning> {
    let mut warnings = warnings::of(scene, mesh, run, None);
    for warning in warnings.iter_mut().filter(|w| w.code == Code::Closure) {
        warning.message = "form factors and visibility leave more than 2 % of the power unexplained: use more --texels, and look for faces that pass through each other".into();
    }
    warnings
}

fn description(quality: &Quality, answer: &Answer) -> Value {
    json!({
        "closure": { "max": quality.closure_max, "mean": quality.closure_mean },
        "reciprocity": quality.reciprocity,
        "visibility": quality.visibility,
        "residual": answer.residual,
        "exact_pairs": quality.exact_pairs,
        "hidden_pairs": quality.hidden_pairs,
        "sampled_pairs": quality.sampled_pairs,
        "bytes": quality.bytes,
    })
}

fn summary(solution: &Solution, quality: &Quality, answer: &Answer) {
    let energy = Energy::new(solution.mesh, &solution.run.field, &solution.run.shots);
    say!(
        "{}: {} faces, {} texels, matrix of {:.0} MB in {:.2} s, solved in {:.2} s to {:.1e}; {} pairs exact, {} sampled, reciprocity {:.1e}, rows' closure ≤ {:.1e} (mean {:.1e}); imbalance {:.1e}, escaped {:.2} %, closure {:.2} %",
        solution.scene.name,
        solution.mesh.faces.len(),
        solution.mesh.texels.len(),
        quality.bytes as f64 / 1e6,
        solution.seconds.prepare,
        solution.seconds.solve,
        answer.residual,
        quality.exact_pairs,
        quality.sampled_pairs,
        quality.reciprocity,
        quality.closure_max,
        quality.closure_mean,
        energy.imbalance,
        100.0 * energy.share(energy.escaped),
        100.0 * energy.share(energy.closure),
    );
}
