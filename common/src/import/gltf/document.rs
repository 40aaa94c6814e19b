//! Reads the JSON and the buffers of a glTF file: GLB chunks, `data:` URIs and files relative to it. The other modules
//! here read accessors and pictures from it.

use crate::error::{Error, Result};
use crate::import::uri::read_uri;
use gltf::binary::Glb;
use gltf::json::{Index, Root, deserialize};
use serde_json::Value;
use std::path::Path;

/// Result whose error is a message about the file or one of its parts.
pub type GltfResult<T> = std::result::Result<T, String>;

/// A glTF document and its buffers.
pub struct GltfDocument {
    /// JSON as in the file, with the extensions that the crate `gltf` does not know.
    pub json: Value,
    /// JSON as parsed, its references not yet checked.
    pub root: Root,
    /// Buffers, at least as long as the document states.
    pub buffers: Vec<Vec<u8>>,
}

impl GltfDocument {
    /// Parses the JSON and reads the buffers.
    ///
    /// Errors: the file is not glTF 2.0, requires an unsupported extension, or lacks a buffer.
    pub fn read(path: &Path, bytes: &[u8]) -> Result<Self> {
        let fail = |message: String| Error::bad_input(path, "", message);
        let (json, root, mut blob) = parse(bytes).map_err(fail)?;
        let is_supported = |name: &String| SUPPORTED_EXTENSIONS.contains(&name.as_str());
        if let Some(name) = root.extensions_required.iter().find(|n| !is_supported(n)) {
            let advice = conversion_advice(name, path);
            return Err(fail(format!(
                "requires the extension {name}, which is not read: {advice}"
            )));
        }
        let mut buffers = Vec::with_capacity(root.buffers.len());
        for (k, buffer) in root.buffers.iter().enumerate() {
            let fail = |message| Error::bad_input(path, format!("buffer {k}"), message);
            let bytes = match buffer.uri.as_deref() {
                Some(uri) => read_uri(path, uri),
                None if k == 0 => blob.take().ok_or_else(|| "has no binary chunk".into()),
                None => Err("has no uri".into()),
            };
            let bytes = bytes.map_err(fail)?;
            let (length, wanted) = (bytes.len(), buffer.byte_length.0);
            if (length as u64) < wanted {
                return Err(fail(format!(
                    "has {length} of its {wanted} bytes: is the file cut off?"
                )));
            }
            buffers.push(bytes);
        }
        Ok(Self { json, root, buffers })
    }
}

/// Parses the JSON; returns it as text and as a document, with the binary chunk.
fn parse(bytes: &[u8]) -> GltfResult<(Value, Root, Option<Vec<u8>>)> {
    let invalid = |e: &dyn std::fmt::Display| format!("is not valid glTF 2.0: {e}");
    let (text, blob) = if bytes.starts_with(b"glTF") {
        let chunks = Glb::from_slice(glb_container(bytes)?).map_err(|e| invalid(&e))?;
        (chunks.json, chunks.bin)
    } else {
        let text = bytes.strip_prefix(crate::import::BYTE_ORDER_MARK);
        (text.unwrap_or(bytes).into(), None)
    };
    let document: Value = serde_json::from_slice(&text).map_err(|e| invalid(&e))?;
    check_version(&document)?;
    check_indices("", &document)?;
    check_objects("", &document)?;
    // The validation of the crate `gltf` panics on some indices; here each access is checked.
    let mut root: Root = deserialize::from_slice(&text).map_err(|e| invalid(&e))?;
    for (k, texture) in root.textures.iter_mut().enumerate() {
        let own = &document["textures"][k];
        let webp = own["extensions"]["EXT_texture_webp"]["source"].as_u64();
        if let Some(source) = webp.filter(|_| own["source"].is_null()) {
            texture.source = Index::new(source as u32);
        }
    }
    Ok((document, root, blob.map(Into::into)))
}

