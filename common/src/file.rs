//! Reading of files. All files are opened here: a pipe may never answer, and a device may never end.

use crate::error::{Error, Result};
use std::collections::BTreeMap;
use std::fs::{File, canonicalize, metadata};
use std::io::{ErrorKind, Read};
use std::path::{Component, Path, PathBuf, absolute};
use std::sync::{Mutex, PoisonError};

/// Maximum bytes of an input file (2 GiB).
pub const MAX_FILE_BYTES: u64 = 1 << 31;

/// Files that this process has read, as given, by resolved path: no output may replace them.
static INPUTS: Mutex<BTreeMap<PathBuf, PathBuf>> = Mutex::new(BTreeMap::new());

/// Files in memory, by the path that their readers give.
static MEMORY_FILES: Mutex<BTreeMap<PathBuf, Vec<u8>>> = Mutex::new(BTreeMap::new());

/// Keeps a file in memory, which [`read`] finds before those of the file system: a page in a browser has no other. The content
/// takes the place of an earlier one; `None` removes it.
pub fn keep_in_memory(path: &Path, content: Option<Vec<u8>>) {
    let mut files = MEMORY_FILES.lock().unwrap_or_else(PoisonError::into_inner);
    match content {
        Some(content) => files.insert(path.to_path_buf(), content),
        None => files.remove(path),
    };
}

/// Returns the path, as it was given, of a file that was [`read`], by its [resolved path](resolve_path).
pub fn find_input(resolved: &Path) -> Option<PathBuf> {
    let inputs = INPUTS.lock().unwrap_or_else(PoisonError::into_inner);
    inputs.get(resolved).cloned()
}

/// Returns the absolute path without links, `.` and `..`. The end of the path need not exist.
pub fn resolve_path(path: &Path) -> PathBuf {
    if let Ok(resolved) = canonicalize(path) {
        return resolved;
    }
    let path = absolute(path).unwrap_or_else(|_| path.to_path_buf());
    match (path.parent(), path.file_name()) {
        (Some(folder), Some(name)) => resolve_path(folder).join(name),
        (Some(folder), None) => resolve_path(folder).parent().map_or(path.clone(), Path::to_path_buf),
        (None, _) => path,
    }
}

/// Returns the path of the file that a scene in `folder` names relative to `base`, a folder of the scene's.
///
/// Errors: it is neither beside the scene nor below it; in words that follow "cannot be read: ".
pub fn path_below(folder: &Path, base: &Path, name: &str) -> std::result::Result<PathBuf, String> {
    let path = base.join(name);
    let mut parts = path.strip_prefix(folder).unwrap_or(&path).components();
    let depth = parts.try_fold(0_usize, |depth, part| match part {
        Component::Normal(_) => Some(depth + 1),
        Component::CurDir => Some(depth),
        Component::ParentDir => depth.checked_sub(1),
        Component::RootDir | Component::Prefix(_) => None,
    });
    let elsewhere = || "only files beside the scene or below it are read".to_owned();
    depth.map(|_| path.clone()).ok_or_else(elsewhere)
}

/// Returns the CRC-32 (ISO 3309) of a file in eight hexadecimal digits.
pub fn file_checksum(bytes: &[u8]) -> String {
    format!("{:08x}", crc32fast::hash(bytes))
}

/// Opens an ordinary file of at most `max_bytes`.
///
/// Errors: the reason, in words that follow "cannot be read: ".
pub fn open_file(path: &Path, max_bytes: u64) -> std::result::Result<File, String> {
    // Checked before the file is opened: opening a pipe waits for its writer.
    let data = metadata(path).map_err(|e| error_reason(&e))?;
    if data.is_dir() {
        return Err("it is a directory".into());
    }
    if !data.is_file() {
        return Err("it is not an ordinary file but a pipe or a device".into());
    }
    if data.len() > max_bytes {
        return Err(format!(
            "it has {} bytes, more than the {max_bytes} that are read",
            data.len()
        ));
    }
    #[allow(clippy::disallowed_methods, reason = "the place where files are opened")]
    File::open(path).map_err(|e| error_reason(&e))
}

/// Reads an input: an ordinary file of at most `max_bytes`, which no output may replace.
///
/// Errors: as of [`open_file`].
pub fn read(path: &Path, max_bytes: u64) -> std::result::Result<Vec<u8>, String> {
    let bytes = read_unrecorded(path, max_bytes)?;
    let mut inputs = INPUTS.lock().unwrap_or_else(PoisonError::into_inner);
    inputs.insert(resolve_path(path), path.to_path_buf());
    Ok(bytes)
}

/// Reads an ordinary file of at most `max_bytes` that is no input.
///
/// Errors: as of [`open_file`].
pub fn read_unrecorded(path: &Path, max_bytes: u64) -> std::result::Result<Vec<u8>, String> {
    let kept = MEMORY_FILES
        .lock()
        .unwrap_or_else(PoisonError::into_inner)
        .get(path)
        .cloned();
    if let Some(bytes) = kept {
        return Ok(bytes);
    }
    let file = open_file(path, max_bytes)?;
    let mut bytes = Vec::new();
    // The file may be longer than its metadata say: it may grow, and in /proc the length is 0.
    file.take(max_bytes + 1)
        .read_to_end(&mut bytes)
        .map_err(|e| error_reason(&e))?;
    if bytes.len() as u64 > max_bytes {
        return Err(format!("it has more than the {max_bytes} bytes that are read"));
    }
    Ok(bytes)
}

/// Reads an input file of at most [`MAX_FILE_BYTES`].
///
/// Errors: [`Error::Input`]; its message ends with `wanted`, the file that is needed instead, unless empty.
pub fn read_input(path: &Path, wanted: &str) -> Result<Vec<u8>> {
    read(path, MAX_FILE_BYTES).map_err(|reason| {
        let end = if wanted.is_empty() { "" } else { "; " };
        Error::bad_input(path, "", format!("cannot be read: {reason}{end}{wanted}"))
    })
}

/// Returns the system's reason without its error number.
fn error_reason(error: &std::io::Error) -> String {
    match error.kind() {
        ErrorKind::NotFound => "there is no such file".into(),
        ErrorKind::PermissionDenied => "permission denied".into(),
        _ => error.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directory_device_and_long_file_are_errors() {
        let name = format!("radiosity-file-{}", std::process::id());
        let path = std::env::temp_dir().join(name);
        std::fs::write(&path, b"four").unwrap();
        assert_eq!(read(&path, 4).as_deref(), Ok(&b"four"[..]));
        assert!(read(&path, 3).is_err_and(|e| e.contains("4 bytes")));
        std::fs::remove_file(&path).unwrap();
        assert!(read(&path, 4).is_err_and(|e| e.contains("no such file")));
        assert!(read(&std::env::temp_dir(), 4).is_err_and(|e| e.contains("directory")));
        #[cfg(unix)]
        assert!(read(Path::new("/dev/zero"), 4).is_err_and(|e| e.contains("device")));
        // The length in its metadata is 0.
        #[cfg(target_os = "linux")]
        assert!(read(Path::new("/proc/self/status"), 4).is_err_and(|e| e.contains("more than")));
    }
}
