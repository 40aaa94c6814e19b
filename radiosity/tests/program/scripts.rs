//! Features for scripts: `--json`, completions, `--help`.

use super::command::TestFolder;
use serde_json::Value;

#[test]
fn json_on_stdout_equals_file() {
    let folder = TestFolder::new();
    for line in [
        "shoot scenes/furnace.obj --solver cpu --texels 4 --patches 2",
        "solve scenes/furnace.obj --solver dense --texels 2",
        "solve scenes/furnace.obj --solver cpu --error 2% --texels 4",
    ] {
        let made = folder.succeed(&format!("{line} --quiet --json --out result")).json();
        let mut whole = folder.read_json("result/result.json");
        let entries = whole.as_object_mut().unwrap();
        assert!(entries.remove("faces").is_some() && made["faces"].is_null());
        for (name, value) in made.as_object().unwrap() {
            assert!(name == "seconds" || *value == whole[name], "{name}");
        }
    }
}

#[test]
fn completion_scripts_have_options() {
    for shell in ["bash", "zsh", "fish"] {
        let text = TestFolder::new().succeed(&format!("completions {shell}")).stdout;
        for word in ["item-buffer", "relight", "stereographic"] {
            assert!(text.contains(word), "{shell}: {word}");
        }
    }
}

/// The examples fail only because their files are missing: their options are valid.
#[test]
fn help_examples_are_valid_command_lines() {
    let folder = TestFolder::new();
    for command in ["solve", "shoot", "relight", "compare", "diff", "check"] {
        let help = folder.succeed(&format!("{command} --help")).stdout;
        assert!(help.contains("Exit codes:"), "{command}");
        let (_, examples) = help.split_once("EXAMPLES:").unwrap();
        let lines = examples
            .lines()
            .filter_map(|line| line.trim().strip_prefix("radiosity "));
        let typed: Vec<&str> = lines.collect();
        assert!(typed.len() >= 2, "{command}");
        for line in &typed {
            let line = line.split("  ").next().unwrap().split(" | ").next().unwrap();
            let end = folder.fail_with(2, &line.replace("scenes/", "missing/"), "");
            assert!(!end.stderr.contains("see radiosity --help"), "{end}");
        }
    }
}

#[test]
fn help_lists_options_of_shooting_under_shoot_only() {
    let [solve, shoot, all] =
        ["solve --help", "shoot --help", "--help"].map(|line| TestFolder::new().succeed(line).stdout);
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
fn dry_run_prints_plan_and_writes_nothing() {
    let folder = TestFolder::new();
    let outputs = "--maps --gltf light.glb --solver cpu --texels 2";
    let shoot = format!("shoot scenes/cornell_box.obj {outputs} --patches 1 --samples 1");
    for (line, words) in [
        (
            format!("solve scenes/cornell_box.obj {outputs} --error 10%"),
            &["to 10 %", "17 faces, 2×2 texels", "\n  time    about "][..],
        ),
        (
            shoot.clone(),
            &[
                "17 faces, 68 texels, 17 patches",
                "\n  memory  ",
                "\n  passes  ",
                "\n  time    about ",
            ],
        ),
    ] {
        let text = folder.succeed(&format!("{line} --dry-run"));
        for word in words {
            assert!(text.stdout.contains(word), "{text}: {word}");
        }
        let end = folder.succeed(&format!("{line} --dry-run --json"));
        assert!(
            !text.stderr.contains("note:") && !end.stderr.contains("note:"),
            "{text} {end}"
        );
        let plan = end.json();
        assert_eq!(plan["plans"].as_array().unwrap().len(), 1, "{plan}");
        let plan = &plan["plans"][0];
        assert_eq!(plan["solver"], "cpu");
        assert!(plan["seconds"]["expected"].as_f64() > Some(0.0), "{plan}");
        assert_eq!(plan["error"].is_null(), line == shoot, "{plan}");
        assert_eq!(plan["bytes"].is_u64(), line == shoot, "{plan}");
    }
    assert!(folder.list_files().is_empty(), "--dry-run writes files");
    // The same call without --dry-run writes them.
    folder.succeed(&shoot);
    for name in ["out/lightmap.exr", "out/maps", "light.glb"] {
        assert!(folder.has(name), "{name}");
    }
}

/// Without a driver the demo only solves on the CPU, which takes a second.
#[test]
fn demo_runs_outside_the_repository() {
    let folder = TestFolder::new();
    let mut demo = folder.command(&[]);
    demo.env("VK_DRIVER_FILES", "none").env("VK_ICD_FILENAMES", "none");
    assert_eq!(demo.output().unwrap().status.code(), Some(3));
    let result = folder.read_json("out/cornell_box/result.json");
    assert_eq!(result["scene"], "out/scenes/cornell_box.obj");
    assert_eq!(result["converged"], Value::Bool(true));
    for name in ["scenes/cornell_box.obj", "scenes/cornell_box.mtl"] {
        let ours = std::fs::read(concat!(env!("CARGO_MANIFEST_DIR"), "/../").to_owned() + name).unwrap();
        assert!(folder.read(&format!("out/{name}")) == ours, "{name}");
    }
}
