//! Attaches a lightmap to a glTF document and encodes it as GLB.
//!
//! The document stays as it is but for the following. Vertices that lie in several charts are copied with all their
//! attributes. A mesh that several nodes place gets a copy for each of them but the first, since each has its own light.
//! A material that unlit primitives have, too, gets a copy. Where the scene was solved two-sided, each back becomes
//! triangles of its own. All buffers become the binary chunk, and image files are embedded.

use super::uv_charts::UvCharts;
use common::import::{ARRAY_BUFFER, FileTriangle, PlacedPrimitive, SceneFile, image_type};
use common::scene::Scene;
use common::{Error, Result};
use glam::{DVec2, DVec3};
use gltf::Glb;
use gltf::binary::Header;
use serde_json::{Value, json};
use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet, HashMap};

/// Extension of materials that names the lightmap.
const LIGHTMAP_EXTENSION: &str = "MOZ_lightmap";

/// Lightmap as a texture.
pub struct LightmapTexture {
    /// PNG file: irradiance, sRGB.
    pub png: Vec<u8>,
    /// Irradiance of white, W/m².
    pub intensity: f32,
    /// Radiosity that a display should show as white, W/m².
    pub display_white: f32,
    /// True if the file's own TEXCOORD_1 places it.
    pub keeps_coordinates: bool,
}

/// Attaches a lightmap on `charts` to `file`; returns the GLB file, and adds notes on images that cannot be read.
///
/// Errors: an accessor of the file is damaged; the result exceeds the format's size.
pub fn attach_lightmap(
    mut file: SceneFile,
    (scene, charts): (&Scene, &UvCharts),
    texture: &LightmapTexture,
    notes: &mut Vec<String>,
) -> Result<Vec<u8>> {
    merge_buffers(&mut file);
    embed_images(&mut file, notes);
    let placed = separate_instances(&mut file);
    let set = if texture.keeps_coordinates {
        1
    } else {
        free_coordinate_set(&file, &placed)
    };
    if !texture.keeps_coordinates {
        for primitive in &placed {
            write_coordinates(&mut file, primitive, (scene, charts), set)?;
        }
    }
    let image = file.append_image("lightmap", &texture.png);
    let sampler = json!({ "magFilter": 9729, "minFilter": 9987, "wrapS": 33071, "wrapT": 33071 });
    let sampler = file.append_entry("samplers", sampler);
    let extras = json!({ "white": texture.display_white, "unit": "W/m²" });
    let index = json!({ "name": "lightmap", "source": image, "sampler": sampler, "extras": extras });
    let index = file.append_entry("textures", index);
    let lightmap = json!({ "index": index, "texCoord": set, "intensity": texture.intensity });
    attach_materials(&mut file, &placed, scene, &lightmap);
    file.use_extension(LIGHTMAP_EXTENSION);
    encode_glb(file)
}

/// Returns the value at `keys`, null if there is none.
fn value_at<'a>(value: &'a Value, keys: &[&str]) -> &'a Value {
    keys.iter().fold(value, |value, key| &value[*key])
}

fn index_at(value: &Value, key: &str) -> Option<usize> {
    usize::try_from(value[key].as_u64()?).ok()
}

/// Joins all buffers to the first.
fn merge_buffers(file: &mut SceneFile) {
    let mut joined = Vec::new();
    let mut starts = Vec::new();
    for buffer in std::mem::take(&mut file.buffers) {
        joined.resize(joined.len().next_multiple_of(4), 0);
        starts.push(joined.len() as u64);
        joined.extend(buffer);
    }
    file.buffers = vec![joined];
    let shift = |part: &mut Value| {
        let start = index_at(part, "buffer").and_then(|buffer| starts.get(buffer));
        let Some(start) = start.filter(|_| starts.len() > 1) else {
            return;
        };
        part["buffer"] = 0.into();
        part["byteOffset"] = (part["byteOffset"].as_u64().unwrap_or(0) + start).into();
    };
    for view in file.json["bufferViews"].as_array_mut().into_iter().flatten() {
        shift(view);
        let extensions = view.get_mut("extensions").and_then(Value::as_object_mut);
        extensions
            .into_iter()
            .flatten()
            .for_each(|(_, extension)| shift(extension));
    }
}

