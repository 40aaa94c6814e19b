//! `solve` and `compare` run as a program: the dense solver, white materials, warnings, verdicts.

use super::command::{ProgramEnd, TestFolder};
use approx::abs_diff_eq;
use serde_json::{Value, json};

#[test]
fn dense_solver_writes_files_of_contract() {
    let folder = TestFolder::new();
    let chosen = "--solver dense --texels 4";
    let end = folder.succeed(&format!("solve scenes/cornell_box.obj {chosen}"));
    assert!(end.stderr.contains("dense system of"), "{end}");
    let result = folder.read_json("out/result.json");
    assert_eq!(result["solver"], "dense");
    assert_eq!(result["shots"], 0);
    assert_eq!(result["converged"], true);
    assert_eq!(result["unshot_fraction"], 0.0);
    let settings = json!({"texels": 4, "visibility": "rays", "form-factor": "polygon"});
    assert_eq!(result["settings"], settings);
    let matrix = &result["matrix"];
    assert!(matrix["residual"].as_f64().unwrap() < 1e-12);
    assert!(matrix["reciprocity"].as_f64().unwrap() < 1e-7);
    // The matrix and its LU factors in f64, 4 × 4 texels a face.
    let texels = result["faces"].as_array().unwrap().len() * 16;
    assert_eq!(matrix["bytes"], texels * texels * 16);
    for key in ["exact_pairs", "sampled_pairs"] {
        assert!(matrix[key].as_u64().unwrap() > 0, "{key}");
    }
    assert!(matrix["closure"]["mean"].as_f64().unwrap() < 0.01);
    assert!(matrix["closure"]["max"].as_f64().unwrap() < 0.1);
    let energy = &result["energy"];
    assert!(energy["imbalance"].as_f64().unwrap() < 1e-6);
    for c in 0..3 {
        let part = |name: &str| energy[name][c].as_f64().unwrap();
        assert_eq!(part("unshot"), 0.0);
        // The box is open in front; nearly all of the missing share escapes there.
        let missing = part("emitted") - part("absorbed");
        assert!(part("escaped") > 0.0);
        assert!(abs_diff_eq!(part("escaped") / missing, 1.0, epsilon = 0.02), "{energy}");
    }
    assert!(!folder.read_planes("out/lightmap.exr").channels.is_empty());
}

#[test]
fn crude_shoot_is_warned_and_default_solve_is_not() {
    let folder = TestFolder::new();
    for (line, warned) in [("shoot --patches 1", true), ("solve", false)] {
        let end = folder.succeed(&format!("{line} scenes/cornell_box.obj --solver cpu --texels 8"));
        let mut lines = end.stderr.lines();
        let found = lines.any(|line| line.starts_with("warning: ") && line.contains("--patches"));
        assert_eq!(found, warned, "{end}");
        let result = folder.read_json("out/result.json");
        assert_eq!(result["warnings"].as_array().unwrap().is_empty(), !warned);
        assert!(result["estimated_error"].is_f64());
    }
}

/// Runs `compare` on two plates with these options; returns the comparison of report.json and the end.
fn run_compare(options: &str) -> (Value, ProgramEnd) {
    let folder = TestFolder::new();
    let line = format!("compare scenes/facing_plates.obj {options}");
    let end = folder.succeed(&line);
    let scene = folder.read_json("out/report.json")["scenes"][0].clone();
    assert_eq!(scene["agree"], true, "{end}");
    (scene, end)
}

#[test]
fn compare_judges_default_and_paper_preset_with_their_errors() {
    let (scene, end) = run_compare("--texels 8 --item-buffer 128");
    assert_eq!(scene["as_solved"]["agree"], true);
    assert_eq!(scene["settings"]["gpu"]["iteration"], "southwell");
    assert_eq!(scene["settings"]["gpu"]["cells"], 1);
    let solved = &scene["as_solved"];
    assert_eq!(solved["settings"]["gpu"]["error"], 0.01);
    for side in ["cpu", "gpu"] {
        let estimate = solved["estimated_error"][side].as_f64().unwrap();
        assert!(estimate > 0.0 && estimate < 0.01, "{estimate}");
    }
    // All blocks are linked by both solvers, and by rays both agree.
    assert!(solved["visibility"]["facing"].as_u64() > Some(10), "{solved}");
    assert_eq!(solved["visibility"]["unexplained"], 0);
    for (preset, stages) in [
        (&scene, &["lookup", "link", "select", "deposit", "power"][..]),
        (solved, &["link_bounds", "refine", "sample_links", "add_links"]),
    ] {
        for side in ["cpu", "gpu"] {
            assert!(preset["error"][side].is_f64(), "{}", preset["error"]);
        }
        for stage in stages {
            let told = &preset["stages"][*stage];
            let numbers = told["worst"].is_number() && told["bound"].is_number();
            assert!(numbers && told["agree"] == true, "{stage}: {told}");
        }
    }
    // Whole faces are inaccurate on plates as near as these, and the error must be printed.
    let error = scene["error"]["gpu"].as_f64().unwrap();
    assert!(error > 0.01, "{error}");
    let said = &end.stderr;
    assert!(said.contains(&format!("{:.1} % on the GPU", 100.0 * error)), "{said}");
    assert!(said.find("the defaults of solve").unwrap() < said.find("the paper's settings").unwrap());
}

#[test]
fn compare_accepts_options_of_solve_and_shoot() {
    for options in [
        "--item-buffer 64 --conserve",
        "--item-buffer 64 --samples 2 --patches 2",
        "--item-buffer 64 --iteration chebyshev --patches 2",
        "--item-buffer 64 --visibility hemicube --samples 1",
        "--item-buffer 64 --visibility paper --patches 1 --samples 1",
        "--visibility rays --patches 2",
        "--quality draft",
        "--error 2%",
    ] {
        let (scene, end) = run_compare(&format!("--texels 4 {options}"));
        assert!(scene["as_solved"].is_null() && scene["way"] == "asked", "{end}");
    }
}
