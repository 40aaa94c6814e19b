//! File of measurements, one JSON line each, so that an interrupted chart can be continued.

use super::{Measurement, SolverKind};
use common::scene::Scene;
use common::settings::Settings;
use common::texel::texel_outline;
use common::{Error, Result, file};
use gpu::Gpu;
use serde::{Deserialize, Serialize};
use std::collections::HashMap;
use std::fs::{File, OpenOptions};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::io::Write;
use std::path::{Path, PathBuf};

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
        let text = if path.exists() {
            String::from_utf8_lossy(&file::read_input(path, "remove it to start again")?).into_owned()
        } else {
            String::new()
        };
        let file = OpenOptions::new().create(true).append(true).open(path);
        let mut store = Self {
            path: path.to_path_buf(),
            file: file.map_err(failed)?,
            runs: HashMap::new(),
            damaged: 0,
        };
        for line in text.lines().filter(|line| !line.trim().is_empty()) {
            match serde_json::from_str::<StoredLine>(line) {
                Ok(line) if line.measurement.is_sound() => store.insert_run(line.key, line.measurement),
                _ => store.damaged += 1,
            }
        }
        // Terminate an incomplete last line before appending.
        if !text.is_empty() && !text.ends_with('\n') {
            store.file.write_all(b"\n").map_err(failed)?;
        }
        Ok(store)
    }

    /// Returns the measurements of `key` in chronological order.
    pub fn runs_of(&self, key: &str) -> &[Measurement] {
        self.runs.get(key).map_or(&[], Vec::as_slice)
    }

    /// Appends a measurement to the file, then to memory. Errors: the file cannot be written.
    pub fn append_run(&mut self, key: &str, about: &str, measurement: Measurement) -> Result<()> {
        let line = StoredLine {
            key: key.to_owned(),
            about: about.to_owned(),
            measurement,
        };
        let text = serde_json::to_string(&line).map_err(|e| e.into());
        let written = text.and_then(|text| self.file.write_all(format!("{text}\n").as_bytes()));
        written.map_err(|source| Error::Write {
            path: self.path.clone(),
            source,
        })?;
        self.insert_run(line.key, line.measurement);
        Ok(())
    }

    fn insert_run(&mut self, key: String, measurement: Measurement) {
        self.runs.entry(key).or_default().push(measurement);
    }
}

/// Everything but the method that identifies a measurement.
#[derive(Clone)]
pub struct MeasurementContext {
    /// Hash of the scene.
    pub scene: u64,
    /// Hash of the truth's values.
    pub truth: u64,
    /// Hash of the program.
    pub program: u64,
    /// Requested texels per side, and time limit of a solve in seconds.
    pub texels_and_limit: (u32, f64),
    /// Name of the GPU.
    pub adapter: String,
}

impl MeasurementContext {
    /// Returns the context of this program's measurements of `scene`; the truth's hash is still 0.
    pub fn new(scene: &Scene, gpu: Option<&Gpu>, texels_and_limit: (u32, f64)) -> Self {
        Self {
            scene: hash_scene(scene),
            truth: 0,
            program: hash_program(),
            texels_and_limit,
            adapter: gpu.map_or(String::new(), |gpu| gpu.line.name.clone()),
        }
    }

    /// Returns the key of a method's measurements.
    pub fn measurement_key(&self, solver: SolverKind, settings: &Settings, target_error: Option<f64>) -> String {
        let settings = serde_json::to_string(settings).unwrap_or_default();
        let adapter = (solver == SolverKind::Gpu).then_some(&self.adapter);
        let texels_and_limit = (self.texels_and_limit.0, self.texels_and_limit.1.to_bits());
        let method = (solver, settings, target_error.map(f64::to_bits), adapter);
        let context = (self.scene, self.truth, self.program, texels_and_limit);
        format!("{:016x}", hash_value(&(context, method)))
    }
}

/// Returns a 64-bit hash of `value`.
pub fn hash_value(value: &impl Hash) -> u64 {
    let mut hasher = DefaultHasher::new();
    value.hash(&mut hasher);
    hasher.finish()
}

