//! Memory: solves that do not fit are refused before they start, and plans match the measured memory.

#![allow(clippy::disallowed_methods, reason = "reads what the program and the system wrote")]

use super::cube::{folder_with_materials, room_with_triangles};
use super::kit::{assert_clean_end, describe_end, error_lines, run_in_shell, write_file};
use radiosity::plan::SceneCounts;
use radiosity::plan::memory::SolveMemory;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::Duration;

#[test]
fn solve_beyond_available_memory_is_refused() {
    let folder = folder_with_materials("memory");
    let solve = "solve room.obj --solver cpu --texels 1024 --quality draft";
    let words: Vec<&str> = solve.split(' ').collect();
    let ended = run_in_shell(&folder, "ulimit -v 800000; exec \"$0\" \"$@\"", &words);
    let what = describe_end(solve, &ended);
    println!("{what}");
    assert_eq!(ended.code, Some(2), "{what}");
    assert_clean_end(&folder, &ended, &what);
    let line = error_lines(&ended)[0];
    assert!(
        line.contains("allowed by ulimit") && line.contains("would fit"),
        "{line}"
    );
    // The advised settings do fit.
    let found = line.split("--texels ").nth(1).and_then(|rest| rest.split(' ').next());
    let texels = found.unwrap_or_else(|| panic!("{line}"));
    let fitting = [
        "solve",
        "room.obj",
        "--solver",
        "cpu",
        "--quality",
        "draft",
        "--texels",
        texels,
    ];
    let ended = run_in_shell(&folder, "ulimit -v 800000; exec \"$0\" \"$@\"", &fitting);
    let what = describe_end(texels, &ended);
    println!("{what}");
    assert_eq!(ended.code, Some(0), "{what}");
    fs::remove_dir_all(folder).unwrap();
}

/// Runs the program to its end; returns its peak resident memory in bytes.
fn peak_memory(folder: &Path, arguments: &str) -> u64 {
    let mut child = Command::new(env!("CARGO_BIN_EXE_radiosity"))
        .args(arguments.split(' '))
        .current_dir(folder)
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let status = format!("/proc/{}/status", child.id());
    let mut most = 0;
    while child.try_wait().unwrap().is_none() {
        let text = fs::read_to_string(&status).unwrap_or_default();
        let line = text.lines().find(|line| line.starts_with("VmHWM:"));
        let kib = line.and_then(|line| line.split_whitespace().nth(1)?.parse::<u64>().ok());
        most = most.max(kib.unwrap_or(0) << 10);
        sleep(Duration::from_millis(2));
    }
    most
}

#[cfg(target_os = "linux")]
#[test]
fn planned_memory_matches_measured_peak() {
    let folder = folder_with_materials("planned");
    write_file(&folder, "soup.obj", room_with_triangles(10_000));
    // Scenes whose memory is mostly texels, links, and faces.
    for (name, texels, patches, more) in [
        ("room.obj", 512, 1, ""),
        ("room.obj", 128, 8, ""),
        ("soup.obj", 1, 1, " --max-shots 2"),
    ] {
        let arguments = format!(
            "shoot {name} --solver cpu --epsilon 0.1 --texels {texels} --patches {patches} --samples 1 --quiet{more}"
        );
        let found = peak_memory(&folder, &arguments);
        let scene = common::import::load_scene(&folder.join(name), &Default::default()).unwrap();
        let settings = common::settings::Settings {
            meshing: common::settings::Meshing {
                texels,
                patches,
                samples: 1,
            },
            ..Default::default()
        };
        let mut memory = SolveMemory::on_cpu(&SceneCounts::new(&scene, &settings.meshing), &settings);
        if !more.is_empty() {
            // Two shots make only a few of the links.
            memory.links = 0;
        }
        let share = memory.peak_bytes() as f64 / found as f64;
        println!("{arguments}: {found} bytes, {share:.2} of them told");
        assert!((1.0 / 1.3..1.3).contains(&share), "{arguments}: {found}, {memory:?}");
    }
    fs::remove_dir_all(folder).unwrap();
}
