//! Import of each glTF feature.

use super::files::{Folder, Gltf, base64, corners, notes, square};
use common::import::ImportOptions;
use common::scene::{Scene, Shape};
use glam::{DVec3, Vec3};
use serde_json::json;
use std::f32::consts::PI;

fn scene(gltf: &Gltf) -> Scene {
    gltf.load().expect("a scene")
}

/// Returns the square's triangles.
fn square_triangles() -> Vec<Vec<[f64; 3]>> {
    vec![
        vec![[0., 0., 0.], [1., 0., 0.], [1., 1., 0.]],
        vec![[0., 0., 0.], [1., 1., 0.], [0., 1., 0.]],
    ]
}

fn float_bytes(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

#[test]
fn indexed_mesh_becomes_triangles() {
    let scene = scene(&square());
    assert_eq!(corners(&scene), square_triangles());
    for face in &scene.faces {
        assert_eq!(
            (face.name.as_str(), face.shape, face.input_face),
            ("square", Shape::Triangle, None)
        );
        assert_eq!(
            (face.reflectance, face.emission),
            (Vec3::new(0.5, 0.25, 0.125), Vec3::ZERO)
        );
        assert_eq!(face.vector_area(), DVec3::Z * 0.5);
    }
    assert_eq!(scene.notes, [""; 0]);
}

#[test]
fn quads_are_joined_on_request() {
    let options = ImportOptions {
        join_quads: true,
        ..Default::default()
    };
    let joined = square().load_with(&options).expect("a scene");
    assert_eq!(
        corners(&joined),
        [[[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]]]
    );
    assert_eq!(joined.faces[0].input_face, None);
    let apart = square()
        .view(&float_bytes(&[0., 0., 0., 1., 0., 0., 1., 1., 0., 0., 1., 0.1]))
        .set("/accessors/0/bufferView", json!(2));
    assert_eq!(apart.load_with(&options).expect("a scene").faces.len(), 2, "not planar");
}

#[test]
fn buffers_are_read_from_uri_file_and_glb() {
    let gltf = square();
    let uri = |uri: String| gltf.clone().set("/buffers/0/uri", json!(uri)).json.to_string();
    let data = uri(format!("data:application/octet-stream;base64,{}", base64(&gltf.bytes)));
    let folder = Folder::new()
        .with("a.gltf", format!("\u{feff}\n{data}"))
        .with("b.gltf", uri("the%20bytes.bin".into()))
        .with("the bytes.bin", &gltf.bytes)
        .with("c.txt", gltf.glb())
        .with("d.glb", [gltf.glb(), vec![1, 2, 3]].concat());
    for name in ["a.gltf", "b.gltf", "c.txt", "d.glb"] {
        assert_eq!(corners(&folder.load(name).expect(name)), square_triangles(), "{name}");
    }
}

#[test]
fn indices_of_8_and_32_bits_and_no_indices_are_read() {
    let indices: [u8; 6] = [0, 1, 2, 0, 2, 3];
    let wide: Vec<u8> = indices.iter().flat_map(|k| u32::from(*k).to_le_bytes()).collect();
    for (bytes, kind) in [(indices.to_vec(), 5121), (wide, 5125)] {
        let gltf = square()
            .view(&bytes)
            .set("/accessors/1/bufferView", json!(2))
            .set("/accessors/1/componentType", json!(kind));
        assert_eq!(corners(&scene(&gltf)), square_triangles());
    }
    let unindexed = square()
        .remove("/meshes/0/primitives/0/indices")
        .set("/accessors/0/count", json!(3));
    assert_eq!(corners(&scene(&unindexed)), square_triangles()[..1]);
}

#[test]
fn strips_and_fans_become_triangles() {
    let with = |mode: u32, order: [u16; 4]| {
        let bytes: Vec<u8> = order.iter().flat_map(|k| k.to_le_bytes()).collect();
        let gltf = square().view(&bytes).set(
            "/accessors/1",
            json!({"bufferView": 2, "componentType": 5123, "count": 4, "type": "SCALAR"}),
        );
        scene(&gltf.set("/meshes/0/primitives/0/mode", json!(mode)))
    };
    assert_eq!(corners(&with(6, [0, 1, 2, 3])), square_triangles());
    let strip = with(5, [0, 1, 3, 2]);
    assert_eq!(strip.faces.len(), 2);
    assert!(
        strip.faces.iter().all(|f| f.vector_area() == DVec3::Z * 0.5),
        "{:?}",
        corners(&strip)
    );
}

#[test]
fn interleaved_vertices_are_read() {
    // Normal and position alternate.
    let mut bytes = Vec::new();
    for p in [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]] {
        bytes.extend(float_bytes(&[0., 0., 1.]));
        bytes.extend(float_bytes(&p));
    }
    let gltf = square().view(&bytes).set("/bufferViews/2/byteStride", json!(24));
    let gltf = gltf
        .set("/accessors/0/bufferView", json!(2))
        .set("/accessors/0/byteOffset", json!(12));
    assert_eq!(corners(&scene(&gltf)), square_triangles());
}

