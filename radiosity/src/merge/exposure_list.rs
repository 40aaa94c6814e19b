//! Reads an exposure list: a CSV file with a column of file names and one of seconds.

use common::{Error, Result, file};
use std::path::{Path, PathBuf};

/// Recognised columns of seconds, the most exact first.
const SECONDS_COLUMNS: [&str; 3] = ["seconds_third_stop_exact", "seconds", "seconds_nominal"];
/// Column of file names.
const FILE_COLUMN: &str = "file";
/// Maximum size of a list.
const MAX_LIST_BYTES: u64 = 1 << 20;

/// Parses "0.0125" or "1/80"; none unless finite and above 0.
pub fn parse_seconds(text: &str) -> Option<f64> {
    let number = |text: &str| text.trim().parse::<f64>().ok();
    let value = match text.split_once('/') {
        Some((a, b)) => number(a)? / number(b)?,
        None => number(text)?,
    };
    (value > 0.0 && value.is_finite()).then_some(value)
}

/// Reads files, relative to the list's folder, and their seconds from the first recognised column.
///
/// Fields are separated by commas and not quoted; empty lines are skipped.
///
/// Errors: [`Error::Input`] with the list and the line.
pub fn read_exposures(path: &Path) -> Result<Vec<(PathBuf, f64)>> {
    let refuse = |message: String| Error::bad_input(path, "", message);
    let bytes = file::read(path, MAX_LIST_BYTES).map_err(|e| refuse(format!("cannot be read: {e}")))?;
    let text = String::from_utf8(bytes).map_err(|e| refuse(format!("cannot be read as text: {e}")))?;
    let lines = text.trim_start_matches('\u{feff}').lines();
    let mut lines = (1..).zip(lines).filter(|(_, line)| !line.trim().is_empty());
    let (_, header) = lines.next().ok_or_else(|| refuse("is empty".into()))?;
    let names: Vec<&str> = header.split(',').map(str::trim).collect();
    let place = |name: &str| names.iter().position(|n| *n == name);
    let missing = |name: &str| refuse(format!("its first line names no column `{name}`"));
    let found = SECONDS_COLUMNS.iter().find_map(|name| Some((*name, place(name)?)));
    let (seconds_name, seconds) = found.ok_or_else(|| missing(&SECONDS_COLUMNS.join("`, `")))?;
    let file = place(FILE_COLUMN).ok_or_else(|| missing(FILE_COLUMN))?;

    let parse_line = |line: &str| {
        let fields: Vec<&str> = line.split(',').map(str::trim).collect();
        if fields.len() != names.len() {
            return Err(format!("has {} fields, the first line {}", fields.len(), names.len()));
        }
        let (name, time) = (fields[file], fields[seconds]);
        if name.is_empty() || name.contains('"') {
            return Err(format!("`{name}` is not a file name (no quotes are needed)"));
        }
        let value = parse_seconds(time);
        let value =
            value.ok_or_else(|| format!("`{time}` in column `{seconds_name}` is not a number of seconds above 0"))?;
        Ok((path.with_file_name(name), value))
    };
    let numbered = |(line, text): (usize, &str)| {
        parse_line(text).map_err(|message| Error::bad_input(path, format!("line {line}"), message))
    };
    lines.map(numbered).collect()
}
