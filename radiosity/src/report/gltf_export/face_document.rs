//! Makes a glTF document of a scene's faces, for a scene that has no file or differs from it.

use common::import::{FileTriangle, PlacedPrimitive, SceneFile};
use common::scene::{Face, Scene};
use serde_json::{Value, json};
use std::collections::HashMap;
use std::f64::consts::PI;

/// Makes the document: a node for the faces of each name and colour. A face whose colours vary has their means.
pub fn make_face_document(scene: &Scene) -> SceneFile {
    let mut file = SceneFile {
        path: (&scene.name).into(),
        json: json!({
            "asset": { "version": "2.0", "generator": concat!("radiosity ", env!("CARGO_PKG_VERSION")) },
            "scene": 0,
        }),
        ..SceneFile::default()
    };
    let groups = group_faces(scene);
    let nodes: Vec<usize> = (0..groups.len()).collect();
    file.append_entry("scenes", json!({ "nodes": nodes }));
    for (node, faces) in groups.iter().enumerate() {
        let first = &scene.faces[faces[0]];
        let mut vertices: Vec<[f32; 3]> = Vec::new();
        let mut triangles = Vec::new();
        for k in faces {
            add_face(*k, &scene.faces[*k], &mut vertices, &mut triangles);
        }
        let positions = file.append_vectors(&vertices);
        let indices: Vec<[u32; 3]> = triangles.iter().map(|triangle| triangle.vertices).collect();
        let indices = file.append_indices(&indices);
        let material = make_material(first, &mut file);
        let material = file.append_entry("materials", material);
        let primitive = json!({ "attributes": { "POSITION": positions }, "indices": indices, "material": material });
        file.append_entry("meshes", json!({ "name": first.name, "primitives": [primitive] }));
        file.append_entry("nodes", json!({ "name": first.name, "mesh": node }));
        file.primitives.push(PlacedPrimitive {
            node,
            mesh: node,
            number: 0,
            triangles,
        });
    }
    file
}

/// Returns the numbers of the faces of each name and colour, in the order of their first faces.
fn group_faces(scene: &Scene) -> Vec<Vec<usize>> {
    let mut groups: Vec<Vec<usize>> = Vec::new();
    let mut numbers = HashMap::new();
    for (k, face) in scene.faces.iter().enumerate() {
        let colours = [face.reflectance, face.emission].map(|colour| colour.to_array().map(f32::to_bits));
        let number = *numbers.entry((&face.name, colours)).or_insert(groups.len());
        if number == groups.len() {
            groups.push(Vec::new());
        }
        groups[number].push(k);
    }
    groups
}

/// Adds the vertices and the one or two triangles of face `k`.
fn add_face(k: usize, face: &Face, vertices: &mut Vec<[f32; 3]>, triangles: &mut Vec<FileTriangle>) {
    let first = vertices.len() as u32;
    let corners = face.outline();
    vertices.extend(corners.iter().map(|corner| corner.as_vec3().to_array()));
    for second in 1..corners.len() - 1 {
        let own = [0, second, second + 1];
        triangles.push(FileTriangle {
            face: k as u32,
            vertices: own.map(|n| first + n as u32),
            positions: own.map(|n| corners[n]),
        });
    }
}

/// Makes the material of a face.
fn make_material(face: &Face, file: &mut SceneFile) -> Value {
    let colour = face.reflectance.extend(1.0).to_array();
    let surface = json!({ "baseColorFactor": colour, "metallicFactor": 0.0, "roughnessFactor": 1.0 });
    let mut material = json!({ "name": face.name, "pbrMetallicRoughness": surface });
    file.write_radiance(&mut material, face.emission.as_dvec3() / PI);
    material
}
