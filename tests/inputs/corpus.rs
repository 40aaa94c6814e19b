//! Repeats the inputs that are kept in `fuzz/corpus`: what fuzzing has reached, and all that it has found.

use input_tests::{CHECKS, Check};
use std::collections::BTreeSet;
use std::fs;
use std::panic::catch_unwind;
use std::path::{Path, PathBuf};

/// Largest memory of the process, bytes: pictures and maps of the largest accepted sizes take half of it.
const MAX_MEMORY: u64 = 3 << 30;
/// Limits that keep the folder small: bytes of all inputs, and number of inputs of a check.
const MAX_CORPUS_BYTES: u64 = 400_000;
const MAX_INPUTS: usize = 40;

fn fuzz_folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz")
}

/// Returns the files of a folder, sorted by name.
fn list_files(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
    let mut files: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    files.sort_unstable();
    files
}

/// Returns the names of a folder's entries, without endings.
fn names_in(folder: &Path) -> BTreeSet<String> {
    let files = list_files(folder).into_iter();
    files
        .map(|path| path.file_stem().unwrap().to_string_lossy().into_owned())
        .collect()
}

/// Runs a check on each input; returns a line on each that breaks a promise.
fn find_broken_inputs(check: Check, inputs: &[PathBuf]) -> Vec<String> {
    let mut broken = Vec::new();
    for path in inputs {
        let bytes = fs::read(path).unwrap();
        if catch_unwind(|| check(&bytes)).is_err() {
            broken.push(format!("{} breaks a promise", path.display()));
        }
    }
    broken
}

/// Returns the largest resident memory of this process so far, bytes.
#[cfg(target_os = "linux")]
fn peak_memory() -> Option<u64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kibibytes: u64 = line.split_whitespace().next()?.parse().ok()?;
    Some(kibibytes << 10)
}

#[test]
fn kept_inputs_break_no_promise() {
    let mut broken = Vec::new();
    for (name, check) in CHECKS {
        let inputs = list_files(&fuzz_folder().join("corpus").join(name));
        broken.extend(find_broken_inputs(check, &inputs));
    }
    assert!(broken.is_empty(), "{}", broken.join("\n"));
    #[cfg(target_os = "linux")]
    assert!(
        peak_memory().is_some_and(|bytes| bytes < MAX_MEMORY),
        "{:?} bytes",
        peak_memory()
    );
}

#[test]
fn broken_promise_is_reported() {
    let inputs = list_files(&fuzz_folder().join("corpus/obj"));
    let broken = find_broken_inputs(|data| assert!(!data.starts_with(b"v")), &inputs);
    assert!(!broken.is_empty() && broken.len() < inputs.len(), "{broken:?}");
}

#[test]
fn each_check_has_a_target_and_a_few_small_inputs() {
    let folder = fuzz_folder();
    let names: BTreeSet<String> = CHECKS.iter().map(|(name, _)| (*name).to_owned()).collect();
    assert_eq!(names, names_in(&folder.join("fuzz_targets")));
    assert_eq!(names, names_in(&folder.join("corpus")));
    let manifest = fs::read_to_string(folder.join("Cargo.toml")).unwrap();
    let mut bytes = 0;
    for name in &names {
        let target = fs::read_to_string(folder.join(format!("fuzz_targets/{name}.rs"))).unwrap();
        assert!(target.contains(&format!("::check_{name}(data)")), "{name}: {target}");
        assert!(
            manifest.contains(&format!("path = \"fuzz_targets/{name}.rs\"")),
            "{name}"
        );
        let inputs = list_files(&folder.join("corpus").join(name));
        assert!(
            (1..=MAX_INPUTS).contains(&inputs.len()),
            "{name}: {} inputs",
            inputs.len()
        );
        bytes += inputs.iter().map(|path| path.metadata().unwrap().len()).sum::<u64>();
    }
    assert!(bytes <= MAX_CORPUS_BYTES, "{bytes} bytes");
}
