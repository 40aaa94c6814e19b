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

/// Reads files, relative to the list's folder, and their seconds from `column`, or from the first recognised one.
///
/// Fields are separated by commas and not quoted; empty lines are skipped.
///
/// Errors: [`Error::Input`] with the list and the line.
pub fn read_exposures(path: &Path, column: Option<&str>) -> Result<Vec<(PathBuf, f64)>> {
    let refuse = |message: String| Error::bad_input(path, "", message);
    let bytes = file::read(path, MAX_LIST_BYTES).map_err(|e| refuse(format!("cannot be read: {e}")))?;
    let text = String::from_utf8(bytes).map_err(|e| refuse(format!("cannot be read as text: {e}")))?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let lines = text.trim_start_matches('\u{feff}').lines();
    let mut lines = (1..).zip(lines).filter(|(_, line)| !line.trim().is_empty());
    let (_, header) = lines.next().ok_or_else(|| refuse("is empty".into()))?;
    let names: Vec<&str> = header.split(',').map(str::trim).collect();
    let places = ListColumns::new(&names, column).map_err(refuse)?;
    lines
        .map(|(line, text)| {
            places
                .parse_line(text)
                .map(|(file, seconds)| (folder.join(file), seconds))
                .map_err(|message| Error::bad_input(path, format!("line {line}"), message))
        })
        .collect()
}

/// Positions of the fields in a line.
struct ListColumns<'a> {
    file: usize,
    seconds: usize,
    column: &'a str,
    count: usize,
}

impl<'a> ListColumns<'a> {
    fn new(names: &[&'a str], column: Option<&'a str>) -> std::result::Result<Self, String> {
        let place = |name: &str| names.iter().position(|n| *n == name);
        let wanted: Vec<&'a str> = match column {
            Some(column) => vec![column],
            None => SECONDS_COLUMNS.to_vec(),
        };
        let found = wanted.iter().find_map(|name| Some((*name, place(name)?)));
        let missing = |name: &str| format!("its first line names no column `{name}`");
        let (column, seconds) = found.ok_or_else(|| missing(&wanted.join("`, `")))?;
        Ok(Self {
            file: place(FILE_COLUMN).ok_or_else(|| missing(FILE_COLUMN))?,
            seconds,
            column,
            count: names.len(),
        })
    }

    fn parse_line<'t>(&self, line: &'t str) -> std::result::Result<(&'t str, f64), String> {
        let fields: Vec<&str> = line.split(',').map(str::trim).collect();
        if fields.len() != self.count {
            return Err(format!("has {} fields, the first line {}", fields.len(), self.count));
        }
        let file = fields[self.file];
        if file.is_empty() || file.contains('"') {
            return Err(format!("`{file}` is not a file name (no quotes are needed)"));
        }
        let text = fields[self.seconds];
        let value = parse_seconds(text).ok_or_else(|| {
            format!(
                "`{text}` in column `{}` is not a number of seconds above 0",
                self.column
            )
        })?;
        Ok((file, value))
    }
}
