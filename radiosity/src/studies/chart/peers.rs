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
    /// Texels per side of a face.
    pub texels: Option<u32>,
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
    /// Returns setup and solve together, seconds.
    pub fn total_seconds(&self) -> f64 {
        self.seconds + self.setup_seconds.unwrap_or(0.0)
    }

    /// Returns program, variant, sampler and counts as one line.
    pub fn describe_peer(&self) -> String {
        let mut text = self.peer.clone();
        for part in [&self.variant, &self.sampler].into_iter().flatten() {
            text = format!("{text} {part}");
        }
        let counts = [("samples", self.samples), ("threads", self.threads.map(u64::from))];
        for (name, count) in counts {
            if let Some(count) = count {
                text = format!("{text}, {count} {name}");
            }
        }
        text
    }

    /// Returns whether it solved the scene of this file.
    pub fn solved_scene(&self, scene: &str) -> bool {
        let stem = |name: &str| Path::new(name).file_stem().map(ToOwned::to_owned);
        stem(&self.scene) == stem(scene)
    }
}

/// The part of a file written by `peers/` that the chart needs.
#[derive(Deserialize)]
struct File {
    points: Vec<Peer>,
}

/// Reads the measurements in a file. Errors: it cannot be read, or an entry has no seconds or error.
pub fn read_peers(path: &Path) -> Result<Vec<Peer>> {
    let failed = |e: &dyn std::fmt::Display| {
        let message = format!("is not a list of other programs' solves: {e}");
        Error::bad_input(path, "", message)
    };
    let text = file::read_input(path, "a list of other programs' solves is needed")?;
    let File { points: mut peers } = serde_json::from_slice(&text).map_err(|e| failed(&e))?;
    let sound = |p: &Peer| p.seconds.is_finite() && p.seconds >= 0.0 && p.error >= 0.0;
    for peer in &mut peers {
        for text in [Some(&mut peer.peer), peer.variant.as_mut(), peer.sampler.as_mut()] {
            text.into_iter().for_each(|text| *text = escape_control(text));
        }
    }
    match peers.iter().position(|p| !sound(p)) {
        Some(k) => Err(failed(&format!("entry {k} has no seconds or no error"))),
        None => Ok(peers),
    }
}
