//! Runs the program and reads its output.

use std::fs;
use std::path::PathBuf;
use std::process::{Command, Output};

/// Makes an empty folder of this process.
pub fn empty_folder(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("radiosity-{}-{name}", std::process::id()));
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    folder
}

/// Runs the program.
pub fn run_radiosity(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_radiosity"))
        .args(arguments)
        .output()
        .unwrap()
}

/// Runs the program; returns its exit code and its only line, which must begin with `error:`.
pub fn exit_code_and_error(arguments: &[&str]) -> (i32, String) {
    let output = run_radiosity(arguments);
    let text = String::from_utf8(output.stderr).unwrap();
    let ours: Vec<&str> = text.lines().filter(|line| line.starts_with("error:")).collect();
    assert_eq!(ours.len(), 1, "{arguments:?}: {text}");
    assert!(!text.contains("panicked"), "{text}");
    (output.status.code().unwrap(), ours[0].to_owned())
}
