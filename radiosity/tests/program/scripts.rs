//! Features for scripts: `--json`, `--settings`, completions, the examples of `--help`.

use super::command::{empty_folder, exit_code_and_error, run_radiosity};
use serde_json::{Value, json};
use std::fs;
use std::path::Path;
use std::process::Command;

const FURNACE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenes/furnace.obj");

fn read_json(file: &Path) -> Value {
    serde_json::from_slice(&fs::read(file).unwrap()).unwrap()
}

/// Runs the program and parses the one line on stdout.
fn stdout_json(arguments: &[&str]) -> Value {
    let output = run_radiosity(arguments);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {errors}");
    let text = String::from_utf8(output.stdout).unwrap();
    assert_eq!(text.lines().count(), 1, "{arguments:?}: {text}");
    serde_json::from_str(&text).unwrap()
}

#[test]
fn settings_of_a_result_reproduce_it() {
    let folder = empty_folder("repeat");
    let [first, again] = ["first", "again"].map(|name| folder.join(name));
    let [first_dir, again_dir] = [&first, &again].map(|dir| dir.to_str().unwrap());
    let result = first.join("result.json");
    let file = result.to_str().unwrap();
    let crude = [
        "--solver",
        "cpu",
        "--texels",
        "4",
        "--patches",
        "2",
        "--samples",
        "1",
        "--conserve",
    ];
    let furnace = [FURNACE, "--quiet", "--json", "--out"];
    for (command, options, own, texels) in [
        ("shoot", &crude[..], &[][..], 4),
        ("shoot", &crude, &["--texels", "6"], 6),
        ("solve", &["--solver", "cpu", "--error", "2%", "--texels", "4"], &[], 4),
        ("solve", &["--solver", "dense", "--texels", "2"], &[], 2),
    ] {
        let run = [&[command], &furnace[..]].concat();
        let made = stdout_json(&[&run[..], &[first_dir], options].concat());
        let mut whole = read_json(&result);
        let entries = whole.as_object_mut().unwrap();
        assert!(entries.remove("faces").is_some() && made["faces"].is_null());
        for (name, value) in made.as_object().unwrap() {
            assert!(name == "seconds" || *value == whole[name], "{name}");
        }
        let repeat = [&run[..], &[again_dir, "--settings", file], own].concat();
        let repeated = stdout_json(&repeat);
        let mut wanted = made["settings"].clone();
        wanted["texels"] = texels.into();
        assert_eq!(repeated["settings"], wanted);
        assert_eq!(repeated["solver"], made["solver"]);
        if own.is_empty() {
            let [once, twice] = [&first, &again].map(|dir| read_json(&dir.join("result.json")));
            assert_eq!(once["lightmap_crc32"], twice["lightmap_crc32"]);
        }
    }
}

#[test]
fn file_without_settings_is_refused() {
    let folder = empty_folder("no-settings");
    let out = folder.join("out");
    let file = folder.join("given.json");
    let given = file.to_str().unwrap();
    let solve = ["solve", FURNACE, "--out", out.to_str().unwrap()];
    for text in [
        json!({}).to_string(),
        "not json".into(),
        json!({"solver": "cpu", "settings": {"out": "/tmp/elsewhere"}}).to_string(),
        json!({"solver": "cpu", "settings": {"texels": [4]}}).to_string(),
        json!({"solver": "cpu", "settings": {"texels": "many"}}).to_string(),
        json!({"settings": {"texels": 4}}).to_string(),
    ] {
        fs::write(&file, &text).unwrap();
        let (code, line) = exit_code_and_error(&[&solve[..], &["--settings", given]].concat());
        assert_eq!(code, 2, "{text}: {line}");
        assert!(line.contains("given.json"), "{text}: {line}");
    }
    let (code, line) = exit_code_and_error(&[&solve[..], &["--settings", "/nowhere.json"]].concat());
    assert!(code == 2 && line.contains("/nowhere.json"), "{line}");
    assert!(!out.exists());
}

#[test]
fn json_on_stdout_equals_file() {
    let folder = empty_folder("json");
    let [result, out] = ["result", "out"].map(|name| folder.join(name));
    let [dir, out_dir] = [&result, &out].map(|path| path.to_str().unwrap());
    let solve = ["solve", FURNACE, "--solver", "cpu", "--error", "2%"];
    run_radiosity(&[&solve[..], &["--texels", "4", "--out", dir]].concat());
    let diff = stdout_json(&["diff", dir, dir, "--json", "--out", out_dir]);
    assert_eq!(diff, read_json(&out.join("diff.json")));
    let check = stdout_json(&["check", dir, "--json", "--out", out_dir]);
    assert_eq!(check, read_json(&out.join("check.json")));
    let adapters = stdout_json(&["adapters", "--json"]);
    if adapters.as_array().is_some_and(|found| !found.is_empty()) {
        let crude = ["--texels", "2", "--patches", "1", "--samples", "1"];
        let compare = ["compare", FURNACE, "--json", "--out", out_dir];
        let compared = stdout_json(&[&compare[..], &crude].concat());
        assert_eq!(compared, read_json(&out.join("report.json")));
    }
    let names = adapters.as_array().unwrap().iter();
    assert!(names.clone().all(|line| line["software"].is_boolean()));
    let lines = String::from_utf8(run_radiosity(&["adapters"]).stdout).unwrap();
    assert_eq!(names.count(), lines.lines().count());
}

#[test]
fn completion_scripts_have_options() {
    for shell in ["bash", "zsh", "fish"] {
        let script = run_radiosity(&["completions", shell]);
        let text = String::from_utf8(script.stdout).unwrap();
        assert_eq!(script.status.code(), Some(0));
        for word in ["item-buffer", "relight", "stereographic"] {
            assert!(text.contains(word), "{shell}: {word}");
        }
    }
    assert_eq!(exit_code_and_error(&["completions", "cobol"]).0, 2);
}

/// The examples fail only because their files are missing: their options are valid.
#[test]
fn help_examples_are_valid_command_lines() {
    let empty = empty_folder("typed");
    for command in ["solve", "shoot", "relight", "compare", "diff", "check"] {
        let help = String::from_utf8(run_radiosity(&[command, "--help"]).stdout).unwrap();
        assert!(help.contains("Exit codes:"), "{command}");
        let (_, examples) = help.split_once("EXAMPLES:").unwrap();
        let lines = examples.lines().map(str::trim);
        let typed: Vec<&str> = lines.filter(|l| l.starts_with("radiosity ")).collect();
        assert!(typed.len() >= 2, "{command}");
        // A file of settings is read first, so that its example fails earlier.
        for line in typed.iter().filter(|line| !line.contains("--settings")) {
            let line = line.split("  ").next().unwrap();
            let words = line.split(" | ").next().unwrap().split(' ').skip(1);
            let output = Command::new(env!("CARGO_BIN_EXE_radiosity"))
                .args(words)
                .current_dir(&empty)
                .output()
                .unwrap();
            let said = String::from_utf8(output.stderr).unwrap();
            assert_eq!(output.status.code(), Some(2), "{line}: {said}");
            assert!(!said.contains("see radiosity --help"), "{line}: {said}");
        }
    }
}
