//! Reading of files. All files are opened here: a pipe may never answer, and a device may never end.

use crate::error::{Error, Result};
use std::fs::{File, metadata};
use std::io::{ErrorKind, Read};
use std::path::Path;

/// Maximum bytes of an input file (2 GiB).
pub const MAX_FILE_BYTES: u64 = 1 << 31;

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

/// Reads an ordinary file of at most `max_bytes`.
///
/// Errors: as of [`open_file`].
pub fn read(path: &Path, max_bytes: u64) -> std::result::Result<Vec<u8>, String> {
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