/// Checks that the document is glTF 2.0, or a later 2.x that a reader of 2.0 may read: the crate `gltf` ignores
/// the version.
///
/// Errors: it is of another version or states none.
fn check_version(document: &Value) -> GltfResult<()> {
    let of = |name: &str| document["asset"][name].as_str();
    let version = of("version").ok_or("is not valid glTF 2.0: it has no asset.version")?;
    if version.split('.').next() != Some("2") {
        return Err(format!("is glTF version {version}: export it as version 2"));
    }
    match of("minVersion") {
        None | Some("2.0") => Ok(()),
        Some(least) => Err(format!("needs a reader of glTF {least}: export it as version 2.0")),
    }
}

/// Returns whether JSON values of this name are indices: numbers, lists of numbers, or (`attributes`) numbers by name.
fn names_indices(name: &str) -> bool {
    let is_node = matches!(name, "scene" | "nodes" | "children" | "mesh" | "skin" | "light");
    let is_texture = matches!(name, "index" | "source" | "sampler" | "texCoord");
    is_node || is_texture || matches!(name, "material" | "attributes" | "indices" | "bufferView" | "buffer")
}

/// Checks that every index in a value of this name fits in 32 bits: the crate `gltf` reads 2³² as 0. The parser
/// limits the depth of the recursion.
///
/// Errors: an index is larger.
fn check_indices(name: &str, value: &Value) -> GltfResult<()> {
    match value {
        Value::Number(number) if names_indices(name) && number.as_u64() > Some(u32::MAX.into()) => {
            Err(format!("has the index {number} in `{name}`: it is damaged"))
        }
        Value::Array(values) => values.iter().try_for_each(|v| check_indices(name, v)),
        Value::Object(entries) => entries
            .iter()
            .filter(|(key, _)| *key != "extras")
            .try_for_each(|(key, value)| check_indices(if name == "attributes" { name } else { key }, value)),
        _ => Ok(()),
    }
}

/// Returns whether JSON values of this name are objects.
fn names_object(name: &str) -> bool {
    let is_texture = name.ends_with("Texture");
    is_texture
        || matches!(
            name,
            "asset" | "attributes" | "extensions" | "pbrMetallicRoughness" | "sparse" | "spot"
        )
}

/// Returns whether JSON values of this name are lists of objects, in some places of indices.
fn names_objects(name: &str) -> bool {
    let is_data = matches!(
        name,
        "accessors" | "buffers" | "bufferViews" | "images" | "samplers" | "textures"
    );
    is_data
        || matches!(
            name,
            "lights" | "materials" | "meshes" | "nodes" | "primitives" | "scenes" | "skins" | "targets"
        )
}

/// Checks that no list stands in the place of an object: the crate `gltf` takes its entries for the values of the object,
/// and whoever adds to the document would add to a list.
///
/// Errors: one does.
fn check_objects(name: &str, value: &Value) -> GltfResult<()> {
    let wrong = |name: &str| {
        Err(format!(
            "has a list in `{name}` in the place of an object: it is damaged"
        ))
    };
    match value {
        Value::Array(_) if names_object(name) => wrong(name),
        Value::Array(values) if names_objects(name) && values.iter().any(Value::is_array) => wrong(name),
        Value::Array(values) => values.iter().try_for_each(|v| check_objects(name, v)),
        Value::Object(entries) => {
            let entries = || entries.iter().filter(|(key, _)| *key != "extras");
            match entries().find(|(_, value)| name == "extensions" && value.is_array()) {
                Some((key, _)) => wrong(key),
                None => entries().try_for_each(|(key, value)| check_objects(key, value)),
            }
        }
        _ => Ok(()),
    }
}

/// Extensions that a file may require.
const SUPPORTED_EXTENSIONS: [&str; 7] = [
    "EXT_texture_webp",
    "KHR_draco_mesh_compression",
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_materials_unlit",
    "KHR_mesh_quantization",
    "KHR_texture_transform",
];

/// Lists the optional extensions of a file that are not supported.
pub fn unsupported_extensions(root: &Root) -> Vec<&str> {
    let used = root.extensions_used.iter().map(String::as_str);
    used.filter(|name| !SUPPORTED_EXTENSIONS.contains(name)).collect()
}

