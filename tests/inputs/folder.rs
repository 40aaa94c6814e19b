//! Temporary folders for readers that take a path. `TMPDIR=/dev/shm` keeps them in memory.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};
use std::{env, fs, process};

/// A temporary folder, removed with its contents when dropped.
pub struct Folder(PathBuf);

impl Folder {
    /// Creates a folder with these files.
    pub fn new(files: &[(&str, &[u8])]) -> Self {
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let number = COUNT.fetch_add(1, Ordering::Relaxed);
        let path = env::temp_dir().join(format!("radiosity-inputs-{}-{number}", process::id()));
        fs::create_dir_all(&path).expect("a temporary folder");
        let folder = Self(path);
        for (name, bytes) in files {
            folder.write(name, bytes);
        }
        folder
    }

    /// Writes a file, in a folder within if `name` says so.
    pub fn write(&self, name: &str, bytes: &[u8]) {
        let path = self.path(name);
        if fs::write(&path, bytes).is_err() {
            fs::create_dir_all(path.parent().expect("a folder")).expect("a folder within");
            fs::write(&path, bytes).expect("a temporary file");
        }
    }

    /// Returns the path of a file in the folder.
    pub fn path(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }
}

impl AsRef<Path> for Folder {
    fn as_ref(&self) -> &Path {
        &self.0
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}
