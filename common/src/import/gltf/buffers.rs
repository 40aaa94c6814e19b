//! The bytes of a glTF file: GLB chunks, `data:` URIs and files beside it.

use super::indices::{indices, version};
use crate::error::{Error, Result};
use crate::file::{self, MAX_BYTES};
use gltf::binary::Glb;
use gltf::json::{Root, deserialize};
use serde_json::Value;
use std::path::Path;

/// A document and its buffers.
pub struct Document {
    /// As written, nothing checked yet.
    pub root: Root,
    /// At least as long as the document says.
    pub buffers: Vec<Vec<u8>>,
}

impl Document {
    /// Parses the JSON and gathers the buffers.
    pub fn read(path: &Path, bytes: &[u8]) -> Result<Self> {
        let fail = |message: String| Error::input(path, "", message);
        let bytes = match bytes.starts_with(b"glTF") {
            true => container(bytes).map_err(fail)?,
            false => bytes.strip_prefix(crate::import::BOM).unwrap_or(bytes),
        };
        let (root, blob) = parse(bytes).map_err(fail)?;
        let required = &root.extensions_required;
        if let Some(name) = required
            .iter()
            .find(|name| !SUPPORTED.contains(&name.as_str()))
        {
            return Err(fail(format!(
                "requires the extension {name}, which is not supported: {}",
                instead(name)
            )));
        }
        let mut blob = blob;
        let buffers = root
            .buffers
            .iter()
            .enumerate()
            .map(|(k, buffer)| {
                let bytes = match buffer.uri.as_deref() {
                    Some(uri) => fetch(path, uri),
                    None if k == 0 => blob.take().ok_or_else(|| "has no binary chunk".into()),
                    None => Err("has no uri".into()),
                };
                let wanted = buffer.byte_length.0;
                match bytes {
                    Ok(bytes) if (bytes.len() as u64) < wanted => Err(format!(
                        "has {} of its {wanted} bytes: is the file cut off?",
                        bytes.len()
                    )),
                    other => other,
                }
                .map_err(|message| Error::input(path, format!("buffer {k}"), message))
            })
            .collect::<Result<_>>()?;
        Ok(Self { root, buffers })
    }
}

/// The document and the binary chunk.
fn parse(bytes: &[u8]) -> std::result::Result<(Root, Option<Vec<u8>>), String> {
    let invalid = |e: &dyn std::fmt::Display| format!("is not valid glTF 2.0: {e}");
    let (text, blob) = if bytes.starts_with(b"glTF") {
        let Glb { json, bin, .. } = Glb::from_slice(bytes).map_err(|e| invalid(&e))?;
        (json, bin)
    } else {
        (bytes.into(), None)
    };
    let document: Value = serde_json::from_slice(&text).map_err(|e| invalid(&e))?;
    version(&document)?;
    indices(&document)?;
    // The crate's own validation panics on some indices; ours comes with each access.
    let root: Root = deserialize::from_slice(&text).map_err(|e| invalid(&e))?;
    Ok((root, blob.map(Into::into)))
}

/// Extensions that a file may require.
const SUPPORTED: [&str; 5] = [
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_materials_unlit",
    "KHR_mesh_quantization",
    "KHR_texture_transform",
];

/// What a file can do without and uses all the same, as far as it is not read.
pub fn unread(root: &Root) -> Vec<&str> {
    let used = root.extensions_used.iter().map(String::as_str);
    used.filter(|name| !SUPPORTED.contains(name)).collect()
}

/// How to do without an extension.
fn instead(extension: &str) -> &'static str {
    match extension {
        "KHR_draco_mesh_compression" => {
            "export without Draco (Blender's glTF exporter: Compression off)"
        }
        "EXT_meshopt_compression" | "KHR_meshopt_compression" => {
            "export without meshopt (gltfpack: neither -c nor -cc)"
        }
        "KHR_texture_basisu" | "EXT_texture_webp" | "EXT_texture_avif" => {
            "export with textures in PNG or JPEG"
        }
        _ => "export without it",
    }
}

