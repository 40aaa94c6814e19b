//! glTF extensions: supported and refused ones.

use super::files::{Gltf, assert_begins, corners, float_bytes, notes, square};
use common::import::ImportOptions;
use common::scene::Scene;
use draco_core::{DataType, EncoderBuffer, EncoderOptions, GeometryAttributeType, Mesh, MeshEncoder, PointAttribute};
use glam::{DVec3, Vec3};
use serde_json::json;
use std::f64::consts::PI;

/// Returns the square with integer positions, padded to four components.
fn quantized_square(bytes: &[u8], kind: u32, normalized: bool) -> Gltf {
    let stride = bytes.len() / 4;
    square()
        .view(bytes)
        .set("/bufferViews/2/byteStride", json!(stride))
        .set(
            "/accessors/0",
            json!({"bufferView": 2, "componentType": kind, "count": 4, "type": "VEC3", "normalized": normalized}),
        )
        .set("/extensionsRequired", json!(["KHR_mesh_quantization"]))
}

#[test]
fn quantized_positions_are_decoded() {
    let expected = corners(&square().scene());
    let corner = |one: i16| [[0, 0], [one, 0], [one, one], [0, one]].map(|[x, y]| [x, y, 0, 99]);
    let bytes = |one: i16| corner(one).as_flattened().iter().map(|v| *v as u8).collect::<Vec<_>>();
    let words = |one: i16| {
        corner(one)
            .as_flattened()
            .iter()
            .flat_map(|v| v.to_le_bytes())
            .collect()
    };
    for (bytes, kind, normalized, steps) in [
        (bytes(1), 5120, false, 1.0),
        (bytes(127), 5120, true, 127.0),
        (bytes(1), 5121, false, 1.0),
        (bytes(255), 5121, true, 255.0),
        (words(1), 5122, false, 1.0),
        (words(32767), 5122, true, 32767.0),
        (words(1), 5123, false, 1.0),
        (words(-1), 5123, true, 65535.0),
    ] {
        let scene = quantized_square(&bytes, kind, normalized).scene();
        assert_eq!(corners(&scene), expected, "{kind} {normalized}");
        assert_eq!(scene.faces[0].rounding, 0.5 / steps, "{kind} {normalized}");
    }
    // −128 is no less than −1.
    let low = [0x80_u8, 0, 0, 0, 127, 0, 0, 0, 127, 127, 0, 0, 0, 127, 0, 0];
    let low = quantized_square(&low, 5120, true).scene();
    assert_eq!(low.faces[0].corners[0].x, -1.0);
}

/// Returns the square with a light of its own node above it.
fn square_under_light(light: serde_json::Value) -> Gltf {
    square()
        .set("/extensions", json!({"KHR_lights_punctual": {"lights": [light]}}))
        .set("/extensionsRequired", json!(["KHR_lights_punctual"]))
        .set(
            "/nodes/-",
            json!({"translation": [0.5, 0.5, 1], "extensions": {"KHR_lights_punctual": {"light": 0}}}),
        )
        .set("/scenes/0/nodes", json!([0, 1]))
}

fn emitted_power(scene: &Scene) -> DVec3 {
    let faces = scene.faces.iter();
    faces.map(|f| f.emission.as_dvec3() * f.area()).sum()
}

#[test]
fn point_and_spot_lights_become_lamps_of_equal_power() {
    let point = square_under_light(json!({"type": "point", "name": "bulb", "intensity": 2, "color": [1, 0.5, 0]}));
    let lit = point.scene();
    assert_eq!(lit.faces.len(), 22);
    let expected = 4.0 * PI * 2.0 * DVec3::new(1.0, 0.5, 0.0);
    assert!((emitted_power(&lit) - expected).length() < 1e-5 * expected.length());
    for lamp in &lit.faces[2..] {
        assert_eq!((lamp.name.as_str(), lamp.reflectance), ("bulb", Vec3::ZERO));
        let out = lamp.corners[0] - DVec3::new(0.5, 0.5, 1.0);
        assert!(out.dot(lamp.vector_area()) > 0.0 && out.length() < 0.01);
    }
    assert_eq!(notes(&lit, "a candela taken as 1 W/sr: bulb").len(), 1);
    let spot =
        square_under_light(json!({"type": "spot", "spot": {"outerConeAngle": PI / 2.0, "innerConeAngle": PI / 2.0}}));
    let lit = spot.scene();
    assert_eq!(lit.faces.len(), 3);
    assert!((emitted_power(&lit) - DVec3::splat(2.0 * PI)).length() < 1e-5);
    assert!(lit.faces[2].vector_area().normalize().z < -0.999, "it looks along −z");
    assert_eq!(notes(&lit, "without a cone: light 0").len(), 1);
    // Falling off from the axis on, it has a third of the power; a turned node turns it.
    let soft = square_under_light(json!({"type": "spot", "spot": {"outerConeAngle": PI / 2.0, "innerConeAngle": 0}}))
        .set("/nodes/1/rotation", json!([0.5, 0.5, 0.5, 0.5]));
    let lit = soft.scene();
    assert!((emitted_power(&lit) - DVec3::splat(2.0 * PI / 3.0)).length() < 1e-5);
    assert!(lit.faces[2].vector_area().normalize().x < -0.999, "it looks along −x");
}

#[test]
fn directional_lights_become_suns() {
    let lit = square_under_light(json!({"type": "directional", "name": "noon", "intensity": 3, "color": [1, 0.5, 0]}));
    let scene = lit.set("/nodes/1/rotation", json!([0.5, 0.5, 0.5, 0.5])).scene();
    let suns = &scene.sky.as_ref().expect("a sky").suns;
    // The light shines along −x of the scene.
    assert!(
        suns.len() == 1 && (suns[0].direction - DVec3::X).length() < 1e-6,
        "{suns:?}"
    );
    assert_eq!(suns[0].irradiance, Vec3::new(3.0, 1.5, 0.0));
    assert_eq!(notes(&scene, "a lux taken as 1 W/m²: noon").len(), 1);
}