#[test]
fn sparse_accessor_replaces_vertices() {
    // Vertices 1 and 3 are replaced.
    let gltf = square()
        .view(&[1, 3])
        .view(&float_bytes(&[2., 0., 0., 0., 2., 0.]))
        .set(
            "/accessors/0/sparse",
            json!({"count": 2, "indices": {"bufferView": 2, "componentType": 5121}, "values": {"bufferView": 3}}),
        );
    let expected = [
        [[0., 0., 0.], [2., 0., 0.], [1., 1., 0.]],
        [[0., 0., 0.], [1., 1., 0.], [0., 2., 0.]],
    ];
    assert_eq!(corners(&scene(&gltf)), expected);
    let zero_based = gltf.remove("/accessors/0/bufferView");
    let expected = [
        [[0., 0., 0.], [2., 0., 0.], [0., 0., 0.]],
        [[0., 0., 0.], [0., 0., 0.], [0., 2., 0.]],
    ];
    let on_lines = zero_based.clone().load().map_err(|e| e.to_string());
    assert!(on_lines.is_err_and(|e| e.ends_with("none of its 2 faces has an area")));
    let with_square = zero_based
        .set(
            "/accessors/-",
            json!({"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"}),
        )
        .set(
            "/meshes/0/primitives/-",
            json!({"attributes": {"POSITION": 2}, "indices": 1, "material": 0}),
        );
    assert_eq!(corners(&scene(&with_square))[..2], expected);
}

#[test]
fn node_transforms_apply_to_children() {
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let gltf = square()
        .set("/nodes/0/translation", json!([0, 0, 1]))
        .set("/nodes/0/name", json!("leaf"))
        .set("/nodes/-", json!({"children": [0], "scale": [2, 3, 4]}))
        // A quarter turn about z, then 10 along x.
        .set(
            "/nodes/-",
            json!({"children": [1], "rotation": [0, 0, half, half], "translation": [10, 0, 0]}),
        )
        .set("/scenes/0/nodes", json!([2]));
    let scene = scene(&gltf);
    let expected = [DVec3::new(10., 0., 4.), DVec3::new(10., 2., 4.), DVec3::new(7., 2., 4.)];
    for (found, expected) in scene.faces[0].outline().iter().zip(expected) {
        assert!(found.distance(expected) < 1e-14, "{found} instead of {expected}");
    }
    assert_eq!(scene.faces[0].name, "leaf");
    let matrix = square().set(
        "/nodes/0/matrix",
        json!([0, 2, 0, 0, -3, 0, 0, 0, 0, 0, 4, 0, 10, 0, 4, 1]),
    );
    let found = corners(&super::gltf::scene(&matrix));
    assert_eq!(found[0], [[10., 0., 4.], [10., 2., 4.], [7., 2., 4.]]);
}