/// Embeds images that are files of their own.
fn embed_images(file: &mut SceneFile, notes: &mut Vec<String>) {
    for k in 0..file.json["images"].as_array().map_or(0, Vec::len) {
        let uri = file.json["images"][k]["uri"]
            .as_str()
            .filter(|uri| !uri.starts_with("data:"));
        let Some(uri) = uri.map(String::from) else {
            continue;
        };
        match file.read_uri(&uri) {
            Ok(bytes) => {
                let view = file.append_view(&bytes, None);
                let image = &mut file.json["images"][k];
                image.as_object_mut().and_then(|image| image.remove("uri"));
                image["bufferView"] = view.into();
                image["mimeType"] = image_type(&bytes).into();
            }
            Err(reason) => notes.push(format!(
                "image {k} {reason}; the baked scene names it as the scene does"
            )),
        }
    }
}

/// Gives each node but the first a mesh of its own; returns the primitives with their meshes.
fn separate_instances(file: &mut SceneFile) -> Vec<PlacedPrimitive> {
    let mut placed = std::mem::take(&mut file.primitives);
    let mut owners: HashMap<usize, usize> = HashMap::new();
    let mut copies: HashMap<(usize, usize), usize> = HashMap::new();
    for primitive in &mut placed {
        let (mesh, node) = (primitive.mesh, primitive.node);
        if *owners.entry(mesh).or_insert(node) == node {
            continue;
        }
        primitive.mesh = *copies.entry((mesh, node)).or_insert_with(|| {
            let copy = file.json["meshes"][mesh].clone();
            file.append_entry("meshes", copy)
        });
        file.json["nodes"][node]["mesh"] = primitive.mesh.into();
    }
    placed
}

/// Returns the JSON of a placed primitive.
fn primitive_json<'a>(file: &'a SceneFile, placed: &PlacedPrimitive) -> &'a Value {
    &file.json["meshes"][placed.mesh]["primitives"][placed.number]
}

/// Returns the set of texture coordinates for the lightmap: 1, or a new one if textures use the file's own.
fn free_coordinate_set(file: &SceneFile, placed: &[PlacedPrimitive]) -> usize {
    let has_set = |primitive: &Value, set: usize| !primitive["attributes"][format!("TEXCOORD_{set}")].is_null();
    let is_in_use = placed.iter().map(|p| primitive_json(file, p)).any(|primitive| {
        let material = index_at(primitive, "material").map_or(&Value::Null, |k| &file.json["materials"][k]);
        has_set(primitive, 1) && names_second_set(material)
    });
    let is_free = |set: &usize| !placed.iter().any(|p| has_set(primitive_json(file, p), *set));
    if is_in_use { (2..).find(is_free).unwrap_or(2) } else { 1 }
}

/// Returns whether a texture of the material has the second set of coordinates.
fn names_second_set(value: &Value) -> bool {
    match value {
        Value::Object(entries) => entries.iter().any(|(key, value)| match key.as_str() {
            "texCoord" => value == 1,
            "extras" | LIGHTMAP_EXTENSION => false,
            _ => names_second_set(value),
        }),
        _ => false,
    }
}

/// Vertices of a primitive on the lightmap.
struct LitVertices {
    /// Place on the lightmap.
    places: Vec<[f32; 2]>,
    /// Chart of each of the file's vertices.
    islands: Vec<Option<u32>>,
    /// Vertices of the file that are copied, true for one that belongs to a back.
    copies: Vec<(u32, bool)>,
    /// Copies by vertex and chart.
    known: HashMap<(u32, u32), u32>,
}

