//! Converts an OBJ file to a glTF document: a node for each group, materials by name, indexed vertices.

use super::ObjDocument;
use crate::import::builder::Builder;
use crate::import::material::{ImportedMaterial, InputVertex};
use crate::import::scene_file::{FileTriangle, PlacedPrimitive, SceneFile};
use crate::import::surface::DEFAULT_REFLECTANCE;
use crate::paint::WrapMode;
use crate::scene::Face;
use glam::{DAffine2, DVec2, DVec3, Vec3};
use serde_json::{Value, json};
use std::collections::{BTreeMap, HashMap};
use std::path::PathBuf;
use std::rc::Rc;

/// Vertices and triangles of one material in a group.
#[derive(Default)]
struct GroupPart {
    material: Option<usize>,
    /// Position number and attributes of each vertex.
    vertices: Vec<(usize, InputVertex)>,
    known: HashMap<VertexKey, u32>,
    triangles: Vec<FileTriangle>,
}

/// Position number, and bits of texture coordinates and normal.
type VertexKey = (usize, Option<[u64; 2]>, Option<[u32; 3]>);

impl GroupPart {
    fn find_vertex(&mut self, number: usize, vertex: &InputVertex) -> u32 {
        let place = vertex.texture_coordinates[0].map(|p| p.to_array().map(f64::to_bits));
        let normal = vertex.normal.map(|n| n.to_array().map(f32::to_bits));
        let next = self.vertices.len() as u32;
        let index = *self.known.entry((number, place, normal)).or_insert(next);
        if index == next {
            self.vertices.push((number, *vertex));
        }
        index
    }

    /// Returns the values of an attribute that all vertices have.
    fn collect_attribute<T>(&self, of: impl Fn(&InputVertex) -> Option<T>) -> Option<Vec<T>> {
        self.vertices.iter().map(|(_, vertex)| of(vertex)).collect()
    }
}

/// Fills the kept file of `builder` with the document, after all faces were added.
pub fn convert_document(document: &ObjDocument, used: &BTreeMap<usize, ImportedMaterial>, builder: &mut Builder) {
    let Some(mut file) = builder.file.take() else {
        return;
    };
    file.json = json!({
        "asset": { "version": "2.0", "generator": concat!("radiosity ", env!("CARGO_PKG_VERSION")) },
        "scene": 0,
    });
    let mut materials = MaterialTable::default();
    let groups = group_faces(document, builder);
    let nodes: Vec<usize> = (0..groups.len()).collect();
    file.append_entry("scenes", json!({ "nodes": nodes }));
    for (node, (name, parts)) in groups.into_iter().enumerate() {
        let mut primitives = Vec::new();
        for (number, part) in parts.into_iter().enumerate() {
            let material = part.material.map(|k| (k, &used[&k]));
            let transform = material.and_then(|(_, m)| texture_transform(m));
            let attributes = write_attributes(document, &part, transform, &mut file);
            let indices: Vec<[u32; 3]> = part.triangles.iter().map(|t| t.vertices).collect();
            let indices = file.append_indices(&indices);
            let material = materials.find_material(document, material, &mut file);
            primitives.push(json!({ "attributes": attributes, "indices": indices, "material": material }));
            file.primitives.push(PlacedPrimitive {
                node,
                mesh: node,
                number,
                triangles: part.triangles,
            });
        }
        file.append_entry("meshes", json!({ "name": &*name, "primitives": primitives }));
        file.append_entry("nodes", json!({ "name": &*name, "mesh": node }));
    }
    builder.file = Some(file);
}

/// Returns the parts of each group, in the order of their first faces.
fn group_faces(document: &ObjDocument, builder: &Builder) -> Vec<(Rc<str>, Vec<GroupPart>)> {
    let mut groups: Vec<(Rc<str>, Vec<GroupPart>)> = Vec::new();
    let mut numbers: HashMap<Rc<str>, usize> = HashMap::new();
    let faces = builder.faces.iter().chain(&builder.pieces);
    for (k, face) in (0..).zip(faces) {
        let input = &document.faces[face.input_face.unwrap_or(k) as usize];
        let number = *numbers.entry(input.group.clone()).or_insert_with(|| {
            groups.push((input.group.clone(), Vec::new()));
            groups.len() - 1
        });
        let parts = &mut groups[number].1;
        let at = parts.iter().position(|part| part.material == input.material);
        let at = at.unwrap_or_else(|| {
            parts.push(GroupPart {
                material: input.material,
                ..GroupPart::default()
            });
            parts.len() - 1
        });
        let part = &mut parts[at];
        let vertex = |p: &DVec3| {
            let same = |(k, _): &&(usize, InputVertex)| document.vertices[*k] == *p;
            input.corners.iter().find(same).unwrap_or(&input.corners[0])
        };
        let corners: Vec<_> = face.outline().iter().map(vertex).collect();
        let corners: Vec<u32> = corners.iter().map(|(k, v)| part.find_vertex(*k, v)).collect();
        add_triangles(face, k, &corners, &mut part.triangles);
    }
    groups
}

