//! What the program says: what was asked for on stdout, all else on stderr. Nothing else prints, so
//! that no closed or full pipe ends a solve (`println!` and `eprintln!` panic there).

use common::text::plain;
use common::{Error, Result};
use serde_json::Value;
use std::fmt::Arguments;
use std::io::{ErrorKind, Write, stderr, stdout};
use std::sync::atomic::{AtomicBool, Ordering};

static QUIET: AtomicBool = AtomicBool::new(false);

/// From now on only errors are told (`--quiet`).
pub fn hush() {
    QUIET.store(true, Ordering::Relaxed);
}

/// A line of what was asked for, on stdout. A reader who went away wanted no more; that is no error.
///
/// Errors: [`Error::Write`]: a full disk behind it, for instance.
pub fn print(line: Arguments) -> Result<()> {
    printed(writeln!(stdout().lock(), "{}", plain(&line.to_string())))
}

/// What a program reads, on stdout: one line of JSON.
///
/// Errors: as of [`print`].
pub fn json(found: &Value) -> Result<()> {
    print(format_args!("{found}"))
}

/// Text that is printed as it is: ours, without a word from any file.
///
/// Errors: as of [`print`].
pub fn verbatim(text: &[u8]) -> Result<()> {
    printed(stdout().lock().write_all(text))
}

/// What became of something that was printed on stdout.
pub fn printed(result: std::io::Result<()>) -> Result<()> {
    match result {
        Err(source) if source.kind() != ErrorKind::BrokenPipe => Err(Error::Write {
            path: "stdout".into(),
            source,
        }),
        _ => Ok(()),
    }
}

/// A line on stderr, unless `--quiet`: notes, warnings, the summary.
pub fn mention(line: Arguments) {
    if !QUIET.load(Ordering::Relaxed) {
        told(&line.to_string());
    }
}

/// The one line of an error.
pub fn error(message: &str) {
    let words: Vec<&str> = message.split_whitespace().collect();
    told(&format!("error: {}", words.join(" ")));
}

/// Where stderr cannot be written nobody can be told, and the work goes on.
fn told(line: &str) {
    let _ = writeln!(stderr().lock(), "{}", plain(line));
}

/// [`mention`] with a format.
macro_rules! say {
    ($($text:tt)*) => { $crate::cli::tell::mention(format_args!($($text)*)) };
}

/// [`print`] with a format.
macro_rules! result {
    ($($text:tt)*) => { $crate::cli::tell::print(format_args!($($text)*)) };
}

pub(super) use {result, say};
