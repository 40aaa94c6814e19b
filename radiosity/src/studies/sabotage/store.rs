//! Verdicts of earlier runs, a line of JSON each.

use super::JudgedMutant;
use common::file::read_input;
use common::{Error, Result};
use std::collections::HashMap;
use std::fs::OpenOptions;
use std::io::Write;
use std::path::{Path, PathBuf};

/// The file of verdicts in a folder of results.
pub struct VerdictStore(PathBuf);

impl VerdictStore {
    /// Returns the file in `folder`.
    pub fn new(folder: &Path) -> Self {
        Self(folder.join("mutants.jsonl"))
    }

    /// Reads the verdicts by their mutants' keys. A line that was cut is no verdict.
    ///
    /// Errors: the file is there and cannot be read.
    pub fn read(&self) -> Result<HashMap<String, JudgedMutant>> {
        if !self.0.exists() {
            return Ok(HashMap::new());
        }
        let bytes = read_input(&self.0, "")?;
        let text = String::from_utf8_lossy(&bytes);
        let verdicts = text
            .lines()
            .filter_map(|line| serde_json::from_str::<JudgedMutant>(line).ok());
        Ok(verdicts.map(|judged| (judged.key.clone(), judged)).collect())
    }

    /// Appends a verdict.
    ///
    /// Errors: [`Error::Write`].
    pub fn append(&self, judged: &JudgedMutant) -> Result<()> {
        let text = serde_json::to_string(judged).map_err(|error| Error::Fault(error.to_string()))?;
        let open = OpenOptions::new().create(true).append(true).open(&self.0);
        // The line break comes first: a line that was cut ends there.
        let written = open.and_then(|mut file| file.write_all(format!("\n{text}").as_bytes()));
        written.map_err(|source| Error::Write {
            path: self.0.clone(),
            source,
        })
    }
}
