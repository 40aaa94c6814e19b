//! `--watch`: runs a command again when one of its files changes.

use super::console::message;
use super::progress::{handle_interrupts, is_interrupted};
use super::{Outcome, report_error};
use common::Result;
use std::path::PathBuf;
use std::time::{Duration, SystemTime};

/// Time between two looks at the files.
const POLL_INTERVAL: Duration = Duration::from_millis(200);

/// Runs a command, and again whenever one of `files` changes, until Ctrl-C. Returns the outcome of the last run; that of
/// a failed one is a disagreement.
pub fn run_on_changes(files: impl Fn() -> Vec<PathBuf>, run: impl Fn() -> Result<Outcome>) -> Outcome {
    handle_interrupts();
    loop {
        let before = modification_times(&files());
        let outcome = run().unwrap_or_else(|error| {
            report_error(&error);
            Outcome::Disagree
        });
        if !is_interrupted() {
            message!("waiting for a change of {} files; Ctrl-C ends", before.len());
        }
        while modification_times(&files()) == before {
            if is_interrupted() {
                return outcome;
            }
            std::thread::sleep(POLL_INTERVAL);
        }
    }
}

/// Returns the time at which each file was modified; none of a file that cannot be found.
fn modification_times(files: &[PathBuf]) -> Vec<(PathBuf, Option<SystemTime>)> {
    let time = |path: &PathBuf| std::fs::metadata(path).and_then(|data| data.modified()).ok();
    files.iter().map(|path| (path.clone(), time(path))).collect()
}
