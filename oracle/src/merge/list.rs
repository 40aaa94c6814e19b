//! Exposures as a table: a CSV file with a column of file names and one of seconds.

use common::{Error, Result, file};
use std::path::{Path, PathBuf};

/// Columns of seconds, the most exact first.
const SECONDS: [&str; 3] = ["seconds_third_stop_exact", "seconds", "seconds_nominal"];
/// The column of file names.
const FILE: &str = "file";
/// Longer lists are none.
const MAX_BYTES: u64 = 1 << 20;

/// "0.0125" or "1/80", above 0.
pub fn seconds(text: &str) -> Option<f64> {
    let number = |text: &str| text.trim().parse::<f64>().ok();
    let value = match text.split_once('/') {
        Some((a, b)) => number(a)? / number(b)?,
        None => number(text)?,
    };
    (value > 0.0 && value.is_finite()).then_some(value)
}

/// Files, relative to the list's folder, and their seconds; from `column`, or from the first of
/// the usual ones that is there.
///
/// Fields end at commas and are not quoted; empty lines are passed over.
///
/// Errors: [`Error::Input`] with the list and the line.
pub fn read(path: &Path, column: Option<&str>) -> Result<Vec<(PathBuf, f64)>> {
    let refuse = |message: String| Error::input(path, "", message);
    let bytes = file::read(path, MAX_BYTES).map_err(|e| refuse(format!("cannot be read: {e}")))?;
    let text =
        String::from_utf8(bytes).map_err(|e| refuse(format!("cannot be read as text: {e}")))?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let lines = text.trim_start_matches('\u{feff}').lines();
    let mut lines = (1..).zip(lines).filter(|(_, line)| !line.trim().is_empty());
    let (_, header) = lines.next().ok_or_else(|| refuse("is empty".into()))?;
    let names: Vec<&str> = header.split(',').map(str::trim).collect();
    let places = Places::new(&names, column).map_err(refuse)?;
    lines
        .map(|(line, text)| {
            places
                .exposure(text)
                .map(|(file, seconds)| (folder.join(file), seconds))
                .map_err(|message| Error::input(path, format!("line {line}"), message))
        })
        .collect()
}

/// Where in a line the fields are.
struct Places<'a> {
    file: usize,
    seconds: usize,
    column: &'a str,
    count: usize,
}

impl<'a> Places<'a> {
    fn new(names: &[&'a str], column: Option<&'a str>) -> std::result::Result<Self, String> {
        let place = |name: &str| names.iter().position(|n| *n == name);
        let wanted: Vec<&'a str> = match column {
            Some(column) => vec![column],
            None => SECONDS.to_vec(),
        };
        let found = wanted.iter().find_map(|name| Some((*name, place(name)?)));
        let missing = |name: &str| format!("its first line names no column `{name}`");
        let (column, seconds) = found.ok_or_else(|| missing(&wanted.join("`, `")))?;
        Ok(Self {
            file: place(FILE).ok_or_else(|| missing(FILE))?,
            seconds,
            column,
            count: names.len(),
        })
    }

    fn exposure<'t>(&self, line: &'t str) -> std::result::Result<(&'t str, f64), String> {
        let fields: Vec<&str> = line.split(',').map(str::trim).collect();
        if fields.len() != self.count {
            return Err(format!(
                "has {} fields, the first line {}",
                fields.len(),
                self.count
            ));
        }
        let file = fields[self.file];
        if file.is_empty() || file.contains('"') {
            return Err(format!(
                "`{file}` is not a file name (no quotes are needed)"
            ));
        }
        let text = fields[self.seconds];
        let value = seconds(text).ok_or_else(|| {
            format!(
                "`{text}` in column `{}` is not a number of seconds above 0",
                self.column
            )
        })?;
        Ok((file, value))
    }
}
