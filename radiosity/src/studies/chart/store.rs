//! File of measurements, one JSON line each, so that an interrupted chart can be continued.

use super::methods::{SolveMethod, SolverKind};
use common::scene::Scene;
use common::texel::texel_outline;
use common::{Error, Result, file};
use serde::{Deserialize, Serialize};
use std::collections::HashMap;
use std::fs::{File, OpenOptions};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::io::Write;
use std::path::{Path, PathBuf};

/// Time and error of one solve.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Measurement {
    /// Seconds to build mesh and engine.
    pub prepare: f64,
    /// Seconds of the solve itself.
    pub solve: f64,
    /// The figures, or the reason that there are none.
    pub result: std::result::Result<SolveFigures, String>,
}

/// Error and effort of one solve.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SolveFigures {
    /// Relative RMS error on the texels of the chart, worst channel.
    pub error: f64,
    /// Bias of the channel with the largest one.
    pub bias: f64,
    /// Imbalance of the energy.
    pub imbalance: f64,
    /// Shots, summed over the passes.
    pub shots: u64,
    /// Passes of the iteration.
    pub passes: u32,
}

impl Measurement {
    /// Returns the total wall-clock seconds.
    pub fn total_seconds(&self) -> f64 {
        self.prepare + self.solve
    }

    /// Returns whether all numbers are finite and in range; a damaged record may hold anything.
    pub fn is_sound(&self) -> bool {
        let in_range = |x: &f64| x.is_finite() && *x >= 0.0;
        let figures = self.result.as_ref().map_or(true, |f| {
            in_range(&f.error) && f.bias.is_finite() && f.imbalance.is_finite()
        });
        [self.prepare, self.solve].iter().all(in_range) && figures
    }
}

/// One line of the file.
#[derive(Serialize, Deserialize)]
struct StoredLine {
    key: String,
    /// Scene, solver and options, for human readers.
    about: String,
    measurement: Measurement,
}

/// The file and the measurements in it.
pub struct MeasurementStore {
    path: PathBuf,
    file: File,
    runs: HashMap<String, Vec<Measurement>>,
    /// Number of unreadable lines.
    pub damaged: usize,
}

impl MeasurementStore {
    /// Opens or creates the file. Damaged lines are counted and skipped. Errors: the file cannot be
    /// read or written.
    pub fn open(path: &Path) -> Result<Self> {
        let failed = |source| Error::Write {
            path: path.to_path_buf(),
            source,
        };
        let text = match path.exists() {
            true => String::from_utf8_lossy(&file::read_input(path, "remove it to start again")?).into_owned(),
            false => String::new(),
        };
        let mut file = OpenOptions::new()
            .create(true)
            .append(true)
            .open(path)
            .map_err(failed)?;
        // Terminates an incomplete last line before appending.
        if !text.is_empty() && !text.ends_with('\n') {
            file.write_all(b"\n").map_err(failed)?;
        }
        let mut runs: HashMap<String, Vec<Measurement>> = HashMap::new();
        let mut damaged = 0;
        for line in text.lines().filter(|line| !line.trim().is_empty()) {
            match serde_json::from_str::<StoredLine>(line) {
                Ok(line) if line.measurement.is_sound() => runs.entry(line.key).or_default().push(line.measurement),
                _ => damaged += 1,
            }
        }
        Ok(Self {
            path: path.to_path_buf(),
            file,
            runs,
            damaged,
        })
    }

    /// Returns the measurements of `key` in chronological order.
    pub fn runs_of(&self, key: &str) -> &[Measurement] {
        self.runs.get(key).map_or(&[], Vec::as_slice)
    }

    /// Appends a measurement to the file, then to memory. Errors: the file cannot be written.
    pub fn append_run(&mut self, key: String, about: String, measurement: Measurement) -> Result<()> {
        let line = StoredLine {
            key,
            about,
            measurement,
        };
        let text = serde_json::to_string(&line).map_err(|e| e.into());
        let written = text.and_then(|text| self.file.write_all(format!("{text}\n").as_bytes()));
        written.map_err(|source| Error::Write {
            path: self.path.clone(),
            source,
        })?;
        self.runs.entry(line.key).or_default().push(line.measurement);
        Ok(())
    }
}

