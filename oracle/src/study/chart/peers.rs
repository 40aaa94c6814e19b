//! What other programs took for the same scene, as measured elsewhere.

use common::text::plain;
use common::{Error, Result, file};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// One solve by another program.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Peer {
    /// The program.
    pub peer: String,
    /// Its variant, if it has several.
    pub variant: Option<String>,
    /// Its sampler.
    pub sampler: Option<String>,
    /// The scene's file.
    pub scene: String,
    /// Texels a side.
    pub texels: Option<u32>,
    /// Samples.
    pub samples: Option<u64>,
    /// Its solve.
    pub seconds: f64,
    /// What it took before.
    pub setup_seconds: Option<f64>,
    /// Relative RMS.
    pub error: f64,
    /// Threads.
    pub threads: Option<u32>,
}

impl Peer {
    /// Everything that its user waits for.
    pub fn waited(&self) -> f64 {
        self.seconds + self.setup_seconds.unwrap_or(0.0)
    }

    /// In a line.
    pub fn about(&self) -> String {
        let mut text = self.peer.clone();
        for part in [&self.variant, &self.sampler].into_iter().flatten() {
            text = format!("{text} {part}");
        }
        let counts = [
            ("samples", self.samples),
            ("threads", self.threads.map(u64::from)),
        ];
        for (name, count) in counts {
            if let Some(count) = count {
                text = format!("{text}, {count} {name}");
            }
        }
        text
    }

    /// Whether it solved the scene of this file.
    pub fn solved(&self, scene: &str) -> bool {
        let stem = |name: &str| Path::new(name).file_stem().map(ToOwned::to_owned);
        stem(&self.scene) == stem(scene)
    }
}

/// What `peers/` writes; what else it says is not for the chart.
#[derive(Deserialize)]
struct File {
    points: Vec<Peer>,
}

/// Reads the points of such a file.
pub fn read(path: &Path) -> Result<Vec<Peer>> {
    let failed = |e: &dyn std::fmt::Display| {
        let message = format!("is not a list of other programs' solves: {e}");
        Error::input(path, "", message)
    };
    let text = file::input(path, "a list of other programs' solves is needed")?;
    let File { points: mut peers } = serde_json::from_slice(&text).map_err(|e| failed(&e))?;
    let sound = |p: &Peer| p.seconds.is_finite() && p.seconds >= 0.0 && p.error >= 0.0;
    for peer in &mut peers {
        for text in [
            Some(&mut peer.peer),
            peer.variant.as_mut(),
            peer.sampler.as_mut(),
        ] {
            text.into_iter().for_each(|text| *text = plain(text));
        }
    }
    match peers.iter().position(|p| !sound(p)) {
        Some(k) => Err(failed(&format!("entry {k} has no seconds or no error"))),
        None => Ok(peers),
    }
}
