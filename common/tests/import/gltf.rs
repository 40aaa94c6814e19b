//! Import of each glTF feature.

use super::files::{Folder, Gltf, corners, float_bytes, join_quads, square};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use common::import::ImportOptions;
use common::precision::UNIT_ROUNDOFF;
use common::scene::Shape;
use glam::{DVec3, Vec3};
use serde_json::json;
use std::f32::consts::PI;

/// Returns the square's triangles.
fn square_triangles() -> Vec<Vec<[f64; 3]>> {
    vec![
        vec![[0., 0., 0.], [1., 0., 0.], [1., 1., 0.]],
        vec![[0., 0., 0.], [1., 1., 0.], [0., 1., 0.]],
    ]
}

#[test]
fn indexed_mesh_becomes_triangles() {
    let scene = square().scene();
    assert_eq!(corners(&scene), square_triangles());
    for face in &scene.faces {
        assert_eq!((face.name.as_str(), face.shape), ("square", Shape::Triangle));
        assert_eq!(face.input_face, None);
        assert_eq!(face.reflectance, Vec3::new(0.5, 0.25, 0.125));
        assert_eq!(face.emission, Vec3::ZERO);
        assert_eq!(face.vector_area(), DVec3::Z * 0.5);
    }
    assert_eq!(scene.notes, [""; 0]);
}

#[test]
fn quads_are_joined_on_request() {
    let joined = square().load_with(&join_quads()).expect("a scene");
    let quad = [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]];
    assert_eq!(corners(&joined), [quad]);
    assert_eq!(joined.faces[0].input_face, None);
    let apart = square()
        .view(&float_bytes(&[0., 0., 0., 1., 0., 0., 1., 1., 0., 0., 1., 0.1]))
        .set("/accessors/0/bufferView", json!(2));
    assert_eq!(
        apart.load_with(&join_quads()).expect("a scene").faces.len(),
        2,
        "not planar"
    );
}

#[test]
fn buffers_are_read_from_uri_file_and_glb() {
    let gltf = square();
    let uri = |uri: String| gltf.clone().set("/buffers/0/uri", json!(uri)).json.to_string();
    let data = uri(format!(
        "data:application/octet-stream;base64,{}",
        STANDARD.encode(&gltf.bytes)
    ));
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

/// Returns the square with an accessor that lies in a new buffer view, its fields replaced.
fn with_accessor(accessor: usize, bytes: &[u8], fields: serde_json::Value) -> Gltf {
    let mut gltf = square().view(bytes);
    gltf.json["accessors"][accessor]["bufferView"] = json!(2);
    for (name, value) in fields.as_object().expect("fields") {
        gltf.json["accessors"][accessor][name] = value.clone();
    }
    gltf
}

#[test]
fn same_square_is_read_in_other_layouts() {
    let indices: [u8; 6] = [0, 1, 2, 0, 2, 3];
    let wide: Vec<u8> = indices.iter().flat_map(|k| u32::from(*k).to_le_bytes()).collect();
    // Normal and position alternate.
    let place = [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]];
    let interleaved = float_bytes(place.map(|[x, y, z]| [0., 0., 1., x, y, z]).as_flattened());
    let fan = with_accessor(1, &[0, 1, 2, 3], json!({"componentType": 5121, "count": 4}));
    let primitive = "/meshes/0/primitives/0";
    for gltf in [
        with_accessor(1, &indices, json!({"componentType": 5121})),
        with_accessor(1, &wide, json!({"componentType": 5125})),
        with_accessor(0, &interleaved, json!({"byteOffset": 12})).set("/bufferViews/2/byteStride", json!(24)),
        fan.set(&format!("{primitive}/mode"), json!(6)),
        // Parts that are invalid, but not used.
        square()
            .set(&format!("{primitive}/attributes/_CUSTOM"), json!(99))
            .set(&format!("{primitive}/attributes/NORMAL"), json!(99))
            .set("/materials/-", json!({"name": "unused, default white"}))
            .remove("/accessors/0/min"),
    ] {
        assert_eq!(corners(&gltf.scene()), square_triangles(), "{}", gltf.json);
    }
    let unindexed = square()
        .remove("/meshes/0/primitives/0/indices")
        .set("/accessors/0/count", json!(3));
    assert_eq!(corners(&unindexed.scene()), square_triangles()[..1]);
    let strip = with_accessor(1, &[0, 1, 3, 2], json!({"componentType": 5121, "count": 4}));
    let strip = strip.set("/meshes/0/primitives/0/mode", json!(5)).scene();
    assert_eq!(strip.faces.len(), 2);
    assert!(strip.faces.iter().all(|f| f.vector_area() == DVec3::Z * 0.5));
}

