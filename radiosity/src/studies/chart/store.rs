//! File of measurements, so that an interrupted chart can be continued.

use common::scene::Scene;
use common::solution::write_file;
use common::texel::texel_outline;
use common::{Error, Result, file};
use serde::{Deserialize, Serialize};
use serde_json::json;
use std::collections::BTreeMap;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};

/// Time and error of one solve.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Measurement {
    /// Wall-clock seconds of mesh, engine and solve.
    pub seconds: f64,
    /// The figures, or the reason that there are none.
    pub result: std::result::Result<SolveFigures, String>,
}

/// Error of one solve.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SolveFigures {
    /// Relative RMS error on the texels of the chart, worst channel.
    pub error: f64,
    /// Bias of the channel with the largest one.
    pub bias: f64,
}

/// The file and the measurements in it.
pub struct MeasurementStore {
    path: PathBuf,
    measurements: BTreeMap<String, Measurement>,
}

impl MeasurementStore {
    /// Reads the file, if it exists. Errors: it cannot be read, or holds something else.
    pub fn open(path: &Path) -> Result<Self> {
        let wanted = "remove it to start again";
        let failed = |e| Error::bad_input(path, "", format!("is no list of measurements: {e}; {wanted}"));
        Ok(Self {
            path: path.to_path_buf(),
            measurements: match path.exists() {
                true => serde_json::from_slice(&file::read_input(path, wanted)?).map_err(failed)?,
                false => BTreeMap::new(),
            },
        })
    }

    /// Returns the measurement of `key`.
    pub fn find_measurement(&self, key: &str) -> Option<&Measurement> {
        self.measurements.get(key)
    }

    /// Adds a measurement to the file. Errors: it cannot be written.
    pub fn add_measurement(&mut self, key: String, measurement: Measurement) -> Result<()> {
        self.measurements.insert(key, measurement);
        write_file(&self.path, format!("{:#}\n", json!(self.measurements)).as_bytes())
    }
}

/// Returns a 64-bit hash of `value`.
pub fn hash_value(value: &impl Hash) -> u64 {
    let mut hasher = DefaultHasher::new();
    value.hash(&mut hasher);
    hasher.finish()
}

/// Returns a hash of the faces; a painted face is identified by its means over sixteen texels.
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

/// Returns a hash of this program: its version and its executable file.
pub fn hash_program() -> u64 {
    let path = std::env::current_exe().ok();
    let file = path.and_then(|path| file::read(&path, file::MAX_FILE_BYTES).ok());
    hash_value(&(env!("CARGO_PKG_VERSION"), file.unwrap_or_default()))
}