/// Adds the one or two triangles of face `k`, which has these vertices.
fn add_triangles(face: &Face, k: u32, vertices: &[u32], triangles: &mut Vec<FileTriangle>) {
    for second in 1..vertices.len() - 1 {
        let corners = [0, second, second + 1];
        triangles.push(FileTriangle {
            face: k,
            vertices: corners.map(|n| vertices[n]),
            positions: corners.map(|n| face.corners[n]),
        });
    }
}

/// Writes the vertices of a part; returns its attributes.
fn write_attributes(
    document: &ObjDocument,
    part: &GroupPart,
    transform: Option<DAffine2>,
    file: &mut SceneFile,
) -> Value {
    let numbers = part.vertices.iter().map(|(k, _)| *k);
    let positions: Vec<[f32; 3]> = numbers
        .clone()
        .map(|k| document.vertices[k].as_vec3().to_array())
        .collect();
    let mut attributes = json!({ "POSITION": file.append_vectors(&positions) });
    let normal = |vertex: &InputVertex| vertex.normal.and_then(Vec3::try_normalize).map(|n| n.to_array());
    if let Some(normals) = part.collect_attribute(normal) {
        attributes["NORMAL"] = file.append_vectors(&normals).into();
    }
    // The v of OBJ runs upwards.
    let down = DAffine2::from_scale_angle_translation(DVec2::new(1.0, -1.0), 0.0, DVec2::Y);
    let transform = transform.unwrap_or(down);
    let place = |vertex: &InputVertex| {
        let place = transform.transform_point2(vertex.texture_coordinates[0]?).as_vec2();
        place.is_finite().then_some(place.to_array())
    };
    if let Some(places) = part.collect_attribute(place) {
        attributes["TEXCOORD_0"] = file.append_vectors(&places).into();
    }
    if document.coloured {
        let colours: Vec<[f32; 3]> = numbers.map(|k| document.colours[k].as_vec3().to_array()).collect();
        attributes["COLOR_0"] = file.append_vectors(&colours).into();
    }
    attributes
}

/// Returns the transform from the file's texture coordinates to those of a material's first texture.
fn texture_transform(material: &ImportedMaterial) -> Option<DAffine2> {
    let textures = material.colours.iter().filter_map(|colour| colour.texture.as_ref());
    textures.map(|(_, transform)| *transform).next()
}

/// Materials and images written so far.
#[derive(Default)]
struct MaterialTable {
    materials: BTreeMap<Option<usize>, usize>,
    images: BTreeMap<PathBuf, usize>,
}

impl MaterialTable {
    /// Returns the index of a material in the document.
    fn find_material(
        &mut self,
        document: &ObjDocument,
        material: Option<(usize, &ImportedMaterial)>,
        file: &mut SceneFile,
    ) -> usize {
        let number = material.map(|(k, _)| k);
        if let Some(index) = self.materials.get(&number) {
            return *index;
        }
        let mut reflectance = DVec3::splat(DEFAULT_REFLECTANCE.into());
        let mut written = json!({ "pbrMetallicRoughness": { "metallicFactor": 0.0, "roughnessFactor": 1.0 } });
        match material {
            None if document.coloured => reflectance = DVec3::ONE,
            None => {}
            Some((k, material)) => {
                reflectance = material.colours[0].factor;
                written["name"] = material.name.as_str().into();
                let textures = [0, 1].map(|colour| self.find_texture(document, (k, material), colour, file));
                if let Some(texture) = textures[0] {
                    written["pbrMetallicRoughness"]["baseColorTexture"] = json!({ "index": texture });
                }
                if let Some(texture) = textures[1] {
                    written["emissiveTexture"] = json!({ "index": texture });
                }
                file.write_radiance(&mut written, material.colours[1].factor);
            }
        }
        let colour = reflectance.extend(1.0).as_vec4().to_array();
        written["pbrMetallicRoughness"]["baseColorFactor"] = json!(colour);
        let index = file.append_entry("materials", written);
        self.materials.insert(number, index);
        index
    }

    /// Returns the index of the texture of a material's `colour`, if it has one with the coordinates that are written.
    fn find_texture(
        &mut self,
        document: &ObjDocument,
        (number, material): (usize, &ImportedMaterial),
        colour: usize,
        file: &mut SceneFile,
    ) -> Option<usize> {
        let (texture, transform) = material.colours[colour].texture.as_ref()?;
        texture_transform(material).filter(|written| written == transform)?;
        let path = document.materials[number].texture_file(colour)?;
        let image = match self.images.get(&path) {
            Some(image) => *image,
            None => {
                let bytes = crate::file::read(&path, crate::file::MAX_FILE_BYTES).ok()?;
                let name = path.file_stem().unwrap_or_default().to_string_lossy();
                let image = file.append_image(&name, &bytes);
                self.images.insert(path, image);
                image
            }
        };
        let wrap = if texture.wrap[0] == WrapMode::Clamp {
            33071
        } else {
            10497
        };
        let sampler = json!({ "magFilter": 9729, "minFilter": 9987, "wrapS": wrap, "wrapT": wrap });
        let sampler = file.append_entry("samplers", sampler);
        Some(file.append_entry("textures", json!({ "source": image, "sampler": sampler })))
    }
}
