//! A scene file as a glTF document beside its imported faces, for programs that write it again with additions.

use super::uri::read_uri;
use glam::DVec3;
use serde_json::{Value, json};
use std::path::PathBuf;

/// Target of buffer views of vertices.
pub const ARRAY_BUFFER: u32 = 34962;
/// Target of buffer views of indices.
const ELEMENT_ARRAY_BUFFER: u32 = 34963;

/// A glTF document with the places of its triangles among a scene's faces; an OBJ is converted to one.
#[derive(Debug, Default)]
pub struct SceneFile {
    /// The scene file; relative URIs are relative to it.
    pub path: PathBuf,
    /// JSON.
    pub json: Value,
    /// Buffers, in the document's order.
    pub buffers: Vec<Vec<u8>>,
    /// Primitives with faces, as nodes place them.
    pub primitives: Vec<PlacedPrimitive>,
}

/// A mesh's primitive as a node places it.
#[derive(Debug, Default)]
pub struct PlacedPrimitive {
    /// Node.
    pub node: usize,
    /// Mesh.
    pub mesh: usize,
    /// Number of the primitive within the mesh.
    pub number: usize,
    /// Its triangles, in order.
    pub triangles: Vec<FileTriangle>,
}

/// A triangle of a primitive.
#[derive(Clone, Copy, Debug)]
pub struct FileTriangle {
    /// Face of the scene.
    pub face: u32,
    /// Vertices of the primitive.
    pub vertices: [u32; 3],
    /// Positions of the vertices in the scene.
    pub positions: [DVec3; 3],
}

impl FileTriangle {
    /// Reverses the winding.
    pub fn reverse(&mut self) {
        self.vertices.swap(1, 2);
        self.positions.swap(1, 2);
    }
}

impl SceneFile {
    /// Appends an entry to a list at the top of the document; returns its index.
    pub fn append_entry(&mut self, name: &str, entry: Value) -> usize {
        if let Some(list) = self.json[name].as_array_mut() {
            list.push(entry);
            return list.len() - 1;
        }
        self.json[name] = json!([entry]);
        0
    }

    /// Names an extension that the document uses.
    pub fn use_extension(&mut self, name: &str) {
        let used = self.json["extensionsUsed"].as_array();
        if !used.is_some_and(|used| used.iter().any(|other| other == name)) {
            self.append_entry("extensionsUsed", name.into());
        }
    }

    /// Returns whether the document has meshes that Draco compressed, which cannot be written again.
    pub fn is_compressed(&self) -> bool {
        let used = self.json["extensionsUsed"].as_array();
        used.is_some_and(|used| used.iter().any(|name| name == "KHR_draco_mesh_compression"))
    }

    /// Writes the emitted radiance of a material; factors above 1 need a strength.
    pub fn write_radiance(&mut self, material: &mut Value, radiance: DVec3) {
        if radiance == DVec3::ZERO {
            return;
        }
        let strength = radiance.max_element().max(1.0);
        material["emissiveFactor"] = json!((radiance / strength).as_vec3().to_array());
        if strength > 1.0 {
            material["extensions"] = json!({ "KHR_materials_emissive_strength": { "emissiveStrength": strength } });
            self.use_extension("KHR_materials_emissive_strength");
        }
    }

    /// Appends `bytes`, aligned to four, to the first buffer; returns the index of their buffer view.
    pub fn append_view(&mut self, bytes: &[u8], target: Option<u32>) -> usize {
        if self.buffers.is_empty() {
            self.buffers.push(Vec::new());
        }
        let buffer = &mut self.buffers[0];
        buffer.resize(buffer.len().next_multiple_of(4), 0);
        let mut view = json!({ "buffer": 0, "byteOffset": buffer.len(), "byteLength": bytes.len() });
        buffer.extend(bytes);
        if let Some(target) = target {
            view["target"] = target.into();
        }
        self.append_entry("bufferViews", view)
    }

    /// Appends vectors of floats as an accessor of vertices; returns its index.
    pub fn append_vectors<const N: usize>(&mut self, vectors: &[[f32; N]]) -> usize {
        let bytes: Vec<u8> = vectors.as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect();
        let view = self.append_view(&bytes, Some(ARRAY_BUFFER));
        let mut accessor = json!({
            "bufferView": view, "componentType": 5126, "type": format!("VEC{N}"), "count": vectors.len(),
        });
        if N == 3 {
            let bound = |choose: fn(f32, f32) -> f32| -> [f32; N] {
                std::array::from_fn(|k| vectors.iter().map(|v| v[k]).reduce(choose).unwrap_or(0.0))
            };
            accessor["min"] = json!(bound(f32::min).as_slice());
            accessor["max"] = json!(bound(f32::max).as_slice());
        }
        self.append_entry("accessors", accessor)
    }

    /// Appends the vertex indices of triangles; returns the index of their accessor.
    pub fn append_indices(&mut self, triangles: &[[u32; 3]]) -> usize {
        let indices = triangles.as_flattened();
        let bytes: Vec<u8> = indices.iter().flat_map(|k| k.to_le_bytes()).collect();
        let view = self.append_view(&bytes, Some(ELEMENT_ARRAY_BUFFER));
        let accessor = json!({
            "bufferView": view, "componentType": 5125, "type": "SCALAR", "count": indices.len(),
        });
        self.append_entry("accessors", accessor)
    }

    /// Appends an image file; returns the index of the image.
    pub fn append_image(&mut self, name: &str, bytes: &[u8]) -> usize {
        let view = self.append_view(bytes, None);
        let image = json!({ "name": name, "mimeType": image_type(bytes), "bufferView": view });
        self.append_entry("images", image)
    }

    /// Reads the bytes of a URI of the document.
    ///
    /// Errors: the reason, in words that follow the name of what has the URI.
    pub fn read_uri(&self, uri: &str) -> Result<Vec<u8>, String> {
        read_uri(&self.path, uri)
    }
}

/// Returns the media type of an image file.
pub fn image_type(bytes: &[u8]) -> &'static str {
    match bytes {
        [0xFF, 0xD8, ..] => "image/jpeg",
        [b'R', b'I', b'F', b'F', ..] => "image/webp",
        [0xAB, b'K', b'T', b'X', ..] => "image/ktx2",
        _ => "image/png",
    }
}