impl LitVertices {
    fn new(count: usize) -> Self {
        Self {
            places: vec![[0.0; 2]; count],
            islands: vec![None; count],
            copies: Vec::new(),
            known: HashMap::new(),
        }
    }

    /// Places a vertex on a chart, a copy if it has another place already; returns its number.
    fn place_vertex(&mut self, vertex: u32, island: u32, place: DVec2, is_back: bool) -> u32 {
        let own = &mut self.islands[vertex as usize];
        if !is_back && *own.get_or_insert(island) == island {
            self.places[vertex as usize] = place.as_vec2().to_array();
            return vertex;
        }
        let next = self.places.len() as u32;
        let copy = *self.known.entry((vertex, island)).or_insert(next);
        if copy == next {
            self.places.push(place.as_vec2().to_array());
            self.copies.push((vertex, is_back));
        }
        copy
    }

    /// Places the vertices of a triangle on the chart of a face.
    fn place_triangle(
        &mut self,
        triangle: &FileTriangle,
        (scene, charts): (&Scene, &UvCharts),
        face: usize,
        is_back: bool,
    ) -> [u32; 3] {
        let Some(chart) = charts.corners[face] else {
            return triangle.vertices;
        };
        let corners = scene.faces[face].corners;
        let at = |p: DVec3| corners.iter().position(|corner| *corner == p).unwrap_or(0);
        std::array::from_fn(|k| {
            let place = chart[at(triangle.positions[k])];
            self.place_vertex(triangle.vertices[k], charts.islands[face], place, is_back)
        })
    }
}

/// Writes the lightmap coordinates of a primitive as `set`, and its vertices and indices anew where vertices are copied.
fn write_coordinates(
    file: &mut SceneFile,
    placed: &PlacedPrimitive,
    (scene, charts): (&Scene, &UvCharts),
    set: usize,
) -> Result<()> {
    let mut primitive = primitive_json(file, placed).clone();
    let position = index_at(&primitive["attributes"], "POSITION").unwrap_or(0);
    let count = index_at(&file.json["accessors"][position], "count").unwrap_or(0);
    let mut vertices = LitVertices::new(count);
    let mut triangles = Vec::with_capacity(placed.triangles.len());
    for triangle in &placed.triangles {
        triangles.push(vertices.place_triangle(triangle, (scene, charts), triangle.face as usize, false));
    }
    for triangle in &placed.triangles {
        if let Some(back) = scene.faces[triangle.face as usize].partner {
            let [a, b, c] = vertices.place_triangle(triangle, (scene, charts), back as usize, true);
            triangles.push([a, c, b]);
        }
    }
    if !vertices.copies.is_empty() {
        copy_attributes(file, &mut primitive["attributes"], &vertices)?;
        let targets = primitive.get_mut("targets").and_then(Value::as_array_mut);
        for target in targets.into_iter().flatten() {
            copy_attributes(file, target, &vertices)?;
        }
        primitive["indices"] = file.append_indices(&triangles).into();
        primitive["mode"] = 4.into();
    }
    let coordinates = file.append_vectors(&vertices.places);
    // Sets are numbered without gaps.
    for other in 0..set {
        let name = format!("TEXCOORD_{other}");
        if primitive["attributes"].get(&name).is_none() {
            primitive["attributes"][&name] = coordinates.into();
        }
    }
    primitive["attributes"][format!("TEXCOORD_{set}")] = coordinates.into();
    file.json["meshes"][placed.mesh]["primitives"][placed.number] = primitive;
    Ok(())
}

