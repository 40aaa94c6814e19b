//! Files that appear together or not at all: written under names of their own first, and renamed
//! when every one of them is whole.

use crate::error::{Error, Result};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};

/// Files on their way. Those that are not [renamed](Pending::finish) are removed again.
#[derive(Default)]
pub struct Pending {
    /// The temporary name, and the name to be.
    files: Vec<(PathBuf, PathBuf)>,
}

impl Pending {
    /// Writes `bytes` beside `path`.
    ///
    /// Errors: [`Error::Write`] with `path`.
    pub fn add(&mut self, path: &Path, bytes: &[u8]) -> Result<()> {
        let temporary = temporary(path);
        self.files.push((temporary.clone(), path.to_path_buf()));
        fs::write(&temporary, bytes).map_err(|source| fail(path, source))
    }

    /// Gives all files their names, in the order in which they were added.
    ///
    /// Errors: [`Error::Write`] with the file; those before it have their names by then.
    pub fn finish(mut self) -> Result<()> {
        while !self.files.is_empty() {
            let (temporary, path) = &self.files[0];
            fs::rename(temporary, path).map_err(|source| fail(path, source))?;
            self.files.remove(0);
        }
        Ok(())
    }
}

impl Drop for Pending {
    fn drop(&mut self) {
        for (temporary, _) in &self.files {
            // A half-written file must not stay; the first error is the one to report.
            let _ = fs::remove_file(temporary);
        }
    }
}

/// A name that no other process, and nothing else in this one, writes to.
pub(crate) fn temporary(path: &Path) -> PathBuf {
    static COUNT: AtomicU32 = AtomicU32::new(0);
    let number = COUNT.fetch_add(1, Ordering::Relaxed);
    let mut name = path.as_os_str().to_owned();
    name.push(format!(".{}-{number}.part", std::process::id()));
    name.into()
}

fn fail(path: &Path, source: std::io::Error) -> Error {
    Error::Write {
        path: path.to_path_buf(),
        source,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_files_or_none() {
        let dir = std::env::temp_dir().join(format!("radiosity-pending-{}", std::process::id()));
        fs::create_dir_all(&dir).unwrap();
        let [a, b] = ["a", "b"].map(|name| dir.join(name));
        let mut pending = Pending::default();
        pending.add(&a, b"new").unwrap();
        // What is written already must not appear when a later file fails.
        assert!(pending.add(&dir.join("none/b"), b"new").is_err());
        drop(pending);
        assert_eq!(fs::read_dir(&dir).unwrap().count(), 0);
        let mut pending = Pending::default();
        pending.add(&a, b"new").unwrap();
        pending.add(&b, b"new").unwrap();
        assert!(!a.exists() && !b.exists());
        pending.finish().unwrap();
        assert_eq!(fs::read_dir(&dir).unwrap().count(), 2);
        assert_eq!(fs::read(&b).unwrap(), b"new");
        fs::remove_dir_all(dir).unwrap();
    }

    #[test]
    fn two_writers_of_one_file_have_two_names() {
        let path = Path::new("out/lightmap.exr");
        assert_ne!(temporary(path), temporary(path));
        let name = temporary(path);
        let name = name.to_str().unwrap();
        assert!(name.contains(&std::process::id().to_string()), "{name}");
    }
}