/// Returns the command that converts the file at `path` to one without an extension.
fn conversion_advice(extension: &str, path: &Path) -> String {
    let (command, needs) = match extension {
        "EXT_meshopt_compression" | "KHR_meshopt_compression" => ("copy", ""),
        "KHR_texture_basisu" => ("ktxdecompress", " (with KTX-Software installed)"),
        "EXT_texture_avif" => ("webp", ""),
        "KHR_materials_pbrSpecularGlossiness" => ("metalrough", ""),
        _ => return "export without it".into(),
    };
    let path = path.display();
    format!("convert it, `npx @gltf-transform/cli {command} {path} OUT.glb`{needs}")
}

/// Returns a GLB up to its stated length, its header checked (the crate `gltf` subtracts unchecked).
fn glb_container(bytes: &[u8]) -> GltfResult<&[u8]> {
    let [_, version, length, ..] = bytes.as_chunks().0 else {
        return Err("is cut off within its header".into());
    };
    let [version, length] = [version, length].map(|word| u32::from_le_bytes(*word));
    if version != 2 {
        return Err(format!("is glTF version {version}: export it as version 2"));
    }
    if length < 12 {
        return Err(format!("says that it is {length} bytes long: it is damaged"));
    }
    let count = bytes.len();
    let cut_off = || format!("has {count} of its {length} bytes: it is cut off");
    bytes.get(..length as usize).ok_or_else(cut_off)
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn only_readable_versions_are_accepted() {
        let is_accepted = |asset: Value| check_version(&json!({ "asset": asset })).is_ok();
        let good = json!([{"version": "2.0"}, {"version": "2.1"}, {"version": "2.1", "minVersion": "2.0"}]);
        let bad = json!([{}, {"version": 2}, {"version": "1.0"}, {"version": "20.0"}, {"version": "3.0"},
            {"version": "2.1", "minVersion": "2.1"}]);
        for (assets, expected) in [(good, true), (bad, false)] {
            for asset in assets.as_array().into_iter().flatten() {
                assert_eq!(is_accepted(asset.clone()), expected, "{asset}");
            }
        }
    }

    #[test]
    fn indices_beyond_32_bits_are_refused_and_other_numbers_are_not() {
        let beyond = 1_u64 << 32;
        for bad in [
            json!({"scene": beyond}),
            json!({"scenes": [{"nodes": [0, beyond]}]}),
            json!({"meshes": [{"primitives": [{"attributes": {"POSITION": beyond}}]}]}),
            json!({"accessors": [{"sparse": {"indices": {"bufferView": beyond}}}]}),
            json!({"textures": [{"source": beyond}]}),
            json!({"textures": [{"sampler": beyond}]}),
            json!({"images": [{"bufferView": beyond}]}),
            json!({"materials": [{"emissiveTexture": {"index": beyond}}]}),
            json!({"materials": [{"emissiveTexture": {"index": 0, "texCoord": beyond}}]}),
            json!({"nodes": [{"extensions": {"KHR_lights_punctual": {"light": beyond}}}]}),
            json!({"nodes": [{"skin": beyond}]}),
        ] {
            assert!(check_indices("", &bad).is_err(), "{bad}");
        }
        let good = json!({"nodes": [{"mesh": 4_294_967_295_u64, "translation": [beyond, 0, 0], "extras": {"index": beyond}}],
            "accessors": [{"max": [beyond], "indices": {"byteOffset": beyond}}]});
        assert_eq!(check_indices("", &good), Ok(()));
    }

    #[test]
    fn lists_in_the_place_of_objects_are_refused() {
        for bad in [
            json!({"materials": [[]]}),
            json!({"meshes": [{"primitives": [[{"POSITION": 0}]]}]}),
            json!({"materials": [{"extensions": []}]}),
            json!({"materials": [{"extensions": {"KHR_materials_unlit": []}}]}),
            json!({"materials": [{"emissiveTexture": [0]}]}),
            json!({"accessors": [{"sparse": [1, 2, 3]}]}),
        ] {
            assert!(check_objects("", &bad).is_err(), "{bad}");
        }
        let good = json!({"nodes": [{"children": [1], "extras": {"extensions": [[]]}}, {"matrix": [0]}],
            "scenes": [{"nodes": [0]}], "extensions": {"VENDOR_grid": {"rows": [[1], [2]]}}});
        assert_eq!(check_objects("", &good), Ok(()));
    }
}
