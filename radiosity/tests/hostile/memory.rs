//! Memory: solves that do not fit are refused before they start, and plans match the measured memory.

use crate::program::command::TestFolder;
use crate::program::merge::{folder_with_bracket, with_inflating_profile};
use crate::program::room::{folder_with_room, room_with_triangles};
use common::settings::{Meshing, Settings};
use oracle::solve::solver::SolverChoice;
use radiosity::plan::memory::solve_bytes;
use std::fs;
use std::process::Stdio;
use std::thread::sleep;
use std::time::Duration;

#[test]
fn solve_beyond_available_memory_is_refused() {
    let folder = folder_with_room();
    let solve = |texels: &str| {
        let line = format!("solve room.obj --solver cpu --quality draft --texels {texels}");
        folder.run_in_shell("ulimit -v 800000; exec RUN", &line)
    };
    let end = solve("1024");
    assert_eq!(end.code, Some(2), "{end}");
    let line = end.errors()[0];
    assert!(
        line.contains("allowed by ulimit") && line.contains("would fit"),
        "{line}"
    );
    // The advised settings do fit.
    let found = line.split("--texels ").nth(1).and_then(|rest| rest.split(' ').next());
    let end = solve(found.unwrap_or_else(|| panic!("{line}")));
    assert_eq!(end.code, Some(0), "{end}");
}

#[test]
fn limit_that_leaves_nothing_is_refused() {
    let folder = folder_with_room();
    for line in [
        "solve room.obj --solver cpu",
        "relight --room room.obj --object cube.obj --place .5,.5,.5 --solver cpu",
    ] {
        let end = folder.run_in_shell("ulimit -v 500000; exec RUN", line);
        assert_eq!(end.code, Some(2), "{end}");
        let said = "the memory allowed by ulimit is taken by the program and its threads: allow 1 GB at least";
        assert!(matches!(end.errors()[..], [error] if error.contains(said)), "{end}");
    }
    let end = folder.run_in_shell(
        "ulimit -v 800000; exec RUN",
        "relight --room room.obj --object cube.obj --solver cpu",
    );
    let is_refused = matches!(end.errors()[..], [error] if error.contains("texels of room and objects take"));
    assert!(end.code == Some(2) && is_refused, "{end}");
}

/// Runs the program to its end; returns its peak resident memory in bytes.
fn peak_memory(folder: &TestFolder, line: &str) -> u64 {
    let mut command = folder.command(&line.split(' ').collect::<Vec<_>>());
    let mut child = command.stderr(Stdio::null()).spawn().unwrap();
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
fn colour_profile_that_inflates_is_skipped() {
    let folder = folder_with_bracket("png");
    folder.write("profile.png", with_inflating_profile(&folder.read("a.png")));
    let most = ["a.png", "profile.png"].map(|first| {
        let line = format!("merge {first} b.png --seconds 1,4 --out {first}-out");
        let found = peak_memory(&folder, &line);
        assert!(folder.has(&format!("{first}-out/radiance.exr")), "{line}");
        found
    });
    assert!(most[1] < most[0] + (80 << 20), "{most:?} bytes");
}

#[cfg(target_os = "linux")]
#[test]
fn planned_memory_matches_measured_peak() {
    let folder = folder_with_room();
    folder.write("soup.obj", room_with_triangles(5000));
    // Scenes whose memory is mostly texels, links, and faces. Two shots make only a few of the links.
    for (name, texels, patches, shots) in [
        ("room.obj", 512, 1, 100),
        ("room.obj", 128, 8, 10_000),
        ("soup.obj", 1, 1, 2),
    ] {
        let line = format!(
            "shoot {name} --solver cpu --epsilon 0.1 --texels {texels} --patches {patches} --samples 1 --max-shots {shots} --quiet"
        );
        let found = peak_memory(&folder, &line);
        let scene = common::import::load_scene(&folder.path(name), &Default::default()).unwrap();
        let meshing = Meshing {
            texels,
            patches,
            samples: 1,
        };
        let mut settings = Settings {
            meshing,
            ..Default::default()
        };
        settings.schedule.max_shots = shots;
        let planned = solve_bytes(&scene, &settings, SolverChoice::Cpu);
        let share = planned as f64 / found as f64;
        println!("{line}: {found} bytes, {share:.2} of them planned");
        assert!((1.0 / 1.3..1.3).contains(&share), "{line}: {found}, {planned}");
    }
}
