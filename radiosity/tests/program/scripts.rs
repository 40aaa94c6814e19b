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

/// Command line, parts of its plan, and texels (unless the solve chooses them) and error in its JSON.
type PlanRow = (&'static str, &'static [&'static str], Option<u64>, Option<f64>);

const PLAN_ROWS: &[PlanRow] = &[
    (
        "solve scenes/cornell_box.obj --solver cpu --texels 2 --error 10%",
        &[
            ", CPU, to 10 %\n",
            "17 faces, 68 texels\n",
            " available now)",
            "\n  time    about ",
        ],
        Some(68),
        Some(0.1),
    ),
    (
        "solve scenes/cornell_box.obj --solver cpu --quality draft",
        &["17 faces, about ", " texels\n", "\n  memory  about "],
        None,
        Some(0.05),
    ),
    (
        "shoot scenes/cornell_box.obj --solver gpu --texels 10 --patches 2 --samples 1",
        &[
            ", GPU, ",
            "17 faces, 1\u{202f}700 texels, 66 patches; 112\u{202f}200 links of 1 samples\n",
        ],
        Some(1700),
        None,
    ),
    (
        "solve scenes/cornell_box.obj --solver cpu --texels 8192",
        &["refused", "limit of ", "would fit"],
        Some(17 << 26),
        Some(0.01),
    ),
    (
        "solve scenes/furnace.obj --solver dense --texels 100",
        &[
            "57.6 GB (2.1 GB allowed for the matrix)",
            "refused",
            "--texels 43 would fit",
        ],
        Some(60_000),
        None,
    ),
    (
        SHOOT_LINE,
        &[
            ", CPU\n",
            "17 faces, 68 texels, 17 patches",
            "\n  memory  ",
            "\n  time    about ",
        ],
        Some(68),
        None,
    ),
];
const SHOOT_LINE: &str =
    "shoot scenes/cornell_box.obj --maps --gltf light.glb --solver cpu --texels 2 --patches 1 --samples 1";

#[test]
fn dry_run_prints_plan_and_writes_nothing() {
    let folder = TestFolder::new();
    for (line, words, texels, error) in PLAN_ROWS {
        let text = folder.succeed(&format!("{line} --dry-run"));
        for word in *words {
            assert!(text.stdout.contains(word), "{}: {word}", text.stdout);
        }
        let end = folder.succeed(&format!("{line} --dry-run --json"));
        let told = end.json();
        let [plan] = &told["plans"].as_array().unwrap()[..] else {
            panic!("{told}");
        };
        assert!(line.contains(plan["solver"].as_str().unwrap()), "{plan}");
        assert!(texels.is_none() || plan["texels"].as_u64() == *texels, "{plan}");
        assert_eq!(plan["error"].as_f64(), *error, "{plan}");
        assert!(plan["bytes"].is_u64());
        let links = plan["cells"]
            .as_u64()
            .map(|patches| patches * plan["texels"].as_u64().unwrap());
        assert_eq!(
            (links, links.is_some()),
            (plan["links"].as_u64(), line.starts_with("shoot"))
        );
        let seconds = ["least", "expected", "most"].map(|name| plan["seconds"][name].as_f64());
        let ordered = seconds[0] > Some(0.0) && seconds.is_sorted();
        assert!(ordered || words.contains(&"refused") && seconds == [None; 3], "{plan}");
        assert_eq!(plan["refused"].is_string(), words.contains(&"refused"), "{plan}");
    }
    assert!(folder.list_files().is_empty(), "--dry-run writes files");
    // The same call without --dry-run writes them.
    folder.succeed(SHOOT_LINE);
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
