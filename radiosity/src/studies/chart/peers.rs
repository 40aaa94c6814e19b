//! Measurements of other programs on the same scenes, read from `peers.json`.

use common::text::escape_control;
use common::{Error, Result, file};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// One solve by another program.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Peer {
    /// Name of the program.
    pub peer: String,
    /// Variant of the program, if it has several.
    pub variant: Option<String>,
    /// Sampler used.
    pub sampler: Option<String>,
    /// File of the scene.
    pub scene: String,
    /// Samples used.
    pub samples: Option<u64>,
    /// Seconds of the solve.
    pub seconds: f64,
    /// Seconds of the setup before it.
    pub setup_seconds: Option<f64>,
    /// Relative RMS error.
    pub error: f64,
    /// Threads used.
    pub threads: Option<u32>,
}

impl Peer {
    /// Returns seconds of setup and solve together, and the error.
    pub fn time_and_error(&self) -> [f64; 2] {
        [self.seconds + self.setup_seconds.unwrap_or(0.0), self.error]
    }

    /// Returns program, variant, sampler and counts as one line.
    pub fn describe_peer(&self) -> String {
        let names = [Some(&self.peer), self.variant.as_ref(), self.sampler.as_ref()];
        let names: Vec<&str> = names.into_iter().flatten().map(String::as_str).collect();
        let samples = self.samples.map(|n| format!(", {n} samples"));
        let threads = self.threads.map(|n| format!(", {n} threads"));
        escape_control(&(names.join(" ") + &samples.unwrap_or_default() + &threads.unwrap_or_default()))
    }

    /// Returns whether it solved the scene of this file.
    pub fn solved_scene(&self, scene: &str) -> bool {
        Path::new(&self.scene).file_stem() == Path::new(scene).file_stem()
    }
}

/// The part of a file written by `peers/` that the chart needs.
#[derive(Deserialize)]
struct File {
    points: Vec<Peer>,
}

/// Reads the measurements in a file. Errors: it cannot be read, or an entry has no seconds or error.
pub fn read_peers(path: &Path) -> Result<Vec<Peer>> {
    let failed = |reason: String| {
        let message = format!("is not a list of other programs' solves: {reason}");
        Error::bad_input(path, "", message)
    };
    let text = file::read_input(path, "a list of other programs' solves is needed")?;
    let File { points: peers } = serde_json::from_slice(&text).map_err(|e| failed(e.to_string()))?;
    let is_bad = |p: &Peer| !(p.time_and_error()[0] >= 0.0 && p.time_and_error()[0].is_finite() && p.error >= 0.0);
    match peers.iter().position(is_bad) {
        Some(k) => Err(failed(format!("entry {k} has no seconds or no error"))),
        None => Ok(peers),
    }
}