/// A GLB without what may follow it, its header checked (the crate subtracts unchecked).
fn container(bytes: &[u8]) -> std::result::Result<&[u8], String> {
    let word = |at: usize| Some(u32::from_le_bytes(bytes.get(at..at + 4)?.try_into().ok()?));
    let (Some(version), Some(length)) = (word(4), word(8)) else {
        return Err("is cut off within its header".into());
    };
    if version != 2 {
        return Err(format!("is glTF version {version}: export it as version 2"));
    }
    match bytes.get(..length as usize) {
        Some(whole) if length >= 12 => Ok(whole),
        Some(_) => Err(format!(
            "says that it is {length} bytes long: it is damaged"
        )),
        None => Err(format!(
            "has {} of its {length} bytes: it is cut off",
            bytes.len()
        )),
    }
}

/// What a uri names: data in itself, or a file beside the scene.
pub fn fetch(scene: &Path, uri: &str) -> std::result::Result<Vec<u8>, String> {
    if let Some(data) = uri.strip_prefix("data:") {
        let (kind, data) = data.split_once(',').ok_or("has a data URI without data")?;
        return match kind.ends_with(";base64") {
            true => base64(data).ok_or_else(|| "has a data URI that is not base64".into()),
            false => Err("has a data URI that is not base64".into()),
        };
    }
    if uri.contains("://") {
        return Err(format!("is at {uri}: only files beside the scene are read"));
    }
    let name = percent_decoded(uri).ok_or_else(|| format!("has an invalid uri {uri}"))?;
    let path = scene.parent().unwrap_or(Path::new("")).join(&name);
    file::read(&path, MAX_BYTES).map_err(|reason| format!("{name} cannot be read: {reason}"))
}

/// RFC 4648 §4, padding optional.
fn base64(text: &str) -> Option<Vec<u8>> {
    let text = text.trim_end_matches('=');
    let mut bytes = Vec::with_capacity(text.len() * 3 / 4);
    let (mut bits, mut count) = (0u32, 0);
    for letter in text.bytes() {
        let six = match letter {
            b'A'..=b'Z' => letter - b'A',
            b'a'..=b'z' => letter - b'a' + 26,
            b'0'..=b'9' => letter - b'0' + 52,
            b'+' => 62,
            b'/' => 63,
            _ => return None,
        };
        bits = bits << 6 | u32::from(six);
        count += 6;
        if count >= 8 {
            count -= 8;
            bytes.push((bits >> count) as u8);
        }
    }
    // One letter alone is not a byte.
    (count < 6).then_some(bytes)
}

/// RFC 3986 §2.1.
fn percent_decoded(uri: &str) -> Option<String> {
    let mut parts = uri.split('%');
    let mut bytes = parts.next()?.as_bytes().to_vec();
    for part in parts {
        bytes.push(u8::from_str_radix(part.get(..2)?, 16).ok()?);
        bytes.extend_from_slice(&part.as_bytes()[2..]);
    }
    String::from_utf8(bytes).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_as_in_the_rfc() {
        for (text, bytes) in [
            ("", ""),
            ("Zg==", "f"),
            ("Zm8=", "fo"),
            ("Zm9v", "foo"),
            ("Zm9vYg", "foob"),
        ] {
            assert_eq!(base64(text).as_deref(), Some(bytes.as_bytes()));
        }
        assert_eq!(base64("+/+/"), Some(vec![0xfb, 0xff, 0xbf]));
        assert_eq!(
            [base64("Zm9vY"), base64("Zm 9"), base64("Zm=9")],
            [None, None, None]
        );
    }

    #[test]
    fn uris_are_decoded() {
        assert_eq!(
            percent_decoded("a%20b%C3%A9.bin").as_deref(),
            Some("a bé.bin")
        );
        assert_eq!(
            [
                percent_decoded("%2"),
                percent_decoded("%zz"),
                percent_decoded("%ff")
            ],
            [None, None, None]
        );
    }
}
