//! The score of the comparison: one mutant of each shader, and those that it does not find, or not by a stage of theirs. And
//! the check of an adapter.

mod hardware;

use serde_json::Value;
use std::process::Command;
use std::{env, fs, process};

/// Shader, line, text that changes and its new text of each mutant that survives, and of each that is found by no stage of its
/// own, with the reason.
const MISSED_MUTANTS: &str = include_str!("mutants.tsv");

/// Number of mutants: one of each shader.
const MUTANT_COUNT: usize = 36;

#[test]
fn comparison_finds_the_mutants_that_it_found() {
    let folder = env::temp_dir().join(format!("radiosity-mutants-{}", process::id()));
    fs::create_dir_all(&folder).unwrap();
    let mut program = Command::new(env!("CARGO_BIN_EXE_radiosity"));
    program.args(["sabotage", "--count", &MUTANT_COUNT.to_string(), "--out"]);
    let output = program.arg(&folder).output().unwrap();
    let told = String::from_utf8_lossy(&output.stderr);
    let json = fs::read(folder.join("sabotage.json")).unwrap_or_else(|error| panic!("{error}: {told}"));
    fs::remove_dir_all(&folder).unwrap();
    let found: Value = serde_json::from_slice(&json).unwrap();
    let rows = found["rows"].as_array().unwrap();
    assert_eq!(rows.len(), MUTANT_COUNT, "{told}");
    let is_missed = |row: &&Value| match row["verdict"].as_str() {
        Some("killed") => row["own_stage"] == false,
        verdict => verdict == Some("survived") || verdict == Some("not-run"),
    };
    let names = ["shader", "line_text", "original", "mutated", "verdict", "reason"];
    let word = |text: &Value| {
        let words: Vec<&str> = text.as_str().unwrap().split_whitespace().collect();
        words.join(" ")
    };
    let describe = |row: &Value| names.map(|name| word(&row[name])).join("\t").trim_end().to_owned();
    let missed: Vec<String> = rows.iter().filter(is_missed).map(describe).collect();
    let missed = missed.join("\n");
    assert_eq!(
        MISSED_MUTANTS.trim_end(),
        missed,
        "mutants.tsv should have:\n{missed}\n"
    );
}