/// Replaces accessors of vertices by ones with copies of some vertices at their end.
fn copy_attributes(file: &mut SceneFile, attributes: &mut Value, vertices: &LitVertices) -> Result<()> {
    for (name, index) in attributes.as_object_mut().into_iter().flatten() {
        let old = index.as_u64().unwrap_or(u64::MAX);
        let fail = || {
            let message =
                "its vertices cannot be copied, for the accessor is damaged or compressed: export the scene anew";
            Error::bad_input(&file.path, format!("accessor {old} ({name})"), message)
        };
        let mut accessor = usize::try_from(old).map_or(Value::Null, |k| file.json["accessors"][k].clone());
        let has_all = index_at(&accessor, "count") == Some(vertices.islands.len());
        let size = element_size(&accessor).filter(|_| has_all).ok_or_else(fail)?;
        let mut elements = read_elements(file, &accessor, size).ok_or_else(fail)?;
        for (vertex, is_back) in &vertices.copies {
            let start = *vertex as usize * size;
            let mut element = elements.get(start..start + size).ok_or_else(fail)?.to_vec();
            if *is_back && name == "NORMAL" {
                negate_numbers(&mut element, &accessor["componentType"]);
            }
            elements.extend(element);
        }
        // Vertices begin at multiples of four bytes.
        let stride = size.next_multiple_of(4);
        let mut bytes = vec![0; elements.len() / size * stride];
        for (to, from) in bytes.chunks_mut(stride).zip(elements.chunks(size)) {
            to[..size].copy_from_slice(from);
        }
        let view = file.append_view(&bytes, Some(ARRAY_BUFFER));
        file.json["bufferViews"][view]["byteStride"] = stride.into();
        if let Some(entries) = accessor.as_object_mut() {
            entries.remove("sparse");
            entries.remove("byteOffset");
        }
        accessor["bufferView"] = view.into();
        accessor["count"] = (elements.len() / size).into();
        *index = file.append_entry("accessors", accessor).into();
    }
    Ok(())
}

fn negate_numbers(element: &mut [u8], component: &Value) {
    match component.as_u64() {
        Some(5126) => element.chunks_mut(4).for_each(|number| number[3] ^= 0x80),
        Some(5122) => element.chunks_mut(2).for_each(|number| {
            let negative = i16::from_le_bytes([number[0], number[1]]).saturating_neg();
            number.copy_from_slice(&negative.to_le_bytes());
        }),
        _ => element
            .iter_mut()
            .for_each(|byte| *byte = (*byte as i8).saturating_neg() as u8),
    }
}

fn component_size(component: &Value) -> Option<usize> {
    match component.as_u64()? {
        5120 | 5121 => Some(1),
        5122 | 5123 => Some(2),
        5125 | 5126 => Some(4),
        _ => None,
    }
}

/// Returns the bytes of an accessor's element.
fn element_size(accessor: &Value) -> Option<usize> {
    let count = match accessor["type"].as_str()? {
        "SCALAR" => 1,
        "VEC2" => 2,
        "VEC3" => 3,
        "VEC4" => 4,
        _ => return None,
    };
    Some(count * component_size(&accessor["componentType"])?)
}

/// Returns the elements of an accessor without gaps; none if it is damaged.
fn read_elements(file: &SceneFile, accessor: &Value, size: usize) -> Option<Vec<u8>> {
    let count = index_at(accessor, "count")?;
    let sparse = &accessor["sparse"];
    let mut elements = match accessor["bufferView"].is_null() {
        true if sparse.is_null() => return None,
        true => vec![0; size.checked_mul(count)?],
        false => read_view(file, accessor, count, size)?,
    };
    if !sparse.is_null() {
        let count = index_at(sparse, "count")?;
        let width = component_size(value_at(sparse, &["indices", "componentType"]))?;
        let places = read_view(file, &sparse["indices"], count, width)?;
        let values = read_view(file, &sparse["values"], count, size)?;
        for (place, value) in places.chunks(width).zip(values.chunks(size)) {
            let place = place.iter().rev().fold(0, |all, byte| all << 8 | usize::from(*byte));
            let start = place.checked_mul(size)?;
            elements
                .get_mut(start..start.checked_add(size)?)?
                .copy_from_slice(value);
        }
    }
    Some(elements)
}

