//! Reading files: the one place where they are opened, since a pipe may never answer and a device
//! may never end.

use crate::error::{Error, Result};
use std::fs::{File, metadata};
use std::io::{ErrorKind, Read};
use std::path::Path;

/// Longer files are refused (2 GiB): nothing that can be solved needs them.
pub const MAX_BYTES: u64 = 1 << 31;

/// Opens an ordinary file of at most `most` bytes.
///
/// Errors: why it cannot be read, in words that follow "cannot be read: ".
pub fn open(path: &Path, most: u64) -> std::result::Result<File, String> {
    // Asked before it is opened: opening a pipe waits for whoever writes into it.
    let data = metadata(path).map_err(|e| reason(&e))?;
    if data.is_dir() {
        return Err("it is a directory".into());
    }
    if !data.is_file() {
        return Err("it is not an ordinary file but a pipe or a device".into());
    }
    if data.len() > most {
        return Err(format!(
            "it has {} bytes, more than the {most} that are read",
            data.len()
        ));
    }
    #[allow(
        clippy::disallowed_methods,
        reason = "the place where files are opened"
    )]
    File::open(path).map_err(|e| reason(&e))
}

/// The bytes of an ordinary file of at most `most` bytes.
///
/// Errors: as of [`open`].
pub fn read(path: &Path, most: u64) -> std::result::Result<Vec<u8>, String> {
    let file = open(path, most)?;
    let mut bytes = Vec::new();
    // The length that the system tells is no promise: it grows, and is 0 in /proc.
    file.take(most + 1)
        .read_to_end(&mut bytes)
        .map_err(|e| reason(&e))?;
    if bytes.len() as u64 > most {
        return Err(format!("it has more than the {most} bytes that are read"));
    }
    Ok(bytes)
}

/// The same with [`MAX_BYTES`], and the error of an input file; `wanted` says what is needed
/// instead, or is empty.
pub fn input(path: &Path, wanted: &str) -> Result<Vec<u8>> {
    read(path, MAX_BYTES).map_err(|reason| {
        let end = if wanted.is_empty() { "" } else { "; " };
        Error::input(path, "", format!("cannot be read: {reason}{end}{wanted}"))
    })
}

/// The system's reason without its number.
fn reason(error: &std::io::Error) -> String {
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
    fn what_is_no_ordinary_file_or_too_long_is_refused() {
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
        // Its length is told as 0.
        #[cfg(target_os = "linux")]
        assert!(read(Path::new("/proc/self/status"), 4).is_err_and(|e| e.contains("more than")));
    }
}
