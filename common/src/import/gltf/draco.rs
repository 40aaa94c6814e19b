//! Decodes meshes that are compressed by Draco (KHR_draco_mesh_compression). Their accessors then read the decoded values
//! from buffers of their own, as those of any other mesh.

use super::document::{GltfDocument, GltfResult};
use crate::import::builder::MAX_FACES;
use draco_core::{DecodeLimits, DecoderBuffer, Mesh, MeshDecoder};
use gltf::json::Index;
use gltf::json::accessor::{ComponentType, GenericComponentType};
use gltf::json::validation::Checked;
use serde_json::{Value, json};
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Largest number of bytes of a decoded mesh: positions, normals and two sets of coordinates of the most vertices.
const MAX_MESH_BYTES: u64 = 3 * MAX_FACES as u64 * 40;

/// Decodes every compressed primitive.
///
/// Errors: place and message of a primitive that cannot be decoded.
pub fn decode_meshes(document: &mut GltfDocument) -> Result<(), (String, String)> {
    let json = document.json.clone();
    for (m, mesh) in json["meshes"].as_array().into_iter().flatten().enumerate() {
        for (p, primitive) in mesh["primitives"].as_array().into_iter().flatten().enumerate() {
            if let Some(compressed) = primitive["extensions"].get("KHR_draco_mesh_compression") {
                let decoded = decode_primitive(document, primitive, compressed);
                decoded.map_err(|message| (format!("mesh {m} primitive {p}"), message))?;
            }
        }
    }
    Ok(())
}

/// Decodes a primitive and redirects its accessors to the decoded values.
fn decode_primitive(document: &mut GltfDocument, primitive: &Value, compressed: &Value) -> GltfResult<()> {
    let view = read_index(&compressed["bufferView"]).ok_or("has compressed data without a buffer view")?;
    let mesh = decode_mesh(document.view_bytes(Index::new(view))?)?;
    for (name, id) in compressed["attributes"].as_object().into_iter().flatten() {
        let accessor = read_index(&primitive["attributes"][name]);
        let values = read_index(id).and_then(|id| mesh.attribute_by_unique_id(id));
        let (Some(accessor), Some(values)) = (accessor, values) else {
            return Err(format!("has no compressed {name}"));
        };
        let components = match document.json["accessors"][accessor as usize]["type"].as_str() {
            Some("VEC2") => 2,
            Some("VEC3") => 3,
            Some("VEC4") => 4,
            // Of no use here: a weight, for example.
            _ => continue,
        };
        let one = match document.json["accessors"][accessor as usize]["normalized"].as_bool() {
            Some(true) if values.data_type().byte_length() == 1 => f32::from(u8::MAX),
            Some(true) if values.data_type().byte_length() == 2 => f32::from(u16::MAX),
            _ => 1.0,
        };
        let numbers = values.read_f32s(mesh.num_points(), components).into_iter();
        let bytes = numbers.flat_map(|x| (x / one).to_le_bytes()).collect();
        redirect_accessor(document, accessor, ComponentType::F32, mesh.num_points(), bytes)?;
    }
    let indices = read_index(&primitive["indices"]).ok_or("is compressed and has no indices")?;
    let corners = mesh.faces().as_flattened().iter();
    let bytes = corners.flat_map(|point| point.0.to_le_bytes()).collect();
    redirect_accessor(document, indices, ComponentType::U32, 3 * mesh.num_faces(), bytes)
}

fn read_index(value: &Value) -> Option<u32> {
    value.as_u64().and_then(|index| u32::try_from(index).ok())
}

/// Decodes a mesh. A panic of the decoder counts as damage.
fn decode_mesh(bytes: &[u8]) -> GltfResult<Mesh> {
    let limits = DecodeLimits::default()
        .with_max_faces(MAX_FACES as u64)
        .with_max_points(3 * MAX_FACES as u64)
        .with_max_decoded_bytes(MAX_MESH_BYTES);
    let decode = || {
        let mut mesh = Mesh::new();
        let mut buffer = DecoderBuffer::new(bytes).with_limits(limits);
        MeshDecoder::new().decode(&mut buffer, &mut mesh).map(|()| mesh)
    };
    match catch_unwind(AssertUnwindSafe(decode)) {
        Ok(Ok(mesh)) => Ok(mesh),
        Ok(Err(error)) => Err(format!("its Draco data cannot be decoded: {error}")),
        Err(_) => Err("its Draco data is damaged".into()),
    }
}

/// Lets an accessor read `count` elements of `bytes`, a new buffer.
fn redirect_accessor(
    document: &mut GltfDocument,
    accessor: u32,
    component: ComponentType,
    count: usize,
    bytes: Vec<u8>,
) -> GltfResult<()> {
    let view = json!({ "buffer": document.buffers.len(), "byteLength": bytes.len() });
    let view = serde_json::from_value(view).map_err(|error| error.to_string())?;
    let number = document.root.buffer_views.len() as u32;
    let entry = document.root.accessors.get_mut(accessor as usize);
    let entry = entry.ok_or_else(|| format!("accessor {accessor} does not exist"))?;
    (entry.buffer_view, entry.byte_offset, entry.sparse) = (Some(Index::new(number)), None, None);
    entry.component_type = Checked::Valid(GenericComponentType(component));
    (entry.count, entry.normalized) = (count.into(), false);
    document.root.buffer_views.push(view);
    document.buffers.push(bytes);
    Ok(())
}
