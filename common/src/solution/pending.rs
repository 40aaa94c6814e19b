//! Files that appear together or not at all: written under temporary names, and renamed when all of them
//! are complete.

use crate::error::{Error, Result};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};

/// Files under temporary names. Files that are not [renamed](PendingFiles::rename_files) are removed on drop.
#[derive(Default)]
pub struct PendingFiles {
    /// Temporary name and final name of each file.
    files: Vec<(PathBuf, PathBuf)>,
}

impl PendingFiles {
    /// Writes `bytes` under a temporary name in the directory of `path`.
    ///
    /// Errors: [`Error::Write`] with `path`.
    pub fn add(&mut self, path: &Path, bytes: &[u8]) -> Result<()> {
        let temporary = temporary_path(path);
        self.files.push((temporary.clone(), path.to_path_buf()));
        fs::write(&temporary, bytes).map_err(|source| write_error(path, source))
    }

    /// Renames all files to their final names, in the order in which they were added.
    ///
    /// Errors: [`Error::Write`] with the file; the files before it have been renamed.
    pub fn rename_files(mut self) -> Result<()> {
        while !self.files.is_empty() {
            let (temporary, path) = &self.files[0];
            fs::rename(temporary, path).map_err(|source| write_error(path, source))?;
            self.files.remove(0);
        }
        Ok(())
    }
}

impl Drop for PendingFiles {
    fn drop(&mut self) {
        for (temporary, _) in &self.files {
            // A half-written file must not remain; the first error is reported.
            let _ = fs::remove_file(temporary);
        }
    }
}

/// Returns a temporary name beside `path` that is unique among processes and within this one.
pub(crate) fn temporary_path(path: &Path) -> PathBuf {
    static COUNT: AtomicU32 = AtomicU32::new(0);
    let number = COUNT.fetch_add(1, Ordering::Relaxed);
    let mut name = path.as_os_str().to_owned();
    name.push(format!(".{}-{number}.part", std::process::id()));
    name.into()
}

fn write_error(path: &Path, source: std::io::Error) -> Error {
    Error::Write {
        path: path.to_path_buf(),
        source,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_appear_together_or_not_at_all() {
        let dir = std::env::temp_dir().join(format!("radiosity-pending-{}", std::process::id()));
        fs::create_dir_all(&dir).unwrap();
        let [a, b] = ["a", "b"].map(|name| dir.join(name));
        let mut pending = PendingFiles::default();
        pending.add(&a, b"new").unwrap();
        // A file that is written must not appear if a later one fails.
        assert!(pending.add(&dir.join("none/b"), b"new").is_err());
        drop(pending);
        assert_eq!(fs::read_dir(&dir).unwrap().count(), 0);
        let mut pending = PendingFiles::default();
        pending.add(&a, b"new").unwrap();
        pending.add(&b, b"new").unwrap();
        assert!(!a.exists() && !b.exists());
        pending.rename_files().unwrap();
        assert_eq!(fs::read_dir(&dir).unwrap().count(), 2);
        assert_eq!(fs::read(&b).unwrap(), b"new");
        fs::remove_dir_all(dir).unwrap();
    }

    #[test]
    fn temporary_names_of_one_file_differ() {
        let path = Path::new("out/lightmap.exr");
        assert_ne!(temporary_path(path), temporary_path(path));
        let name = temporary_path(path);
        let name = name.to_str().unwrap();
        assert!(name.contains(&std::process::id().to_string()), "{name}");
    }
}