#[test]
fn mirroring_transform_keeps_fronts() {
    let mirrored = scene(&square().set("/nodes/0/scale", json!([-1, 1, 1])));
    assert!(
        mirrored.faces.iter().all(|f| f.vector_area() == DVec3::Z * 0.5),
        "{:?}",
        corners(&mirrored)
    );
    let turned = scene(&square().set("/nodes/0/scale", json!([-1, 1, -1])));
    assert!(
        turned.faces.iter().all(|f| f.vector_area() == DVec3::NEG_Z * 0.5),
        "a half turn is no mirror"
    );
}

#[test]
fn default_scene_is_imported() {
    let two = square()
        .set("/nodes/-", json!({"mesh": 0, "translation": [5, 0, 0]}))
        .set("/scenes/-", json!({"nodes": [1]}));
    let first_x = |gltf: &Gltf| scene(gltf).faces.iter().map(|f| f.corners[0].x).collect::<Vec<_>>();
    assert_eq!(first_x(&two), [0., 0.]);
    assert_eq!(first_x(&two.clone().set("/scene", json!(1))), [5., 5.]);
    assert_eq!(first_x(&two.clone().remove("/scene")), [0., 0.], "the first scene");
    let none = two
        .remove("/scene")
        .remove("/scenes")
        .set("/nodes/-", json!({"children": [1], "translation": [1, 0, 0]}));
    assert_eq!(first_x(&none), [0., 0., 6., 6.], "all nodes, each once");
}

#[test]
fn factors_become_reflectance_and_emission() {
    let gltf = square().set("/materials/0/emissiveFactor", json!([1, 0.5, 0]));
    assert_eq!(scene(&gltf).faces[1].emission, Vec3::new(1., 0.5, 0.) * PI);
    let strength = json!({"KHR_materials_emissive_strength": {"emissiveStrength": 4}});
    let strong = gltf
        .set("/materials/0/extensions", strength)
        .set("/extensionsRequired", json!(["KHR_materials_emissive_strength"]));
    assert_eq!(scene(&strong).faces[1].emission, Vec3::new(4., 2., 0.) * PI);
}

#[test]
fn default_material_is_lowered_to_095() {
    for (pointer, name) in [("/materials/0", "0"), ("/materials/0/pbrMetallicRoughness", "grey")] {
        let scene = scene(&square().set(pointer, json!({})));
        assert_eq!(scene.faces[0].reflectance, Vec3::splat(0.95));
        let note = format!("materials {name} reflect all light: taken as 0.95");
        assert_eq!(notes(&scene, &note).len(), 1, "{:?}", scene.notes);
    }
}

#[test]
fn face_without_material_is_grey() {
    let scene = scene(&square().remove("/meshes/0/primitives/0/material"));
    assert_eq!(scene.faces[0].reflectance, Vec3::splat(0.7));
    assert_eq!(
        scene.notes,
        ["2 faces without material: reflectance 0.7, no emission (1, 2)"]
    );
}

#[test]
fn texture_times_zero_factor_is_not_read() {
    let gltf = square().set("/materials/0/emissiveTexture", json!({"index": 0}));
    assert_eq!(scene(&gltf).faces[0].emission, Vec3::ZERO);
}

#[test]
fn unsupported_features_are_noted() {
    let expect = |gltf: Gltf, words: &str| {
        let scene = scene(&gltf);
        assert_eq!(
            (scene.faces.len(), notes(&scene, words).len()),
            (2, 1),
            "{words}: {:?}",
            scene.notes
        );
    };
    let primitive = |mode: u32| json!({"attributes": {"POSITION": 0}, "mode": mode});
    for mode in 0..4 {
        expect(
            square().set("/meshes/0/primitives/-", primitive(mode)),
            "1 primitives of points or lines left out",
        );
    }
    expect(
        square().set("/materials/0/doubleSided", json!(true)),
        "double-sided, but its backs are black: import it two-sided: grey",
    );
    let see_through = square().set("/materials/0/alphaMode", json!("BLEND"));
    assert_eq!(scene(&see_through).notes, [""; 0], "opaque in fact");
    expect(
        see_through.set("/materials/0/pbrMetallicRoughness/baseColorFactor/3", json!(0.5)),
        "transparent, taken as opaque: grey",
    );
    expect(
        square().set("/meshes/0/primitives/0/targets", json!([{"POSITION": 0}])),
        "morph targets",
    );
    expect(
        square().set("/materials/0/extensions", json!({"KHR_materials_unlit": {}})),
        "unlit, taken as diffuse: grey",
    );
}

