//! What has been measured, a line each, so that an interrupted chart goes on where it stopped.

use super::methods::Method;
use super::{Measurement, Solver};
use common::scene::Scene;
use common::texel::outline;
use common::{Error, Result, file};
use serde::{Deserialize, Serialize};
use std::collections::HashMap;
use std::fs::{File, OpenOptions};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::io::Write;
use std::path::{Path, PathBuf};

/// A line of the file.
#[derive(Serialize, Deserialize)]
struct Line {
    key: String,
    /// For people.
    about: String,
    measurement: Measurement,
}

/// The file, and what it held.
pub struct Store {
    path: PathBuf,
    file: File,
    runs: HashMap<String, Vec<Measurement>>,
    /// Lines that could not be read.
    pub damaged: usize,
}

impl Store {
    /// Opens the file or makes it. A damaged line is passed over: it is measured again.
    pub fn open(path: &Path) -> Result<Self> {
        let failed = |source| Error::Write {
            path: path.to_path_buf(),
            source,
        };
        let text = if path.exists() {
            String::from_utf8_lossy(&file::input(path, "remove it to start again")?).into_owned()
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
            match serde_json::from_str::<Line>(line) {
                Ok(line) if line.measurement.is_sound() => store.keep(line.key, line.measurement),
                _ => store.damaged += 1,
            }
        }
        // The next line must not go on where a cut one ends.
        if !text.is_empty() && !text.ends_with('\n') {
            store.file.write_all(b"\n").map_err(failed)?;
        }
        Ok(store)
    }

    /// The measurements of `key`, in the order in which they were made.
    pub fn runs(&self, key: &str) -> &[Measurement] {
        self.runs.get(key).map_or(&[], Vec::as_slice)
    }

