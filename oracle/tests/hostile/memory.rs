//! What there is not enough memory for is refused before it starts, and what is told of it is true.

#![allow(
    clippy::disallowed_methods,
    reason = "reads what the program and the system wrote"
)]

use super::cube::{soup, with_materials};
use super::kit::{errors, in_shell, put, told, well_behaved};
use oracle::plan::Counts;
use oracle::plan::memory::Memory;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::Duration;

#[test]
fn too_little_memory_is_refused() {
    let folder = with_materials("memory");
    let solve = "solve room.obj --solver cpu --texels 1024 --quality draft";
    let words: Vec<&str> = solve.split(' ').collect();
    let ended = in_shell(&folder, "ulimit -v 800000; exec \"$0\" \"$@\"", &words);
    let what = told(solve, &ended);
    println!("{what}");
    assert_eq!(ended.code, Some(2), "{what}");
    well_behaved(&folder, &ended, &what);
    let line = errors(&ended)[0];
    assert!(
        line.contains("allowed by ulimit") && line.contains("would fit"),
        "{line}"
    );
    // And what is said to fit does.
    let found = line
        .split("--texels ")
        .nth(1)
        .and_then(|rest| rest.split(' ').next());
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
    let ended = in_shell(&folder, "ulimit -v 800000; exec \"$0\" \"$@\"", &fitting);
    let what = told(texels, &ended);
    println!("{what}");
    assert_eq!(ended.code, Some(0), "{what}");
    fs::remove_dir_all(folder).unwrap();
}

/// Runs the program until it ends; its greatest resident memory in bytes.
fn peak(folder: &Path, arguments: &str) -> u64 {
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
fn the_memory_of_a_plan_is_that_of_the_solve() {
    let folder = with_materials("planned");
    put(&folder, "soup.obj", soup(10_000));
    // Texels, faces, links.
    for (name, texels, cells, more) in [
        ("room.obj", 512, 1, ""),
        ("room.obj", 128, 8, ""),
        ("soup.obj", 1, 1, " --max-shots 2"),
    ] {
        let arguments = format!(
            "solve {name} --solver cpu --epsilon 0.1 --texels {texels} --cells {cells} --samples 1 --quiet{more}"
        );
        let found = peak(&folder, &arguments);
        let scene = common::import::load(&folder.join(name), &Default::default()).unwrap();
        let settings = common::settings::Settings {
            meshing: common::settings::Meshing {
                texels,
                cells,
                samples: 1,
            },
            ..Default::default()
        };
        let mut memory = Memory::cpu(&Counts::new(&scene, &settings.meshing), &settings);
        if !more.is_empty() {
            // Two shots make few of the links.
            memory.links = 0;
        }
        let share = memory.bytes() as f64 / found as f64;
        println!("{arguments}: {found} bytes, {share:.2} of them told");
        assert!(
            (1.0 / 1.3..1.3).contains(&share),
            "{arguments}: {found}, {memory:?}"
        );
    }
    fs::remove_dir_all(folder).unwrap();
}