#[test]
fn unsupported_lights_and_extensions_are_refused() {
    let flat = square_under_light(json!({"type": "directional"})).set("/nodes/1/scale", json!([0, 0, 0]));
    assert!(
        flat.error().starts_with("a.glb: light 0: has no direction"),
        "{}",
        flat.error()
    );
    let bright = square_under_light(json!({"type": "directional", "intensity": 1e30}));
    assert!(bright.error().contains("cannot be solved"), "{}", bright.error());
    for (name, instead) in [
        ("EXT_meshopt_compression", "npx @gltf-transform/cli copy a.glb OUT.glb"),
        (
            "KHR_texture_basisu",
            "npx @gltf-transform/cli ktxdecompress a.glb OUT.glb",
        ),
        ("EXT_texture_avif", "npx @gltf-transform/cli webp a.glb OUT.glb"),
        ("KHR_something", "export without it"),
    ] {
        let error = square().set("/extensionsRequired", json!([name])).error();
        assert!(error.contains(name) && error.contains(instead), "{error}");
        // An optional extension only leads to a note.
        let used = json!([name, "KHR_materials_unlit"]);
        let read = square().set("/extensionsUsed", used).scene();
        let expected = format!("extensions that are not read: {name}");
        assert_eq!(notes(&read, "extensions"), [expected]);
    }
}

/// Returns the square with positions and colours compressed by Draco, and the compressed bytes.
fn compressed_square(sequential: bool) -> (Gltf, Vec<u8>) {
    let attribute = |kind, id, count: usize, values: &[f32]| {
        let mut attribute = PointAttribute::new();
        attribute.init(kind, count as u8, DataType::Float32, false, 4);
        attribute.buffer_mut().write(0, &float_bytes(values));
        attribute.set_unique_id(id);
        attribute
    };
    let (mut mesh, colours) = (Mesh::new(), [0.5, 0.25, 0.125].repeat(4));
    mesh.set_num_points(4);
    let corners = [0., 0., 0., 1., 0., 0., 1., 1., 0., 0., 1., 0.];
    mesh.add_attribute(attribute(GeometryAttributeType::Position, 0, 3, &corners));
    mesh.add_attribute(attribute(GeometryAttributeType::Color, 1, 3, &colours));
    mesh.set_num_faces(2);
    mesh.set_faces_from_flat_indices(&[0, 1, 2, 0, 2, 3]);
    let (mut encoder, mut options, mut out) = (MeshEncoder::new(), EncoderOptions::new(), EncoderBuffer::new());
    encoder.set_mesh(mesh);
    options.set_encoding_method(if sequential { 0 } else { 1 });
    encoder.encode(&options, &mut out).expect("a compressed square");
    let bytes = out.data().to_vec();
    let gltf = square()
        .view(&bytes)
        .set("/extensionsRequired", json!(["KHR_draco_mesh_compression"]))
        .set(
            "/accessors/-",
            json!({"componentType": 5126, "count": 4, "type": "VEC3"}),
        )
        .set("/meshes/0/primitives/0/attributes/COLOR_0", json!(2))
        .set(
            "/meshes/0/primitives/0/extensions",
            json!({"KHR_draco_mesh_compression": {"bufferView": 2, "attributes": {"POSITION": 0, "COLOR_0": 1}}}),
        )
        .remove("/accessors/0/bufferView")
        .remove("/accessors/1/bufferView")
        .remove("/meshes/0/primitives/0/material");
    (gltf, bytes)
}

#[test]
fn draco_meshes_are_decoded() {
    for sequential in [false, true] {
        let scene = compressed_square(sequential).0.scene();
        let area: DVec3 = scene.faces.iter().map(|face| face.vector_area()).sum();
        assert!(scene.faces.len() == 2 && (area - DVec3::Z).length() < 1e-6, "{area}");
        let grey = Vec3::new(0.5, 0.25, 0.125);
        for face in &scene.faces {
            assert!((face.reflectance - grey).length() < 0.01, "{}", face.reflectance);
        }
    }
}

#[test]
fn damaged_draco_meshes_are_refused() {
    let (whole, bytes) = compressed_square(false);
    let place = "a.glb: mesh 0 primitive 0: ";
    let inside = "/meshes/0/primitives/0/extensions/KHR_draco_mesh_compression";
    for (pointer, value, expected) in [
        ("/bufferView", json!(7), "uses buffer view 7, which does not exist"),
        ("/bufferView", json!(-1), "has compressed data without a buffer view"),
        ("/bufferView", json!(0), "its Draco data cannot be decoded"),
        ("/attributes/POSITION", json!(9), "has no compressed POSITION"),
    ] {
        let gltf = whole.clone().set(&format!("{inside}{pointer}"), value);
        assert_begins(&gltf.error(), &format!("{place}{expected}"));
    }
    let indices = whole.clone().remove("/meshes/0/primitives/0/indices");
    assert_begins(&indices.error(), &format!("{place}is compressed and has no indices"));
    // Each byte is damaged once: a message or other faces, but no panic.
    for k in 0..bytes.len() {
        let mut gltf = whole.clone();
        gltf.bytes[60 + k] ^= 0x55;
        let _ = gltf.load_with(&ImportOptions::default());
        let cut_off = whole.clone().set("/bufferViews/2/byteLength", json!(k));
        assert!(cut_off.load_with(&ImportOptions::default()).is_err(), "{k} bytes");
    }
}
