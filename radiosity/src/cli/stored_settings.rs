//! `solve --settings FILE`: the settings of an earlier result.json as command-line options.

use clap::Error;
use clap::error::ErrorKind;
use common::file;
use serde_json::Value;
use std::ffi::OsString;
use std::path::Path;

/// Settings that are options; a file with any other is refused.
const SETTING_OPTIONS: [&str; 14] = [
    "quality",
    "texels",
    "cells",
    "samples",
    "visibility",
    "item-buffer",
    "raster",
    "lookup",
    "form-factor",
    "conserve",
    "iteration",
    "epsilon",
    "max-shots",
    "error",
];

/// Reads solver and settings of a result as options.
///
/// Errors: the file cannot be read or does not describe a solution.
pub fn stored_options(path: &Path) -> Result<Vec<OsString>, Error> {
    let bytes = file::read_input(path, "a result.json of solve or shoot is needed");
    let bytes = bytes.map_err(|error| Error::raw(ErrorKind::Io, error))?;
    let result: Value = serde_json::from_slice(&bytes).unwrap_or_default();
    let refused = || not_a_result(path);
    let settings = result["settings"].as_object().ok_or_else(refused)?;
    let known = |name: &&String| SETTING_OPTIONS.contains(&name.as_str());
    if !result["solver"].is_string() || !settings.keys().all(|name| known(&name)) {
        return Err(refused());
    }
    let mut options = vec![format_option("solver", &result["solver"]).ok_or_else(refused)?];
    for (name, value) in settings {
        options.push(format_option(name, value).ok_or_else(refused)?);
    }
    Ok(options.into_iter().flatten().map(OsString::from).collect())
}

/// Returns the error of a file whose settings the command cannot take.
pub fn not_a_result(path: &Path) -> Error {
    let message = format!(
        "--settings {}: does not have the settings of this command: give a result.json that it wrote",
        path.display()
    );
    Error::raw(ErrorKind::InvalidValue, message)
}

/// Formats a setting as an option: `Some(None)` for a switch that is off, `None` if an option cannot have `value`.
fn format_option(name: &str, value: &Value) -> Option<Option<String>> {
    Some(match (value, value.as_f64()) {
        (Value::Bool(on), _) => on.then(|| format!("--{name}")),
        // Stored as a share, given in per cent.
        (_, Some(share)) if name == "error" => Some(format!("--{name}={}", 100.0 * share)),
        (Value::Number(number), _) => Some(format!("--{name}={number}")),
        (Value::String(text), _) => Some(format!("--{name}={text}")),
        _ => return None,
    })
}