#[test]
fn unused_invalid_parts_are_ignored() {
    let primitive = "/meshes/0/primitives/0";
    let odd = square()
        .set(&format!("{primitive}/attributes/_CUSTOM"), json!(99))
        .set(&format!("{primitive}/attributes/NORMAL"), json!(99))
        .set("/materials/-", json!({"name": "unused, default white"}))
        .remove("/accessors/0/min");
    assert_eq!(corners(&scene(&odd)), square_triangles());
}

#[test]
fn deeply_nested_nodes_are_imported() {
    let depth = 50_000;
    let mut gltf = square();
    let nodes: Vec<_> = (1..depth).map(|k| json!({"children": [k - 1]})).collect();
    gltf.json["nodes"].as_array_mut().expect("nodes").extend(nodes);
    assert_eq!(scene(&gltf.set("/scenes/0/nodes", json!([depth - 1]))).faces.len(), 2);
}

#[test]
fn normals_are_kept_and_reordered_under_mirroring() {
    let bent = [0.0f32, 0.6, 0.8];
    let normals: Vec<f32> = [[0.0, 0.0, 1.0], bent, [0.0, 0.0, 1.0], bent].concat();
    let smooth = square().attribute("NORMAL", "VEC3", &normals);
    let bent = Vec3::from(bent);
    let found = scene(&smooth).faces[0].corner_normals;
    assert_eq!(found, Some([Vec3::Z, bent, Vec3::Z, Vec3::Z]));
    let mirrored = scene(&smooth.clone().set("/nodes/0/scale", json!([-1, 1, 1])));
    assert_eq!(mirrored.faces[0].corner_normals, Some([Vec3::Z, Vec3::Z, bent, bent]));
    let options = ImportOptions {
        join_quads: true,
        ..Default::default()
    };
    let joined = smooth.load_with(&options).expect("a scene");
    assert_eq!(joined.faces[0].corner_normals, Some([Vec3::Z, bent, Vec3::Z, bent]));
    // Unreadable normals count as missing; the faces are imported.
    let broken = smooth.set("/accessors/2/count", json!(400));
    assert_eq!(scene(&broken).faces[0].corner_normals, None);
}

#[test]
fn lightmap_coordinates_are_kept_on_request() {
    let options = ImportOptions {
        charts: true,
        join_quads: true,
        ..Default::default()
    };
    let places = [0., 0., 0.5, 0., 0.5, 0.25, 0., 0.25];
    let charted = square().attribute("TEXCOORD_1", "VEC2", &places);
    let kept = charted.load_with(&options).expect("a scene");
    let of = |k: usize| kept.faces[k].lightmap_corners.map(|chart| chart.map(|p| p.to_array()));
    assert_eq!(of(0), Some([[0., 0.], [0.5, 0.], [0.5, 0.25]]));
    assert_eq!(of(1), Some([[0., 0.], [0.5, 0.25], [0., 0.25]]));
    // Mirroring reverses the triangle and its lightmap coordinates.
    let mirrored = charted.clone().set("/nodes/0/scale", json!([-1, 1, 1]));
    let turned = mirrored.load_with(&options).expect("a scene");
    let chart = turned.faces[0]
        .lightmap_corners
        .map(|chart| chart.map(|p| p.to_array()));
    assert_eq!(chart, Some([[0., 0.], [0.5, 0.25], [0.5, 0.]]));

    assert_eq!(scene(&charted).faces[0].lightmap_corners, None, "not requested");
    let first = square().attribute("TEXCOORD_0", "VEC2", &places);
    let refused = first.load_with(&options).map(|scene| scene.faces.len());
    let told = refused.map_err(|error| error.to_string());
    assert!(
        matches!(&told, Err(told) if told.contains("mesh 0 primitive 0: has no TEXCOORD_1")),
        "{told:?}"
    );
}