    /// Adds one, in the file first.
    pub fn add(&mut self, key: &str, about: &str, measurement: Measurement) -> Result<()> {
        let line = Line {
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
        self.keep(line.key, line.measurement);
        Ok(())
    }

    fn keep(&mut self, key: String, measurement: Measurement) {
        self.runs.entry(key).or_default().push(measurement);
    }
}

/// What makes a measurement another one, beside the method.
pub struct Context {
    /// The scene's content.
    pub scene: u64,
    /// The truth's values.
    pub truth: u64,
    /// The program.
    pub program: u64,
    /// Texels asked for, and seconds after which a solve is given up.
    pub asked: (u32, f64),
    /// The GPU.
    pub adapter: String,
}

impl Context {
    /// The name under which `method`'s measurements are kept.
    pub fn key(&self, method: &Method) -> String {
        let settings = serde_json::to_string(&method.settings).unwrap_or_default();
        let adapter = (method.solver == Solver::Gpu).then_some(&self.adapter);
        let asked = (self.asked.0, self.asked.1.to_bits());
        let error = method.asked.map(f64::to_bits);
        let what = (method.solver, settings, error, adapter);
        let digest = digest(&(self.scene, self.truth, self.program, asked, what));
        format!("{digest:016x}")
    }
}

/// 64 bits of `value`.
pub fn digest(value: &impl Hash) -> u64 {
    let mut hasher = DefaultHasher::new();
    value.hash(&mut hasher);
    hasher.finish()
}

/// What a solve can see of a scene; names do not matter.
pub fn content(scene: &Scene) -> u64 {
    let bits = |v: glam::Vec3| v.to_array().map(f32::to_bits);
    let faces = scene.faces.iter().map(|face| {
        let corners = face.corners.map(|c| c.to_array().map(f64::to_bits));
        // What varies is known by sixteen texels.
        let parts = match face.paint {
            Some(_) => 0..16,
            None => 0..0,
        };
        let parts = parts.map(|k| face.over(outline(face, [4; 2], k).corners()).map(bits));
        let parts: Vec<_> = parts.collect();
        let light = ([bits(face.emission), bits(face.reflectance)], parts);
        (corners, face.outline().len(), light, face.partner)
    });
    digest(&faces.collect::<Vec<_>>())
}

/// This very program: its version, and the file that runs.
pub fn program() -> u64 {
    let path = std::env::current_exe().ok();
    let file = path.and_then(|path| file::read(&path, file::MAX_BYTES).ok());
    digest(&(env!("CARGO_PKG_VERSION"), file.unwrap_or_default()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::chart::Figures;
    use common::settings::{Meshing, Settings};

    fn path(name: &str) -> PathBuf {
        let name = format!("store-{}-{name}.jsonl", std::process::id());
        let path = std::env::temp_dir().join(name);
        let _ = std::fs::remove_file(&path);
        path
    }

    fn measurement(solve: f64) -> Measurement {
        Measurement {
            prepare: 0.25,
            solve,
            result: Ok(Figures {
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
    fn what_was_measured_is_taken_up() {
        let path = path("taken");
        let mut store = Store::open(&path).unwrap();
        let failed = Measurement {
            result: Err("took “too” long".into()),
            ..measurement(60.0)
        };
        store.add("a", "first", measurement(1.5)).unwrap();
        store.add("b", "second", failed.clone()).unwrap();
        store.add("a", "third", measurement(1.0 / 3.0)).unwrap();
        let again = Store::open(&path).unwrap();
        assert_eq!(again.damaged, 0);
        assert_eq!(again.runs("a"), [measurement(1.5), measurement(1.0 / 3.0)]);
        assert_eq!(again.runs("b"), [failed]);
        assert!(again.runs("c").is_empty());
    }

    #[test]
    fn what_is_damaged_is_not_and_what_follows_is() {
        let path = path("damaged");
        let mut store = Store::open(&path).unwrap();
        store.add("a", "whole", measurement(1.5)).unwrap();
        drop(store);
        let whole = std::fs::read_to_string(&path).unwrap();
        let negative = whole.replace("1.5", "-1.5");
        let nothing = whole.replace("0.1", "null");
        let cut = &whole[..whole.len() / 2];
        std::fs::write(&path, format!("{negative}no JSON\n{nothing}{whole}{cut}")).unwrap();
        let mut store = Store::open(&path).unwrap();
        assert_eq!(store.damaged, 4);
        assert_eq!(store.runs("a"), [measurement(1.5)]);
        // Not on the end of the line that was cut.
        store.add("a", "next", measurement(2.0)).unwrap();
        let store = Store::open(&path).unwrap();
        assert_eq!(store.runs("a"), [measurement(1.5), measurement(2.0)]);
    }

    #[test]
    fn anything_else_is_another_measurement() {
        let context = |scene, truth, program, asked, adapter: &str| Context {
            scene,
            truth,
            program,
            asked,
            adapter: adapter.into(),
        };
        let method = |solver, samples| Method {
            asked: None,
            solver,
            sweep: "samples",
            options: String::new(),
            settings: Settings {
                meshing: Meshing {
                    samples,
                    ..Meshing::default()
                },
                ..Settings::default()
            },
        };
        let base = context(1, 2, 3, (16, 60.0), "x");
        let key = base.key(&method(Solver::Gpu, 4));
        let others = [
            context(9, 2, 3, (16, 60.0), "x"),
            context(1, 9, 3, (16, 60.0), "x"),
            context(1, 2, 9, (16, 60.0), "x"),
            context(1, 2, 3, (8, 60.0), "x"),
            context(1, 2, 3, (16, 30.0), "x"),
            context(1, 2, 3, (16, 60.0), "y"),
        ];
        for other in &others {
            assert_ne!(other.key(&method(Solver::Gpu, 4)), key);
        }
        assert_ne!(base.key(&method(Solver::Cpu, 4)), key);
        assert_ne!(base.key(&method(Solver::Gpu, 5)), key);
        assert_eq!(base.key(&method(Solver::Gpu, 4)), key);
        // The CPU does not mind which GPU there is.
        let cpu = method(Solver::Cpu, 4);
        assert_eq!(others[5].key(&cpu), base.key(&cpu));
    }
}
