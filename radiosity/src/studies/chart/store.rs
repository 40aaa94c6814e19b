//! The file `chart.partial.json` of measurements that are done: `chart` reads it first and continues where it was
//! interrupted. A measurement's key hashes all that it depends on, so that another scene, setting or program measures
//! anew.

use crate::studies::hashes::hash_value;
use common::scene::Scene;
use common::solution::pending::locate_file;
use common::solution::write_files;
use common::texel::texel_outline;
use common::{Error, Result, file};
use serde::{Deserialize, Serialize};
use serde_json::json;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Time and outcome of the solves by one method.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Measurement {
    /// Wall-clock seconds of mesh, engine and solve, of the fastest run.
    pub seconds: f64,
    /// Its error, or the reason why it has no solution.
    pub result: std::result::Result<SolveFigures, String>,
}

/// Error of one solve.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SolveFigures {
    /// Relative RMS of its difference to the truth on the chart's texels, the worst channel.
    pub error: f64,
    /// Signed mean of that difference over the truth's mean, of the channel in which it is largest.
    pub bias: f64,
}

/// Name of the file of measurements.
const STORE_NAME: &str = "chart.partial.json";

/// The folder with the file, and the measurements by their keys.
pub struct MeasurementStore {
    dir: PathBuf,
    measurements: BTreeMap<String, Measurement>,
}

impl MeasurementStore {
    /// Reads the file in `dir`; without one the store is empty. Errors: it cannot be read, or is no list of measurements.
    pub fn open(dir: &Path) -> Result<Self> {
        let path = locate_file(dir, STORE_NAME);
        let wanted = "remove it to start again";
        let failed = |e| Error::bad_input(&path, "", format!("is no list of measurements: {e}; {wanted}"));
        Ok(Self {
            dir: dir.to_path_buf(),
            measurements: match path.exists() {
                true => serde_json::from_slice(&file::read_input(&path, wanted)?).map_err(failed)?,
                false => BTreeMap::new(),
            },
        })
    }

    /// Returns the measurement of `key`, if it is done.
    pub fn find_measurement(&self, key: &str) -> Option<&Measurement> {
        self.measurements.get(key)
    }

    /// Adds a measurement and writes the file anew. Errors: it cannot be written.
    pub fn add_measurement(&mut self, key: String, measurement: Measurement) -> Result<()> {
        self.measurements.insert(key, measurement);
        let text = format!("{:#}\n", json!(self.measurements));
        write_files(&self.dir, [(STORE_NAME, text)])
    }
}

/// Returns a hash of the scene's faces. Of paint only the means over 4×4 texels of each painted face count.
pub fn hash_scene(scene: &Scene) -> u64 {
    let mut text = format!("{:?}", scene.faces);
    for face in scene.faces.iter().filter(|face| face.paint.is_some()) {
        for k in 0..16 {
            let means = face.mean_surface(texel_outline(face, [4; 2], k).corners());
            text += &format!("{means:?}");
        }
    }
    hash_value(&text)
}