/// Everything but the method and its truth that identifies a measurement.
#[derive(Clone, Debug)]
pub struct MeasurementContext {
    /// Hash of the scene.
    pub scene: u64,
    /// Hash of the program.
    pub program: u64,
    /// Texels per side of a face on which errors are measured; none: the common ones of method and truth.
    pub texels: Option<u32>,
    /// Time limit of a solve, seconds.
    pub time_limit: f64,
    /// Name of the GPU.
    pub adapter: Option<String>,
}

impl MeasurementContext {
    /// Returns the key of the measurements of `method` against the truth with this hash.
    pub fn measurement_key(&self, method: &SolveMethod, truth: u64) -> u64 {
        let context = Self {
            adapter: self.adapter.clone().filter(|_| method.solver == SolverKind::Gpu),
            ..self.clone()
        };
        hash_value(&format!(
            "{context:?} {truth} {:?} {:?} {:?}",
            method.solver, method.settings, method.target_error
        ))
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

#[cfg(test)]
mod tests {
    use super::*;
    use common::settings::Settings;
    use std::collections::HashSet;

    fn measurement(solve: f64, result: std::result::Result<f64, String>) -> Measurement {
        Measurement {
            prepare: 0.25,
            solve,
            result: result.map(|error| SolveFigures {
                error,
                bias: -0.01,
                imbalance: 1e-7,
                shots: 1 << 40,
                passes: 6,
            }),
        }
    }

    #[test]
    fn measurements_are_read_back_and_damaged_lines_are_skipped() {
        let path = std::env::temp_dir().join(format!("store-{}.jsonl", std::process::id()));
        let _ = std::fs::remove_file(&path);
        let append = |key: &str, run: &Measurement| {
            let mut store = MeasurementStore::open(&path).unwrap();
            store.append_run(key.into(), "about".into(), run.clone()).unwrap();
        };
        let first = measurement(1.5, Ok(0.1));
        append("a", &first);
        let whole = std::fs::read_to_string(&path).unwrap();
        let negative = whole.replace("1.5", "-1.5");
        let nothing = whole.replace("0.1", "null");
        let cut = &whole[..whole.len() / 2];
        std::fs::write(&path, format!("{negative}no JSON\n{nothing}{whole}{cut}")).unwrap();
        // A new line must not be appended to the incomplete one.
        let others = [
            measurement(1.0 / 3.0, Ok(0.2)),
            measurement(60.0, Err("took “too” long".into())),
        ];
        append("a", &others[0]);
        append("b", &others[1]);
        let store = MeasurementStore::open(&path).unwrap();
        assert_eq!(store.damaged, 4);
        assert_eq!(store.runs_of("a"), [first, others[0].clone()]);
        assert_eq!(store.runs_of("b"), &others[1..]);
        assert!(store.runs_of("c").is_empty());
    }

    #[test]
    fn every_part_of_context_and_method_changes_the_key() {
        let key_of = |change: fn(&mut MeasurementContext, &mut SolveMethod)| {
            let mut context = MeasurementContext {
                scene: 1,
                program: 3,
                texels: Some(16),
                time_limit: 60.0,
                adapter: Some("x".into()),
            };
            let mut method = SolveMethod::new(SolverKind::Gpu, "", Settings::default());
            change(&mut context, &mut method);
            context.measurement_key(&method, method.truth as u64)
        };
        let changes: [fn(&mut MeasurementContext, &mut SolveMethod); 10] = [
            |_, _| (),
            |context, _| context.scene = 9,
            |context, _| context.program = 9,
            |context, _| context.texels = Some(8),
            |context, _| context.time_limit = 30.0,
            |context, _| context.adapter = Some("y".into()),
            |_, method| method.solver = SolverKind::Cpu,
            |_, method| method.settings.meshing.samples = 5,
            |_, method| method.target_error = Some(0.01),
            |_, method| method.truth = 9,
        ];
        let keys: HashSet<u64> = changes.into_iter().map(key_of).collect();
        assert_eq!(keys.len(), changes.len());
        // The GPU's name is no part of a CPU key, and words are of none.
        let on_cpu = key_of(|context, method| {
            (context.adapter, method.solver, method.options) = (None, SolverKind::Cpu, "words".into());
        });
        assert!(keys.contains(&on_cpu));
    }
}
