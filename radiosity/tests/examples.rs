//! The examples of the library give the documented results.

use super::program::command::TestFolder;
use oracle::prelude::*;
use std::path::Path;

#[expect(dead_code, reason = "its main is for those who run it")]
#[path = "../../oracle/examples/own_solver_energy.rs"]
mod own_solver_energy;
#[expect(dead_code, reason = "its main is for those who run it")]
#[path = "../../oracle/examples/read_lightmap.rs"]
mod read_lightmap;
#[expect(dead_code, reason = "its main is for those who run it")]
#[path = "../../oracle/examples/solve_scene.rs"]
mod solve_scene;

const FURNACE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenes/furnace.obj");

/// In a furnace every face emits 1, reflects half and has B = 2: all emitted power is absorbed.
#[test]
fn solve_example_reports_energy_and_error() {
    let said = solve_scene::solve_to_error(Path::new(FURNACE)).unwrap();
    assert!(said.contains("absorbed 100.0"), "{said}");
    let off = said.rsplit("about ").next().unwrap();
    let off: f64 = off.split(' ').next().unwrap().parse().unwrap();
    assert!(off <= 1.0, "{said}");
}

/// Point-to-point form factors are too large near the furnace's edges, and the energy balance shows it.
#[test]
fn own_solver_example_is_judged() {
    let judged = own_solver_energy::check_own_solver(Path::new(FURNACE)).unwrap();
    let (error, account) = (judged.diff.worst_rms(), judged.energy);
    assert!(0.005 < error && error < 0.1, "{error}");
    assert!(0.0 < judged.one_bounce && judged.one_bounce < error);
    assert!(account.imbalance < 1e-5, "{account:?}");
    for radiosity in judged.truth.radiosity {
        assert!((radiosity.x - 2.0).abs() < 0.03, "{radiosity}");
    }
}

#[test]
fn lightmap_example_reads_texel() {
    let folder = TestFolder::new();
    let out = folder.path("");
    let scene = load_scene(Path::new(FURNACE), &ImportOptions::default()).unwrap();
    let asked = ErrorTarget {
        error: 0.02,
        texels: Some(4),
    };
    let question = SolveRequest {
        task: &scene,
        settings: &Settings::default(),
        solver: SolverChoice::Hierarchy(asked),
    };
    let answer = solve_request(&question, &without_progress()).unwrap();
    let solution = answer.to_solution(&question, &[], PhaseSeconds::default());
    // Each texel has another value, so that no texel can be mistaken for another.
    let mut solution = solution;
    let mut run = answer.solved.run.clone();
    for (k, texel) in answer.solved.mesh.texels.iter().enumerate() {
        let number = 100 * texel.face + texel.index;
        run.field.radiosity[k] = Vec3::splat(number as f32).extend(0.0);
    }
    solution.run = &run;
    solution.write(&out).unwrap();
    let said = read_lightmap::describe_texel(&out, [1, 3, 2]).unwrap();
    let start = "ceiling, texel 3, 2 of 4×4: B = [";
    let radiosity = said.strip_prefix(start).unwrap_or_else(|| panic!("{said}"));
    let red: f64 = radiosity.split(',').next().unwrap().parse().unwrap();
    assert_eq!(red, 111.0, "{said}");
    assert!(read_lightmap::describe_texel(&out, [1, 4, 0]).is_err());
    assert!(read_lightmap::describe_texel(&out, [6, 0, 0]).is_err());
}