#[test]
fn sparse_accessor_replaces_vertices() {
    // Vertices 1 and 3 are replaced.
    let sparse = json!({
        "count": 2, "indices": {"bufferView": 2, "componentType": 5121}, "values": {"bufferView": 3},
    });
    let gltf = square()
        .view(&[1, 3])
        .view(&float_bytes(&[2., 0., 0., 0., 2., 0.]))
        .set("/accessors/0/sparse", sparse);
    let expected = [
        [[0., 0., 0.], [2., 0., 0.], [1., 1., 0.]],
        [[0., 0., 0.], [1., 1., 0.], [0., 2., 0.]],
    ];
    assert_eq!(corners(&gltf.scene()), expected);
    let zero_based = gltf.remove("/accessors/0/bufferView");
    let expected = [
        [[0., 0., 0.], [2., 0., 0.], [0., 0., 0.]],
        [[0., 0., 0.], [0., 0., 0.], [0., 2., 0.]],
    ];
    assert!(zero_based.error().ends_with("none of its 2 faces has an area"));
    let positions = json!({"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"});
    let primitive = json!({"attributes": {"POSITION": 2}, "indices": 1, "material": 0});
    let with_square = zero_based
        .set("/accessors/-", positions)
        .set("/meshes/0/primitives/-", primitive);
    assert_eq!(corners(&with_square.scene())[..2], expected);
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
    let scene = gltf.scene();
    let expected = [DVec3::new(10., 0., 4.), DVec3::new(10., 2., 4.), DVec3::new(7., 2., 4.)];
    for (found, expected) in scene.faces[0].outline().iter().zip(expected) {
        assert!(found.distance(expected) < 1e-14, "{found} instead of {expected}");
    }
    assert_eq!(scene.faces[0].name, "leaf");
    let matrix = json!([0, 2, 0, 0, -3, 0, 0, 0, 0, 0, 4, 0, 10, 0, 4, 1]);
    let found = square().set("/nodes/0/matrix", matrix).scene();
    assert_eq!(corners(&found)[0], [[10., 0., 4.], [10., 2., 4.], [7., 2., 4.]]);
    // The file's f32 are rounded before they are scaled; the place of the node is not.
    assert_eq!(found.faces[0].rounding, 3.0 * UNIT_ROUNDOFF);
}

#[test]
fn mirroring_transform_keeps_fronts() {
    // A half turn is no mirror.
    for (scale, normal) in [([-1, 1, 1], DVec3::Z), ([-1, 1, -1], DVec3::NEG_Z)] {
        let scene = square().set("/nodes/0/scale", json!(scale)).scene();
        assert!(scene.faces.iter().all(|f| f.vector_area() == normal * 0.5), "{scale:?}");
    }
}

#[test]
fn default_scene_is_imported() {
    let two = square()
        .set("/nodes/-", json!({"mesh": 0, "translation": [5, 0, 0]}))
        .set("/scenes/-", json!({"nodes": [1]}));
    let first_x = |gltf: &Gltf| gltf.scene().faces.iter().map(|f| f.corners[0].x).collect::<Vec<_>>();
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
    assert_eq!(gltf.scene().faces[1].emission, Vec3::new(1., 0.5, 0.) * PI);
    let strength = json!({"KHR_materials_emissive_strength": {"emissiveStrength": 4}});
    let strong = gltf
        .set("/materials/0/extensions", strength)
        .set("/extensionsRequired", json!(["KHR_materials_emissive_strength"]));
    assert_eq!(strong.scene().faces[1].emission, Vec3::new(4., 2., 0.) * PI);
}

