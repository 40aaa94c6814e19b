//! `shoot`, `--dry-run`, and the earlier spellings, which work for one version.

use super::command::{empty_folder, run_radiosity};
use serde_json::{Value, json};
use std::fs;
use std::path::Path;

const BOX: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenes/cornell_box.obj");
/// Note of `solve` with an option of shooting.
const SHOOT_NOTE: &str = "is an option of `radiosity shoot` now";

/// Runs `command` on the box into `out`; returns its stderr.
fn run_into(command: &str, out: &Path, options: &[&str]) -> String {
    let run = [command, BOX, "--out", out.to_str().unwrap()];
    let output = run_radiosity(&[&run[..], options].concat());
    let text = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(0), "{command} {options:?}: {text}");
    text
}

fn read_lightmap(out: &Path) -> Vec<u8> {
    fs::read(out.join("lightmap.exr")).unwrap()
}

fn read_result(out: &Path) -> Value {
    serde_json::from_slice(&fs::read(out.join("result.json")).unwrap()).unwrap()
}

/// Returns the help of a command, or of the program.
fn help_text(command: &[&str]) -> String {
    String::from_utf8(run_radiosity(&[command, &["--help"]].concat()).stdout).unwrap()
}

#[test]
fn solve_with_option_of_shooting_shoots_and_names_shoot() {
    let folder = empty_folder("shoot");
    let [new, old] = ["new", "old"].map(|name| folder.join(name));
    let quality = ["--solver", "cpu", "--texels", "3", "--samples", "1"];
    let shot = run_into("shoot", &new, &[&quality[..], &["--patches", "2"]].concat());
    assert!(!shot.contains("radiosity shoot"), "{shot}");
    let solved = run_into("solve", &old, &[&quality[..], &["--cells", "2"]].concat());
    let notes: Vec<&str> = solved.lines().filter(|l| l.contains(SHOOT_NOTE)).collect();
    assert!(
        matches!(notes[..], [line] if line.starts_with("note: --patches ")),
        "{solved}"
    );
    assert_eq!(read_lightmap(&new), read_lightmap(&old));
    let settings = read_result(&old)["settings"].clone();
    assert_eq!(settings, read_result(&new)["settings"]);
    assert_eq!((&settings["cells"], &settings["samples"]), (&json!(2), &json!(1)));
    assert!(settings["error"].is_null(), "{settings}");
    // A solve to an error says nothing of shooting, and has another lightmap.
    let exact = ["--solver", "cpu", "--texels", "3", "--error", "10%"];
    let solved = run_into("solve", &old, &exact);
    assert!(!solved.contains("radiosity shoot"), "{solved}");
    assert_ne!(read_lightmap(&new), read_lightmap(&old));
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn shoot_without_options_shoots_with_defaults() {
    let folder = empty_folder("shoot-default");
    run_into("shoot", &folder, &["--solver", "cpu", "--texels", "2"]);
    let settings = &read_result(&folder)["settings"];
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
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn solver_matrix_is_solver_dense() {
    let folder = empty_folder("shoot-dense");
    let [dense, matrix, shot] = ["dense", "matrix", "shot"].map(|name| folder.join(name));
    run_into("solve", &dense, &["--solver", "dense", "--texels", "2"]);
    run_into("solve", &matrix, &["--solver", "matrix", "--texels", "2"]);
    assert_eq!(read_lightmap(&dense), read_lightmap(&matrix));
    for out in [&dense, &matrix] {
        let result = read_result(out);
        assert_eq!(result["solver"], "dense");
        assert!(result["matrix"]["residual"].is_f64());
    }
    let crude = ["--solver", "cpu", "--texels", "2", "--patches", "1"];
    run_into("shoot", &shot, &crude);
    assert_ne!(read_lightmap(&dense), read_lightmap(&shot));
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn plan_plans_cpu_and_names_dry_run() {
    let shot = ["--texels", "2", "--patches", "1", "--samples", "1"];
    let output = run_radiosity(&[&["plan", BOX, "--json"], &shot[..]].concat());
    let text = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(0), "{text}");
    let notes: Vec<&str> = text.lines().filter(|l| l.starts_with("note: ")).collect();
    assert!(
        matches!(notes[..], [line] if line.contains("`radiosity solve --dry-run`")),
        "{text}"
    );
    let plan: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(plan["plans"][0]["solver"], "cpu");
    // Without --solver the plan is of the GPU, too, where there is an adapter.
    let adapters = run_radiosity(&["adapters"]).stdout;
    let count = 1 + usize::from(!adapters.is_empty());
    assert_eq!(plan["plans"].as_array().unwrap().len(), count);
}

#[test]
fn dry_run_prints_plan_and_writes_nothing() {
    let folder = empty_folder("dry-run");
    let [out, glb] = ["out", "light.glb"].map(|name| folder.join(name));
    let [dir, glb] = [&out, &glb].map(|path| path.to_str().unwrap());
    let outputs = ["--out", dir, "--maps", "--gltf", glb];
    let fixed = ["--dry-run", "--solver", "cpu", "--texels", "2"];
    let solve = &["--error", "10%"][..];
    let shoot = &["--patches", "1", "--samples", "1"][..];
    for (command, options, words) in [
        (
            "solve",
            solve,
            &["to 10 %", "17 faces, 2×2 texels", "\n  time    about "][..],
        ),
        (
            "shoot",
            shoot,
            &[
                "17 faces, 68 texels, 17 patches",
                "\n  memory  ",
                "\n  passes  ",
                "\n  time    about ",
            ],
        ),
    ] {
        let run = [&[command, BOX], &fixed[..], &outputs[..], options].concat();
        let run_dry = |more: &[&str]| {
            let output = run_radiosity(&[&run[..], more].concat());
            let errors = String::from_utf8(output.stderr).unwrap();
            assert_eq!(output.status.code(), Some(0), "{command}: {errors}");
            let written = fs::read_dir(&folder).unwrap().count();
            assert_eq!(written, 0, "{command} --dry-run writes files");
            assert!(!errors.contains("note:"), "{command}: {errors}");
            String::from_utf8(output.stdout).unwrap()
        };
        let text = run_dry(&[]);
        for word in words {
            assert!(text.contains(word), "{command}: {word}: {text}");
        }
        let line = run_dry(&["--json"]);
        assert_eq!(line.lines().count(), 1, "{command}: {line}");
        let plan: Value = serde_json::from_str(&line).unwrap();
        assert_eq!(plan["plans"].as_array().unwrap().len(), 1, "{plan}");
        let plan = &plan["plans"][0];
        assert_eq!(plan["solver"], "cpu");
        assert!(plan["seconds"]["expected"].as_f64() > Some(0.0), "{plan}");
        assert_eq!(plan["error"].is_null(), command == "shoot", "{plan}");
        assert_eq!(plan["bytes"].is_u64(), command == "shoot", "{plan}");
    }
    // The same call without --dry-run writes them.
    let written = ["--solver", "cpu", "--texels", "2", "--maps", "--gltf", glb];
    run_into("shoot", &out, &[&written[..], shoot].concat());
    assert!(out.join("lightmap.exr").exists() && out.join("maps").exists());
    assert!(Path::new(glb).exists());
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn shoot_refuses_options_of_solve() {
    let folder = empty_folder("shoot-usage");
    let out = folder.join("out");
    let shoot = ["shoot", BOX, "--out", out.to_str().unwrap()];
    for (option, says) in [
        (["--error", "1%"], "--error"),
        (["--solver", "dense"], "dense"),
        (["--solver", "matrix"], "matrix"),
    ] {
        let output = run_radiosity(&[&shoot[..], &option].concat());
        let text = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{option:?}: {text}");
        let lines: Vec<&str> = text.lines().collect();
        assert!(
            matches!(lines[..], [line] if line.starts_with("error: ") && line.contains(says)),
            "{option:?}: {text}"
        );
        assert!(!out.exists(), "{option:?} wrote something");
    }
}

#[test]
fn help_lists_options_of_shooting_under_shoot_only() {
    let [solve, shoot, all] = [&["solve"][..], &["shoot"], &[]].map(help_text);
    for option in [
        "--patches",
        "--samples",
        "--visibility",
        "--item-buffer",
        "--form-factor",
        "--iteration",
        "--epsilon",
        "--max-shots",
    ] {
        assert!(!solve.contains(option), "{option}: {solve}");
        assert!(shoot.contains(option), "{option}: {shoot}");
    }
    assert!(solve.contains("--error <P%>") && solve.contains("dense"));
    assert!(!shoot.contains("--error") && !shoot.contains("dense"));
    for help in [&solve, &shoot] {
        assert!(help.contains("--dry-run") && !help.contains("--cells"));
    }
    assert!(all.contains("\n  shoot ") && !all.contains("\n  plan "), "{all}");
}

#[test]
fn settings_of_a_shoot_reproduce_it() {
    let folder = empty_folder("shoot-settings");
    let [first, again, default] = ["first", "again", "default"].map(|name| folder.join(name));
    let texels = ["--solver", "cpu", "--texels", "3"];
    let options = [
        "--patches",
        "1",
        "--samples",
        "2",
        "--form-factor",
        "disc",
        "--visibility",
        "hemicube",
        "--item-buffer",
        "64",
        "--iteration",
        "southwell",
        "--epsilon",
        "0.1",
    ];
    run_into("shoot", &first, &[&texels[..], &options].concat());
    let file = first.join("result.json");
    let told = run_into("shoot", &again, &["--settings", file.to_str().unwrap()]);
    assert!(!told.contains(SHOOT_NOTE), "{told}");
    assert_eq!(read_lightmap(&first), read_lightmap(&again));
    let [once, twice] = [&first, &again].map(|out| read_result(out));
    assert_eq!(once["settings"], twice["settings"]);
    assert_eq!(once["shots"], twice["shots"]);
    run_into("shoot", &default, &texels);
    assert_ne!(read_lightmap(&first), read_lightmap(&default));
    // A result of a solve to an error has no settings of shooting.
    let stored = folder.join("stored.json");
    let solved = json!({"solver": "cpu", "settings": {"texels": 2, "error": 0.02}});
    fs::write(&stored, solved.to_string()).unwrap();
    let path = stored.to_str().unwrap();
    let dry = ["shoot", BOX, "--dry-run", "--settings", path];
    let output = run_radiosity(&dry);
    let text = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{text}");
    assert!(text.starts_with("error: ") && text.contains("stored.json"), "{text}");
    fs::remove_dir_all(folder).unwrap();
}
