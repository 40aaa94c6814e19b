//! glTF extensions: supported and refused ones.

use super::files::{Gltf, corners, notes, square};
use common::scene::Scene;
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
fn unsupported_lights_and_extensions_are_refused() {
    let sun = square_under_light(json!({"type": "directional", "name": "sun"})).error();
    assert!(sun.starts_with("a.glb: light 0: is directional"), "{sun}");
    for (name, instead) in [
        ("KHR_draco_mesh_compression", "Compression off"),
        ("EXT_meshopt_compression", "export without meshopt"),
        ("KHR_texture_basisu", "PNG or JPEG"),
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
