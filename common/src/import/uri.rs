//! URIs of a glTF: data, or files beside the scene.

use crate::file::{self, MAX_FILE_BYTES};
use base64::Engine;
use base64::engine::general_purpose::STANDARD_NO_PAD;
use std::path::Path;

/// Reads the bytes of a URI: a `data:` URI, or a file relative to the scene.
///
/// Errors: the URI is invalid or remote, or the file cannot be read.
pub fn read_uri(scene: &Path, uri: &str) -> Result<Vec<u8>, String> {
    if let Some(data) = uri.strip_prefix("data:") {
        let (kind, data) = data.split_once(',').ok_or("has a data URI without data")?;
        let base64 = kind.ends_with(";base64").then_some(data.trim_end_matches('='));
        let bytes = base64.and_then(|text| STANDARD_NO_PAD.decode(text).ok());
        return bytes.ok_or_else(|| "has a data URI that is not base64".into());
    }
    if uri.contains("://") {
        return Err(format!("is at {uri}: only files beside the scene or below it are read"));
    }
    let name = decode_percent(uri).ok_or_else(|| format!("has an invalid uri {uri}"))?;
    let folder = scene.parent().unwrap_or(Path::new(""));
    let bytes = file::path_below(folder, folder, &name).and_then(|path| file::read(&path, MAX_FILE_BYTES));
    bytes.map_err(|reason| format!("{name} cannot be read: {reason}"))
}

/// Decodes percent-encoding (RFC 3986 §2.1).
fn decode_percent(uri: &str) -> Option<String> {
    let mut parts = uri.split('%');
    let mut bytes = parts.next()?.as_bytes().to_vec();
    for part in parts {
        bytes.push(u8::from_str_radix(part.get(..2)?, 16).ok()?);
        bytes.extend_from_slice(&part.as_bytes()[2..]);
    }
    String::from_utf8(bytes).ok()
}
