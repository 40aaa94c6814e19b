//! The file: parts with their places on one picture, and the picture.

use crate::show::page::short;
use common::scene::Scene;
use glam::Vec3;
use gltf::Glb;
use gltf::binary::Header;
use serde_json::{Value, json};
use std::borrow::Cow;

/// The faces of one name.
pub struct Part<'a> {
    /// Theirs.
    pub name: &'a str,
    /// Of vertices.
    pub places: Vec<Vec3>,
    /// And on the picture.
    pub uvs: Vec<[f32; 2]>,
    /// Triangles.
    pub index: Vec<u32>,
}

/// Faces that follow each other and have one name are one part, to which each is added.
pub fn parts<'a>(scene: &'a Scene, mut add: impl FnMut(&mut Part<'a>, usize)) -> Vec<Part<'a>> {
    let mut parts: Vec<Part> = Vec::new();
    for (k, face) in scene.faces.iter().enumerate() {
        if parts.last().is_none_or(|part| part.name != face.name) {
            parts.push(Part {
                name: &face.name,
                places: Vec::new(),
                uvs: Vec::new(),
                index: Vec::new(),
            });
        }
        if let Some(part) = parts.last_mut() {
            add(part, k);
        }
    }
    parts.retain(|part| !part.index.is_empty());
    parts
}

/// A mesh and a node for each part, one material, one picture.
pub fn glb(
    scene: &Scene,
    parts: &[Part],
    png: &[u8],
    white: f32,
) -> std::result::Result<Vec<u8>, gltf::Error> {
    let mut file = File::default();
    let mut meshes = Vec::new();
    for part in parts {
        let places: Vec<f32> = part.places.iter().flat_map(|p| p.to_array()).collect();
        let low = part.places.iter().copied().fold(Vec3::INFINITY, Vec3::min);
        let high = part
            .places
            .iter()
            .copied()
            .fold(Vec3::NEG_INFINITY, Vec3::max);
        let bounds = json!({ "min": low.to_array(), "max": high.to_array() });
        let floats = |v: &[f32]| v.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
        let count = part.places.len();
        let place = file.accessor(&floats(&places), 34962, (5126, "VEC3", count), bounds);
        let uvs = floats(&part.uvs.concat());
        let uv = file.accessor(&uvs, 34962, (5126, "VEC2", count), json!({}));
        let index: Vec<u8> = part.index.iter().flat_map(|k| k.to_le_bytes()).collect();
        let of = (5125, "SCALAR", part.index.len());
        let index = file.accessor(&index, 34963, of, json!({}));
        meshes.push(json!({ "name": part.name, "primitives": [{
            "attributes": { "POSITION": place, "TEXCOORD_0": uv, "TEXCOORD_1": uv },
            "indices": index, "material": 0,
        }] }));
    }
    let image = file.view(png, None);
    let nodes = parts.iter().enumerate();
    let nodes: Vec<Value> = nodes
        .map(|(k, part)| json!({ "name": part.name, "mesh": k }))
        .collect();
    let document = json!({
        "asset": { "version": "2.0", "generator": concat!("radiosity ", env!("CARGO_PKG_VERSION")) },
        "scene": 0,
        "scenes": [{ "name": short(&scene.name), "nodes": (0..nodes.len()).collect::<Vec<_>>() }],
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

/// The binary part of a file, and what lies where.
#[derive(Default)]
struct File {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl File {
    fn view(&mut self, bytes: &[u8], target: Option<u32>) -> usize {
        let mut view =
            json!({ "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len() });
        if let Some(target) = target {
            view["target"] = target.into();
        }
        self.bytes.extend(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.views.push(view);
        self.views.len() - 1
    }

    fn accessor(
        &mut self,
        bytes: &[u8],
        target: u32,
        (kind, of, count): (u32, &str, usize),
        mut told: Value,
    ) -> usize {
        told["bufferView"] = self.view(bytes, Some(target)).into();
        told["componentType"] = kind.into();
        told["type"] = of.into();
        told["count"] = count.into();
        self.accessors.push(told);
        self.accessors.len() - 1
    }
}