/// A value that is set in the square's JSON, and the only note of its import.
const NOTES: &str = "
/meshes/0/primitives/- = {\"attributes\": {\"POSITION\": 0}, \"mode\": 0} => 1 primitives of points or lines left out
/meshes/0/primitives/- = {\"attributes\": {\"POSITION\": 0}, \"mode\": 1} => 1 primitives of points or lines left out
/meshes/0/primitives/- = {\"attributes\": {\"POSITION\": 0}, \"mode\": 2} => 1 primitives of points or lines left out
/meshes/0/primitives/- = {\"attributes\": {\"POSITION\": 0}, \"mode\": 3} => 1 primitives of points or lines left out
/meshes/0/primitives/0/targets = [{\"POSITION\": 0}] => morph targets
/meshes/0/primitives/0 = {\"attributes\": {\"POSITION\": 0}, \"indices\": 1} => \
    2 faces without material: reflectance 0.7, no emission (1, 2)
/materials/0/doubleSided = true => double-sided, but their backs are black: grey
/materials/0/extensions = {\"KHR_materials_unlit\": {}} => unlit, taken as diffuse: grey
/materials/0 = {} => materials 0 reflect all light: taken as 0.95
/materials/0/pbrMetallicRoughness = {} => materials grey reflect all light: taken as 0.95
";

#[test]
fn unsupported_features_are_noted() {
    let assert_noted = |gltf: Gltf, words: &str| {
        let scene = gltf.scene();
        assert_eq!(scene.faces.len(), 2, "{words}");
        assert!(
            matches!(&scene.notes[..], [note] if note.contains(words)),
            "{words}: {:?}",
            scene.notes
        );
        scene.faces[0].reflectance
    };
    for (change, words) in NOTES.lines().filter_map(|row| row.split_once(" => ")) {
        let (pointer, value) = change.split_once(" = ").expect("a value");
        let reflectance = assert_noted(square().set(pointer, serde_json::from_str(value).expect(change)), words);
        for told in [0.95, 0.7] {
            let grey = words.contains(&told.to_string());
            assert!(!grey || reflectance == Vec3::splat(told), "{words}: {reflectance}");
        }
    }
    let see_through = square().set("/materials/0/alphaMode", json!("BLEND"));
    assert_eq!(see_through.scene().notes, [""; 0], "opaque in fact");
    let alpha = "/materials/0/pbrMetallicRoughness/baseColorFactor/3";
    assert_noted(see_through.set(alpha, json!(0.5)), "transparent, taken as opaque: grey");
    // A texture times zero is not read.
    let black = square()
        .set("/materials/0/emissiveTexture", json!({"index": 0}))
        .scene();
    assert_eq!(black.faces[0].emission, Vec3::ZERO);
}

#[test]
fn deeply_nested_nodes_are_imported() {
    let depth = 50_000;
    let mut gltf = square();
    let nodes: Vec<_> = (1..depth).map(|k| json!({"children": [k - 1]})).collect();
    gltf.json["nodes"].as_array_mut().expect("nodes").extend(nodes);
    assert_eq!(gltf.set("/scenes/0/nodes", json!([depth - 1])).scene().faces.len(), 2);
}

#[test]
fn normals_are_kept_and_reordered_under_mirroring() {
    let bent = [0.0f32, 0.6, 0.8];
    let normals: Vec<f32> = [[0.0, 0.0, 1.0], bent, [0.0, 0.0, 1.0], bent].concat();
    let smooth = square().attribute("NORMAL", "VEC3", &normals);
    let bent = Vec3::from(bent);
    let found = smooth.scene().faces[0].corner_normals;
    assert_eq!(found, Some([Vec3::Z, bent, Vec3::Z, Vec3::Z]));
    let mirrored = smooth.clone().set("/nodes/0/scale", json!([-1, 1, 1])).scene();
    assert_eq!(mirrored.faces[0].corner_normals, Some([Vec3::Z, Vec3::Z, bent, bent]));
    let joined = smooth.load_with(&join_quads()).expect("a scene");
    assert_eq!(joined.faces[0].corner_normals, Some([Vec3::Z, bent, Vec3::Z, bent]));
    // Unreadable normals count as missing; the faces are imported.
    let broken = smooth.set("/accessors/2/count", json!(400));
    assert_eq!(broken.scene().faces[0].corner_normals, None);
}

#[test]
fn lightmap_coordinates_are_kept_on_request() {
    let options = ImportOptions {
        charts: true,
        ..join_quads()
    };
    let places = [0., 0., 0.5, 0., 0.5, 0.25, 0., 0.25];
    let charted = square().attribute("TEXCOORD_1", "VEC2", &places);
    let charts = |gltf: &Gltf| {
        let scene = gltf.load_with(&options).expect("a scene");
        let charts = scene.faces.iter().map(|face| face.lightmap_corners.expect("a chart"));
        charts.map(|chart| chart.map(|p| p.to_array())).collect::<Vec<_>>()
    };
    let [a, b, c, d] = [[0., 0.], [0.5, 0.], [0.5, 0.25], [0., 0.25]];
    assert_eq!(charts(&charted), [[a, b, c], [a, c, d]]);
    // Mirroring reverses the triangle and its lightmap coordinates.
    let mirrored = charted.clone().set("/nodes/0/scale", json!([-1, 1, 1]));
    assert_eq!(charts(&mirrored)[0], [a, c, b]);

    assert_eq!(charted.scene().faces[0].lightmap_corners, None, "not requested");
    let refused = square().attribute("TEXCOORD_0", "VEC2", &places).load_with(&options);
    let told = refused.expect_err("no charts").to_string();
    assert!(told.contains("mesh 0 primitive 0: has no TEXCOORD_1"), "{told}");
}
