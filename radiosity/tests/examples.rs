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
    folder.succeed("solve scenes/cornell_box.obj --solver cpu --error 10% --texels 4");
    let out = folder.path("out");
    let said = read_lightmap::describe_texel(&out, [0, 3, 2]).unwrap();
    let start = "floor, texel 3, 2 of 4×4: B = [";
    let radiosity = said.strip_prefix(start).unwrap_or_else(|| panic!("{said}"));
    let red: f32 = radiosity.split(',').next().unwrap().parse().unwrap();
    let stored = StoredSolution::read(&out).unwrap();
    let own = stored.radiosity[stored.texel_range(0)][2 * 4 + 3].x;
    // Four digits behind the point are printed.
    let is_own = |b: &&Vec3| (b.x - red).abs() < 1e-4;
    // No texel can be mistaken for another.
    assert_eq!(stored.radiosity.iter().filter(is_own).count(), 1, "{said}: {own}");
    assert!((own - red).abs() < 1e-4, "{said}: {own}");
    assert!(read_lightmap::describe_texel(&out, [1, 4, 0]).is_err());
    assert!(read_lightmap::describe_texel(&out, [17, 0, 0]).is_err());
}
