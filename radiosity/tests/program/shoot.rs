//! `shoot`, and the earlier spellings, which work for one version.

use super::command::TestFolder;
use serde_json::{Value, json};

/// Returns the lines that begin with `note:` and contain `words`.
fn count_notes(messages: &str, words: &str) -> usize {
    let notes = messages.lines().filter(|line| line.starts_with("note: "));
    notes.filter(|line| line.contains(words)).count()
}

#[test]
fn solve_with_option_of_shooting_shoots_and_names_shoot() {
    let folder = TestFolder::new();
    let run = |command: &str, rest: &str| {
        let line = format!("{command} scenes/cornell_box.obj --solver cpu --texels 3 {rest}");
        folder.succeed(&line).stderr
    };
    let words = "is an option of `radiosity shoot` now";
    let shot = run("shoot", "--samples 1 --patches 2 --out new");
    assert_eq!(count_notes(&shot, words), 0, "{shot}");
    let solved = run("solve", "--samples 1 --cells 2 --out old");
    assert!(solved.contains("note: --samples "), "{solved}");
    assert_eq!(count_notes(&solved, words), 1, "{solved}");
    assert_eq!(folder.read("new/lightmap.exr"), folder.read("old/lightmap.exr"));
    let settings = folder.read_json("old/result.json")["settings"].clone();
    assert_eq!(settings, folder.read_json("new/result.json")["settings"]);
    assert_eq!((&settings["cells"], &settings["samples"]), (&json!(2), &json!(1)));
    assert!(settings["error"].is_null(), "{settings}");
    // A solve to an error says nothing of shooting, and has another lightmap.
    let solved = run("solve", "--error 10% --out old");
    assert_eq!(count_notes(&solved, words), 0, "{solved}");
    assert_ne!(folder.read("new/lightmap.exr"), folder.read("old/lightmap.exr"));
}

#[test]
fn shoot_without_options_shoots_with_defaults() {
    let folder = TestFolder::new();
    folder.succeed("shoot scenes/cornell_box.obj --solver cpu --texels 2");
    let settings = &folder.read_json("out/result.json")["settings"];
    for (name, value) in [
        ("texels", json!(2)),
        ("cells", json!(4)),
        ("samples", json!(4)),
        ("iteration", json!("cg")),
        ("visibility", json!("rays")),
        ("error", Value::Null),
    ] {
        assert_eq!(settings[name], value, "{name}");
    }
}

#[test]
fn shoot_writes_files_of_contract() {
    let folder = TestFolder::new();
    folder.succeed("shoot scenes/cornell_box.obj --solver cpu --texels 4 --max-shots 7");
    let result = folder.read_json("out/result.json");
    assert_eq!(result["shots"], 7);
    assert_eq!(result["converged"], false);
    assert_eq!(result["solver"], "cpu");
    assert!(result["adapter"].is_null());
    assert_eq!(result["settings"]["texels"], 4);
    assert!(result["energy"]["imbalance"].as_f64().unwrap() < 1e-5);
    let faces = result["faces"].as_array().unwrap();
    let face = &faces[0];
    assert_eq!(face["kind"], "quad");
    assert_eq!(face["texels"], json!([4, 4]));
    assert_eq!(face["corners"].as_array().unwrap().len(), 4);
    for key in ["name", "area", "rect", "emission", "reflectance"] {
        assert!(!face[key].is_null(), "{key}");
    }
    assert!(
        faces.iter().any(|face| face["from"] == 5),
        "the non-planar left wall is split"
    );
    let files = ["lightmap.exr", "preview.png", "result.json", "view.html"];
    let files = files.map(|name| folder.path("out").join(name));
    assert_eq!(
        folder.list_files(),
        [&files[..], &[folder.path("out")]].concat().into_iter().collect()
    );
    assert!(!folder.read_planes("out/lightmap.exr").channels.is_empty());
}

#[test]
fn solver_matrix_is_solver_dense() {
    let folder = TestFolder::new();
    for solver in ["dense", "matrix"] {
        let solve = format!("solve scenes/cornell_box.obj --solver {solver} --texels 2 --out {solver}");
        folder.succeed(&solve);
        let result = folder.read_json(&format!("{solver}/result.json"));
        assert_eq!(result["solver"], "dense");
        assert!(result["matrix"]["residual"].is_f64());
    }
    assert_eq!(folder.read("dense/lightmap.exr"), folder.read("matrix/lightmap.exr"));
}

#[test]
fn plan_plans_cpu_and_names_dry_run() {
    let folder = TestFolder::new();
    let end = folder.succeed("plan scenes/cornell_box.obj --json --texels 2 --patches 1 --samples 1");
    assert_eq!(count_notes(&end.stderr, ""), 1, "{end}");
    assert_eq!(count_notes(&end.stderr, "`radiosity solve --dry-run`"), 1, "{end}");
    let plan = end.json();
    assert_eq!(plan["plans"][0]["solver"], "cpu");
    assert_eq!(plan["plans"].as_array().unwrap().len(), 1);
}
