//! `solve --settings FILE`: what an earlier result.json says of its settings, as options.

use clap::Error;
use clap::error::ErrorKind;
use common::file;
use serde_json::Value;
use std::ffi::OsString;
use std::path::Path;

/// What a result may ask for; nothing else in it reaches the command line.
const OPTIONS: [&str; 14] = [
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

/// The solver and the settings of the result.
///
/// Errors: a file that does not describe a solve.
pub fn options(path: &Path) -> Result<Vec<OsString>, Error> {
    let bytes = file::input(path, "a result.json of solve is needed");
    let bytes = bytes.map_err(|error| Error::raw(ErrorKind::Io, error))?;
    let result: Value = serde_json::from_slice(&bytes).unwrap_or_default();
    let refused = || not_such(path);
    let settings = result["settings"].as_object().ok_or_else(refused)?;
    let known = |name: &&String| OPTIONS.contains(&name.as_str());
    if !result["solver"].is_string() || !settings.keys().all(|name| known(&name)) {
        return Err(refused());
    }
    let mut options = vec![option("solver", &result["solver"]).ok_or_else(refused)?];
    for (name, value) in settings {
        options.push(option(name, value).ok_or_else(refused)?);
    }
    Ok(options.into_iter().flatten().map(OsString::from).collect())
}

/// The refusal of a file that is no result of a solve.
pub fn not_such(path: &Path) -> Error {
    let message = format!(
        "--settings {}: does not have the settings of a solve: give a result.json of solve",
        path.display()
    );
    Error::raw(ErrorKind::InvalidValue, message)
}

/// An option as it is given, nothing for a switch that is off; none where it is no value of one.
fn option(name: &str, value: &Value) -> Option<Option<String>> {
    Some(match (value, value.as_f64()) {
        (Value::Bool(on), _) => on.then(|| format!("--{name}")),
        // A share, which is asked for in per cent.
        (_, Some(share)) if name == "error" => Some(format!("--{name}={}", 100.0 * share)),
        (Value::Number(number), _) => Some(format!("--{name}={number}")),
        (Value::String(text), _) => Some(format!("--{name}={text}")),
        _ => return None,
    })
}