/// Returns `count` elements of `size` bytes of the buffer view that `part` names, without gaps.
fn read_view(file: &SceneFile, part: &Value, count: usize, size: usize) -> Option<Vec<u8>> {
    let view = file.json["bufferViews"].get(index_at(part, "bufferView")?)?;
    let start = index_at(view, "byteOffset").unwrap_or(0);
    let start = start.checked_add(index_at(part, "byteOffset").unwrap_or(0))?;
    let stride = index_at(view, "byteStride")
        .filter(|stride| *stride > 0)
        .unwrap_or(size);
    let buffer = file.buffers.get(index_at(view, "buffer")?)?;
    let mut elements = Vec::new();
    for k in 0..count {
        let at = start.checked_add(k.checked_mul(stride)?)?;
        elements.extend(buffer.get(at..at.checked_add(size)?)?);
    }
    Some(elements)
}

/// Attaches the lightmap to the materials of all placed primitives.
fn attach_materials(file: &mut SceneFile, placed: &[PlacedPrimitive], scene: &Scene, lightmap: &Value) {
    let lit: BTreeSet<(usize, usize)> = placed.iter().map(|p| (p.mesh, p.number)).collect();
    let mut elsewhere = BTreeSet::new();
    for (mesh, entry) in file.json["meshes"].as_array().into_iter().flatten().enumerate() {
        let primitives = entry["primitives"].as_array().into_iter().flatten().enumerate();
        let unlit = primitives.filter(|(number, _)| !lit.contains(&(mesh, *number)));
        elsewhere.extend(unlit.filter_map(|(_, primitive)| index_at(primitive, "material")));
    }
    let mut materials: BTreeMap<(Option<usize>, bool), usize> = BTreeMap::new();
    for primitive in placed {
        let written = primitive_json(file, primitive);
        let own = index_at(written, "material");
        let is_coloured = own.is_none() && !written["attributes"]["COLOR_0"].is_null();
        let material = *materials.entry((own, is_coloured)).or_insert_with(|| match own {
            Some(own) if !elsewhere.contains(&own) => own,
            Some(own) => {
                let copy = file.json["materials"][own].clone();
                file.append_entry("materials", copy)
            }
            // The default material is metal, which a lightmap does not light.
            None => {
                let face = primitive.triangles.first().filter(|_| !is_coloured);
                let [r, g, b] = face.map_or([1.0; 3], |t| scene.faces[t.face as usize].reflectance.to_array());
                let surface = json!({ "baseColorFactor": [r, g, b, 1.0], "metallicFactor": 0.0 });
                file.append_entry("materials", json!({ "pbrMetallicRoughness": surface }))
            }
        });
        file.json["meshes"][primitive.mesh]["primitives"][primitive.number]["material"] = material.into();
        let material = &mut file.json["materials"][material];
        material["extensions"][LIGHTMAP_EXTENSION] = lightmap.clone();
        let is_two_sided = primitive
            .triangles
            .iter()
            .any(|t| scene.faces[t.face as usize].partner.is_some());
        if let Some(entries) = material.as_object_mut().filter(|_| is_two_sided) {
            entries.remove("doubleSided");
        }
    }
}

/// Encodes the document.
fn encode_glb(mut file: SceneFile) -> Result<Vec<u8>> {
    let mut bytes = file.buffers.swap_remove(0);
    bytes.resize(bytes.len().next_multiple_of(4), 0);
    file.json["buffers"] = json!([{ "byteLength": bytes.len() }]);
    let glb = Glb {
        header: Header {
            magic: *b"glTF",
            version: 2,
            length: 0,
        },
        json: Cow::Owned(file.json.to_string().into_bytes()),
        bin: Some(Cow::Owned(bytes)),
    };
    glb.to_vec()
        .map_err(|error| Error::bad_input(&file.path, "", format!("cannot become one file: {error}")))
}
