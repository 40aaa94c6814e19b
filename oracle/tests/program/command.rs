//! Runs the program for its tests.

use std::fs;
use std::path::PathBuf;
use std::process::{Command, Output};

/// An empty folder of this process.
pub fn folder(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("radiosity-{}-{name}", std::process::id()));
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    folder
}

/// Runs the program.
pub fn radiosity(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_radiosity"))
        .args(arguments)
        .output()
        .unwrap()
}

/// Exit code, and the one line that begins with `error:`.
pub fn failure(arguments: &[&str]) -> (i32, String) {
    let output = radiosity(arguments);
    let text = String::from_utf8(output.stderr).unwrap();
    let ours: Vec<&str> = text
        .lines()
        .filter(|line| line.starts_with("error:"))
        .collect();
    assert_eq!(ours.len(), 1, "{arguments:?}: {text}");
    assert!(!text.contains("panicked"), "{text}");
    (output.status.code().unwrap(), ours[0].to_owned())
}
