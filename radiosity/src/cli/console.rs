//! Output: results on stdout, everything else on stderr. All output goes through this module, so that no closed
//! or full pipe ends a solve (`println!` and `eprintln!` would panic).

use common::text::escape_control;
use common::{Error, Result};
use std::fmt::Arguments;
use std::io::{ErrorKind, Write, stderr, stdout};
use std::sync::atomic::{AtomicBool, Ordering};

static QUIET: AtomicBool = AtomicBool::new(false);

/// Suppresses everything on stderr but errors (`--quiet`).
pub fn silence_notes() {
    QUIET.store(true, Ordering::Relaxed);
}

/// Returns true under `--quiet`.
pub fn is_quiet() -> bool {
    QUIET.load(Ordering::Relaxed)
}

/// Prints a line on stdout. A closed pipe is no error: its reader wants no more.
///
/// Errors: [`Error::Write`], for instance on a full disk.
pub fn print_line(line: Arguments) -> Result<()> {
    check_stdout(writeln!(stdout().lock(), "{}", escape_control(&line.to_string())))
}

/// Converts the result of a write to stdout; a closed pipe is success.
///
/// Errors: any other failure.
pub fn check_stdout(result: std::io::Result<()>) -> Result<()> {
    match result {
        Err(source) if source.kind() != ErrorKind::BrokenPipe => Err(Error::Write {
            path: "stdout".into(),
            source,
        }),
        _ => Ok(()),
    }
}

/// Prints a line on stderr unless `--quiet`: notes, warnings, summaries.
pub fn print_message(line: Arguments) {
    if !is_quiet() {
        write_stderr(&line.to_string());
    }
}

/// Prints the `error:` line.
pub fn print_error(message: &str) {
    let words: Vec<&str> = message.split_whitespace().collect();
    write_stderr(&format!("error: {}", words.join(" ")));
}

/// Prints lines that follow an `error:` line as they are.
pub fn print_error_lines(text: &str) {
    text.lines().for_each(write_stderr);
}

/// Writes a line to stderr. A failure is ignored: the work goes on.
fn write_stderr(line: &str) {
    let _ = writeln!(stderr().lock(), "{}", escape_control(line));
}

/// Formats and prints a line by [`print_message`].
macro_rules! message {
    ($($text:tt)*) => { $crate::cli::console::print_message(format_args!($($text)*)) };
}

/// Formats and prints a line by [`print_line`].
macro_rules! output {
    ($($text:tt)*) => { $crate::cli::console::print_line(format_args!($($text)*)) };
}

pub(super) use {message, output};
