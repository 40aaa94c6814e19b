//! Writes a scene as binary glTF 2.0: one node, mesh and primitive per part, in triangles.

use super::{Material, Scene, round_coordinates};
use glam::DVec3;
use gltf::binary::{Glb, Header};
use serde_json::{Value, json};

/// Component types and buffer targets of glTF.
const F32_COMPONENT: u32 = 5126;
const U16_COMPONENT: u32 = 5123;
const VERTEX_TARGET: u32 = 34962;
const INDEX_TARGET: u32 = 34963;

const EMISSIVE_STRENGTH: &str = "KHR_materials_emissive_strength";

impl Scene {
    /// Encodes the scene. JSON keys are written in alphabetical order, the order of `serde_json` without features, so that
    /// the bytes do not depend on its features.
    pub fn write_glb(&self) -> Vec<u8> {
        let (mut positions, mut indices) = (Vec::new(), Vec::new());
        let (mut accessors, mut meshes, mut nodes) = (Vec::new(), Vec::new(), Vec::new());
        let mut materials: Vec<Material> = Vec::new();
        for (k, part) in self.parts.iter().enumerate() {
            let material = index_of(&mut materials, part.material, |m| m.name == part.material.name);
            let mut corners: Vec<[f32; 3]> = Vec::new();
            let mut triangles: Vec<u16> = Vec::new();
            for face in &part.faces {
                let mut vertex = |corner: &DVec3| {
                    let corner = round_coordinates(*corner).as_vec3().to_array();
                    index_of(&mut corners, corner, |c| *c == corner) as u16
                };
                let vertices: Vec<u16> = face.iter().map(&mut vertex).collect();
                let fan = vertices[1..].windows(2);
                triangles.extend(fan.flat_map(|pair| [vertices[0], pair[0], pair[1]]));
            }
            let extreme = |choose: fn(f32, f32) -> f32| {
                let all = corners.iter().copied();
                all.reduce(|a, b| std::array::from_fn(|axis| choose(a[axis], b[axis])))
            };
            let accessor = |view: u32, offset: usize, component: u32, count: usize, kind: &str| json!({ "bufferView": view, "byteOffset": offset, "componentType": component, "count": count, "type": kind });
            let mut vertices = accessor(0, positions.len(), F32_COMPONENT, corners.len(), "VEC3");
            vertices["max"] = json!(extreme(f32::max));
            vertices["min"] = json!(extreme(f32::min));
            accessors.push(vertices);
            accessors.push(accessor(1, indices.len(), U16_COMPONENT, triangles.len(), "SCALAR"));
            positions.extend(corners.iter().flatten().flat_map(|x| x.to_le_bytes()));
            indices.extend(triangles.iter().flat_map(|k| k.to_le_bytes()));
            let primitive = json!({
                "attributes": { "POSITION": 2 * k },
                "indices": 2 * k + 1,
                "material": material,
            });
            meshes.push(json!({ "name": part.name, "primitives": [primitive] }));
            nodes.push(json!({ "mesh": k, "name": part.name }));
        }
        let document = json!({
            "accessors": accessors,
            "asset": { "extras": { "about": self.about }, "generator": "scenes/generate.rs", "version": "2.0" },
            "bufferViews": [
                { "buffer": 0, "byteLength": positions.len(), "byteOffset": 0, "target": VERTEX_TARGET },
                { "buffer": 0, "byteLength": indices.len(), "byteOffset": positions.len(), "target": INDEX_TARGET },
            ],
            "buffers": [{ "byteLength": positions.len() + indices.len() }],
            "extensionsUsed": [EMISSIVE_STRENGTH],
            "materials": materials.iter().map(material_json).collect::<Vec<_>>(),
            "meshes": meshes,
            "nodes": nodes,
            "scene": 0,
            "scenes": [{ "name": self.name, "nodes": (0..self.parts.len()).collect::<Vec<_>>() }],
        });
        let header = Header {
            magic: *b"glTF",
            version: 2,
            length: 0,
        };
        let glb = Glb {
            header,
            json: document.to_string().into_bytes().into(),
            bin: Some([positions, indices].concat().into()),
        };
        glb.to_vec().expect("a write to memory succeeds")
    }
}

/// Returns the index of the first value that is alike, or of `new` at the end of the list.
fn index_of<T>(values: &mut Vec<T>, new: T, is_alike: impl Fn(&T) -> bool) -> usize {
    values.iter().position(is_alike).unwrap_or_else(|| {
        values.push(new);
        values.len() - 1
    })
}

/// Reflectance becomes the base colour; radiance becomes a colour of at most 1 and a strength.
fn material_json(material: &Material) -> Value {
    let [r, g, b] = material.reflectance;
    let surface = json!({ "baseColorFactor": [r, g, b, 1.0], "metallicFactor": 0.0 });
    let strength = material.radiance.into_iter().fold(0.0, f64::max);
    if strength == 0.0 {
        return json!({ "name": material.name, "pbrMetallicRoughness": surface });
    }
    json!({
        "emissiveFactor": material.radiance.map(|l| l / strength),
        "extensions": { EMISSIVE_STRENGTH: { "emissiveStrength": strength } },
        "name": material.name,
        "pbrMetallicRoughness": surface,
    })
}