/// Returns a hash of everything in a scene that affects a solve; names do not.
pub fn hash_scene(scene: &Scene) -> u64 {
    let bits = |v: glam::Vec3| v.to_array().map(f32::to_bits);
    let faces = scene.faces.iter().map(|face| {
        let corners = face.corners.map(|c| c.to_array().map(f64::to_bits));
        // A painted face is identified by its means over sixteen texels.
        let parts = match face.paint {
            Some(_) => 0..16,
            None => 0..0,
        };
        let parts = parts.map(|k| face.mean_surface(texel_outline(face, [4; 2], k).corners()).map(bits));
        let parts: Vec<_> = parts.collect();
        let light = ([bits(face.emission), bits(face.reflectance)], parts);
        (corners, face.outline().len(), light, face.partner)
    });
    hash_value(&faces.collect::<Vec<_>>())
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
    use crate::studies::chart::SolveFigures;

    fn temporary_path(name: &str) -> PathBuf {
        let name = format!("store-{}-{name}.jsonl", std::process::id());
        let path = std::env::temp_dir().join(name);
        let _ = std::fs::remove_file(&path);
        path
    }

    fn measurement(solve: f64) -> Measurement {
        Measurement {
            prepare: 0.25,
            solve,
            result: Ok(SolveFigures {
                error: 0.1,
                own_error: 0.05,
                bias: -0.01,
                imbalance: 1e-7,
                unshot: 1e-3,
                shots: 1 << 40,
                passes: 6,
                linked: 12,
                one_by_one: false,
            }),
        }
    }

    #[test]
    fn measurements_are_read_back() {
        let path = temporary_path("taken");
        let mut store = MeasurementStore::open(&path).unwrap();
        let failed = Measurement {
            result: Err("took “too” long".into()),
            ..measurement(60.0)
        };
        store.append_run("a", "first", measurement(1.5)).unwrap();
        store.append_run("b", "second", failed.clone()).unwrap();
        store.append_run("a", "third", measurement(1.0 / 3.0)).unwrap();
        let again = MeasurementStore::open(&path).unwrap();
        assert_eq!(again.damaged, 0);
        assert_eq!(again.runs_of("a"), [measurement(1.5), measurement(1.0 / 3.0)]);
        assert_eq!(again.runs_of("b"), [failed]);
        assert!(again.runs_of("c").is_empty());
    }

    #[test]
    fn damaged_lines_are_skipped_and_later_lines_are_read() {
        let path = temporary_path("damaged");
        let mut store = MeasurementStore::open(&path).unwrap();
        store.append_run("a", "whole", measurement(1.5)).unwrap();
        drop(store);
        let whole = std::fs::read_to_string(&path).unwrap();
        let negative = whole.replace("1.5", "-1.5");
        let nothing = whole.replace("0.1", "null");
        let cut = &whole[..whole.len() / 2];
        std::fs::write(&path, format!("{negative}no JSON\n{nothing}{whole}{cut}")).unwrap();
        let mut store = MeasurementStore::open(&path).unwrap();
        assert_eq!(store.damaged, 4);
        assert_eq!(store.runs_of("a"), [measurement(1.5)]);
        // The new line must not be appended to the incomplete one.
        store.append_run("a", "next", measurement(2.0)).unwrap();
        let store = MeasurementStore::open(&path).unwrap();
        assert_eq!(store.runs_of("a"), [measurement(1.5), measurement(2.0)]);
    }

    #[test]
    fn every_part_of_the_context_changes_the_key() {
        let context = |scene, truth, program, asked, adapter: &str| MeasurementContext {
            scene,
            truth,
            program,
            texels_and_limit: asked,
            adapter: adapter.into(),
        };
        let key_of = |context: &MeasurementContext, solver, samples| {
            let mut settings = Settings::default();
            settings.meshing.samples = samples;
            context.measurement_key(solver, &settings, None)
        };
        let base = context(1, 2, 3, (16, 60.0), "x");
        let key = key_of(&base, SolverKind::Gpu, 4);
        let others = [
            context(9, 2, 3, (16, 60.0), "x"),
            context(1, 9, 3, (16, 60.0), "x"),
            context(1, 2, 9, (16, 60.0), "x"),
            context(1, 2, 3, (8, 60.0), "x"),
            context(1, 2, 3, (16, 30.0), "x"),
            context(1, 2, 3, (16, 60.0), "y"),
        ];
        for other in &others {
            assert_ne!(key_of(other, SolverKind::Gpu, 4), key);
        }
        assert_ne!(key_of(&base, SolverKind::Cpu, 4), key);
        assert_ne!(key_of(&base, SolverKind::Gpu, 5), key);
        let to_error = |error| {
            let settings = Settings::default();
            base.measurement_key(SolverKind::Gpu, &settings, error)
        };
        assert_ne!(to_error(Some(0.01)), to_error(None));
        assert_eq!(key_of(&base, SolverKind::Gpu, 4), key);
        // The GPU's name is no part of a CPU key.
        let cpu_key = |context| key_of(context, SolverKind::Cpu, 4);
        assert_eq!(cpu_key(&others[5]), cpu_key(&base));
    }
}
