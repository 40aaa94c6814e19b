//! Encodes a binary glTF file: meshes with lightmap coordinates and the lightmap picture.

use crate::report::format::file_name;
use common::scene::Scene;
use glam::Vec3;
use gltf::Glb;
use gltf::binary::Header;
use serde_json::{Value, json};
use std::borrow::Cow;

/// Successive faces of one name, triangulated.
pub struct MeshPart<'a> {
    /// Name of the faces.
    pub name: &'a str,
    /// Vertex positions.
    pub positions: Vec<Vec3>,
    /// Lightmap coordinates of the vertices.
    pub uvs: Vec<[f32; 2]>,
    /// Vertex indices, three per triangle.
    pub indices: Vec<u32>,
}

/// Groups successive faces of one name into parts; `add` appends a face to its part.
pub fn group_parts<'a>(scene: &'a Scene, mut add: impl FnMut(&mut MeshPart<'a>, usize)) -> Vec<MeshPart<'a>> {
    let mut parts: Vec<MeshPart> = Vec::new();
    for (k, face) in scene.faces.iter().enumerate() {
        if parts.last().is_none_or(|part| part.name != face.name) {
            parts.push(MeshPart {
                name: &face.name,
                positions: Vec::new(),
                uvs: Vec::new(),
                indices: Vec::new(),
            });
        }
        if let Some(part) = parts.last_mut() {
            add(part, k);
        }
    }
    parts.retain(|part| !part.indices.is_empty());
    parts
}

/// Encodes the parts as meshes with one unlit material, the lightmap `png`.
///
/// Errors: the file exceeds the format's size.
pub fn encode_glb(
    scene: &Scene,
    parts: &[MeshPart],
    png: &[u8],
    white: f32,
) -> std::result::Result<Vec<u8>, gltf::Error> {
    let mut file = GlbBuffer::default();
    let mut meshes = Vec::new();
    for part in parts {
        let places: Vec<f32> = part.positions.iter().flat_map(|p| p.to_array()).collect();
        let low = part.positions.iter().copied().fold(Vec3::INFINITY, Vec3::min);
        let high = part.positions.iter().copied().fold(Vec3::NEG_INFINITY, Vec3::max);
        let bounds = json!({ "min": low.to_array(), "max": high.to_array() });
        let floats = |v: &[f32]| v.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
        let count = part.positions.len();
        let place = file.append_accessor(&floats(&places), 34962, (5126, "VEC3", count), bounds);
        let uvs = floats(&part.uvs.concat());
        let uv = file.append_accessor(&uvs, 34962, (5126, "VEC2", count), json!({}));
        let index: Vec<u8> = part.indices.iter().flat_map(|k| k.to_le_bytes()).collect();
        let of = (5125, "SCALAR", part.indices.len());
        let index = file.append_accessor(&index, 34963, of, json!({}));
        meshes.push(json!({ "name": part.name, "primitives": [{
            "attributes": { "POSITION": place, "TEXCOORD_0": uv, "TEXCOORD_1": uv },
            "indices": index, "material": 0,
        }] }));
    }
    let image = file.append_view(png, None);
    let nodes = parts.iter().enumerate();
    let nodes: Vec<Value> = nodes.map(|(k, part)| json!({ "name": part.name, "mesh": k })).collect();
    let document = json!({
        "asset": { "version": "2.0", "generator": concat!("radiosity ", env!("CARGO_PKG_VERSION")) },
        "scene": 0,
        "scenes": [{ "name": file_name(&scene.name), "nodes": (0..nodes.len()).collect::<Vec<_>>() }],
        "nodes": nodes,
        "meshes": meshes,
        "extensionsUsed": ["KHR_materials_unlit"],
        "materials": [{
            "name": "baked radiosity",
            "pbrMetallicRoughness": { "baseColorTexture": { "index": 0, "texCoord": 1 }, "metallicFactor": 0.0 },
            "extensions": { "KHR_materials_unlit": {} },
            "extras": { "white": white, "unit": "W/m²" },
        }],
        "textures": [{ "source": 0, "sampler": 0 }],
        // Bilinear, clamped: coarser levels would mix charts.
        "samplers": [{ "magFilter": 9729, "minFilter": 9729, "wrapS": 33071, "wrapT": 33071 }],
        "images": [{ "name": "radiosity", "mimeType": "image/png", "bufferView": image }],
        "accessors": file.accessors,
        "bufferViews": file.views,
        "buffers": [{ "byteLength": file.bytes.len() }],
    });
    let glb = Glb {
        header: Header {
            magic: *b"glTF",
            version: 2,
            length: 0,
        },
        json: Cow::Owned(document.to_string().into_bytes()),
        bin: Some(Cow::Owned(file.bytes)),
    };
    glb.to_vec()
}

/// Binary chunk with its buffer views and accessors.
#[derive(Default)]
struct GlbBuffer {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl GlbBuffer {
    /// Appends `bytes`, aligned to four; returns the index of their buffer view.
    fn append_view(&mut self, bytes: &[u8], target: Option<u32>) -> usize {
        let mut view = json!({ "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len() });
        if let Some(target) = target {
            view["target"] = target.into();
        }
        self.bytes.extend(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.views.push(view);
        self.views.len() - 1
    }

    /// Appends `bytes` as an accessor of (component type, element type, count) and returns its index.
    fn append_accessor(
        &mut self,
        bytes: &[u8],
        target: u32,
        (kind, of, count): (u32, &str, usize),
        mut description: Value,
    ) -> usize {
        description["bufferView"] = self.append_view(bytes, Some(target)).into();
        description["componentType"] = kind.into();
        description["type"] = of.into();
        description["count"] = count.into();
        self.accessors.push(description);
        self.accessors.len() - 1
    }
}
