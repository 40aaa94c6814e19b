//! Messages for faults of glTF files.

use super::files::{Folder, Gltf, square};
use serde_json::{Value, json};

fn assert_begins(error: String, expected: &str) {
    assert!(
        error.starts_with(expected),
        "`{error}` does not begin with `{expected}`"
    );
}

/// Returns the error of the square with one value changed.
fn error_with_change(pointer: &str, value: Value) -> String {
    square().set(pointer, value).error()
}

#[test]
fn dangling_references_are_refused() {
    let faults = [
        ("/scene", json!(1), "a.glb: scene 1: does not exist"),
        ("/scenes/0/nodes", json!([7]), "a.glb: node 7: does not exist"),
        ("/nodes/0/children", json!([7]), "a.glb: node 7: does not exist"),
        (
            "/nodes/0/children",
            json!([0]),
            "a.glb: node 0: has two parents, or is its own ancestor",
        ),
        ("/scenes/0/nodes", json!([0, 0]), "a.glb: node 0: has two parents"),
        ("/nodes/0/mesh", json!(7), "a.glb: mesh 7: does not exist"),
        (
            "/meshes/0/primitives/0/material",
            json!(7),
            "a.glb: material 7: does not exist",
        ),
        (
            "/meshes/0/primitives/0/indices",
            json!(7),
            "a.glb: mesh 0 primitive 0: accessor 7 (indices) does not exist",
        ),
        (
            "/meshes/0/primitives/0/attributes/POSITION",
            json!(7),
            "a.glb: mesh 0 primitive 0: accessor 7 (positions) does not exist",
        ),
        (
            "/accessors/0/bufferView",
            json!(7),
            "a.glb: mesh 0 primitive 0: accessor 0 (positions) uses buffer view 7, which does not exist",
        ),
        (
            "/bufferViews/0/buffer",
            json!(7),
            "a.glb: mesh 0 primitive 0: accessor 0 (positions) uses buffer view 0, which reaches beyond its buffer",
        ),
    ];
    for (pointer, value, expected) in faults {
        assert_begins(error_with_change(pointer, value), expected);
    }
}

#[test]
fn ranges_beyond_buffers_are_refused() {
    let positions = "a.glb: mesh 0 primitive 0: accessor 0 (positions) ";
    let faults = [
        (
            "/accessors/0/count",
            json!(5),
            "reaches beyond buffer view 0: is the file cut off?",
        ),
        ("/accessors/0/count", json!(u64::MAX), "reaches beyond buffer view 0"),
        ("/accessors/0/byteOffset", json!(1), "reaches beyond buffer view 0"),
        (
            "/accessors/0/byteOffset",
            json!(u64::MAX),
            "reaches beyond buffer view 0",
        ),
        ("/bufferViews/0/byteLength", json!(47), "reaches beyond buffer view 0"),
        (
            "/bufferViews/0/byteLength",
            json!(61),
            "uses buffer view 0, which reaches beyond its buffer",
        ),
        (
            "/bufferViews/0/byteLength",
            json!(u64::MAX),
            "uses buffer view 0, which reaches beyond its buffer",
        ),
        (
            "/bufferViews/0/byteOffset",
            json!(u64::MAX),
            "uses buffer view 0, which reaches beyond its buffer",
        ),
        ("/bufferViews/0/byteStride", json!(13), "reaches beyond buffer view 0"),
        (
            "/bufferViews/0/byteStride",
            json!(8),
            "overlaps itself: buffer view 0 has stride 8",
        ),
        (
            "/bufferViews/0/byteStride",
            json!(u64::MAX),
            "reaches beyond buffer view 0",
        ),
    ];
    for (pointer, value, expected) in faults {
        assert_begins(error_with_change(pointer, value), &format!("{positions}{expected}"));
    }
    assert_begins(
        error_with_change("/accessors/0/count", json!(3)),
        "a.glb: mesh 0 primitive 0: has index 3 but only 3 vertices",
    );
    assert_begins(
        error_with_change("/accessors/1/count", json!(5)),
        "a.glb: mesh 0 primitive 0: has 5 corners, which is no multiple of 3",
    );
    assert_begins(error_with_change("/accessors/1/count", json!(0)), "a.glb: has no faces");
    let wide: Vec<u8> = [0u32, 1, 1 << 24].iter().flat_map(|k| k.to_le_bytes()).collect();
    let indices = json!({"bufferView": 2, "componentType": 5125, "count": 3, "type": "SCALAR"});
    assert_begins(
        square().view(&wide).set("/accessors/1", indices).error(),
        "a.glb: mesh 0 primitive 0: has index 16777216 but only 4 vertices",
    );
}

#[test]
fn invalid_sparse_accessors_are_refused() {
    let with = |gltf: Gltf, count: u64, view: u32| {
        let indices = json!({"bufferView": view, "componentType": 5121});
        gltf.set(
            "/accessors/0/sparse",
            json!({"count": count, "indices": indices, "values": {"bufferView": 0}}),
        )
        .error()
    };
    let positions = "a.glb: mesh 0 primitive 0: accessor 0 (positions) ";
    assert_begins(
        with(square().view(&[4]), 1, 2),
        &format!("{positions}has a sparse index out of range"),
    );
    assert_begins(
        with(square().view(&[0]), 2, 2),
        &format!("{positions}reaches beyond buffer view 2"),
    );
    assert_begins(
        with(square().view(&[0]), u64::MAX, 2),
        &format!("{positions}reaches beyond buffer view 2"),
    );
    assert_begins(
        with(square(), 1, 9),
        &format!("{positions}uses buffer view 9, which does not exist"),
    );
    let bare = square().view(&[0]).remove("/accessors/0/bufferView");
    assert_begins(bare.error(), &format!("{positions}has no buffer view"));
    let endless = bare.set("/accessors/0/count", json!(1u64 << 60));
    assert_begins(
        with(endless, 1, 2),
        &format!("{positions}has {} elements: too many", 1u64 << 60),
    );
}

#[test]
fn wrong_types_are_refused() {
    let faults = [
        (
            "/accessors/0/componentType",
            json!(5125),
            "a.glb: mesh 0 primitive 0: accessor 0 (positions) holds neither floats nor short integers",
        ),
        (
            "/accessors/0/componentType",
            json!(1),
            "a.glb: mesh 0 primitive 0: accessor 0 (positions) is of no known type",
        ),
        (
            "/accessors/0/type",
            json!("VEC2"),
            "a.glb: mesh 0 primitive 0: accessor 0 (positions) is of type Vec2 instead of Vec3",
        ),
        (
            "/accessors/1/componentType",
            json!(5126),
            "a.glb: mesh 0 primitive 0: accessor 1 (indices) holds no unsigned integers",
        ),
        (
            "/meshes/0/primitives/0/mode",
            json!(9),
            "a.glb: mesh 0 primitive 0: has an unknown mode",
        ),
        (
            "/meshes/0/primitives/0/attributes",
            json!({}),
            "a.glb: mesh 0 primitive 0: has no POSITION",
        ),
        (
            "/extensionsRequired",
            json!(["KHR_draco_mesh_compression"]),
            "a.glb: requires the extension KHR_draco_mesh_compression",
        ),
        ("/asset", json!(3), "a.glb: is not valid glTF 2.0: "),
        ("/meshes/0/primitives", json!("none"), "a.glb: is not valid glTF 2.0: "),
    ];
    for (pointer, value, expected) in faults {
        assert_begins(error_with_change(pointer, value), expected);
    }
}

#[test]
fn invalid_materials_are_refused() {
    let base = "/materials/0/pbrMetallicRoughness/baseColorFactor";
    let faults = [
        (
            base,
            json!([1, 1, 1.5, 1]),
            "a.glb: material grey: reflectance baseColorFactor 1 1 1.5 must be",
        ),
        (
            base,
            json!([-0.5, 0, 0, 1]),
            "a.glb: material grey: reflectance baseColorFactor -0.5 0 0 must be",
        ),
        (
            "/materials/0/emissiveFactor",
            json!([0, -1, 0]),
            "a.glb: material grey: emitted radiance emissiveFactor 0 -1 0",
        ),
        (
            "/materials/0/pbrMetallicRoughness/baseColorTexture",
            json!({"index": 0}),
            "a.glb: material grey: texture 0 does not exist",
        ),
    ];
    for (pointer, value, expected) in faults {
        assert_begins(error_with_change(pointer, value), expected);
    }
    let glowing = square()
        .set("/materials/0/emissiveFactor", json!([1, 1, 1]))
        .set("/materials/0/emissiveTexture", json!({"index": 0}));
    assert_begins(glowing.error(), "a.glb: material grey: texture 0 does not exist");
}

#[test]
fn non_finite_coordinates_are_refused() {
    let expected = "a.glb: face 1 (mesh 0 primitive 0, node square): a corner is not a finite number";
    let mut gltf = square();
    gltf.bytes[12..16].copy_from_slice(&f32::NAN.to_le_bytes());
    assert_begins(gltf.error(), expected);
    assert_begins(error_with_change("/nodes/0/rotation", json!([0, 0, 0, 0])), expected);
    assert_begins(
        error_with_change("/nodes/0/scale", json!([0, 0, 0])),
        "a.glb: none of its 2 faces has an area",
    );
}

#[test]
fn incomplete_buffers_are_refused() {
    let short = square().set("/buffers/0/byteLength", json!(100));
    assert_begins(
        short.error(),
        "a.glb: buffer 0: has 60 of its 100 bytes: is the file cut off?",
    );
    let of = |uri: &str| {
        let text = square().set("/buffers/0/uri", json!(uri)).json.to_string();
        Folder::new()
            .with("a.gltf", text)
            .with("b.bin", [0; 59])
            .error("a.gltf")
    };
    assert_begins(
        of("c.bin"),
        "a.gltf: buffer 0: c.bin cannot be read: there is no such file",
    );
    assert_begins(of("b.bin"), "a.gltf: buffer 0: has 59 of its 60 bytes");
    assert_begins(of("."), "a.gltf: buffer 0: . cannot be read: it is a directory");
    assert_begins(
        of("https://example.org/b.bin"),
        "a.gltf: buffer 0: is at https://example.org/b.bin: only files beside",
    );
    assert_begins(of("%zz"), "a.gltf: buffer 0: has an invalid uri %zz");
    assert_begins(of("data:;base64"), "a.gltf: buffer 0: has a data URI without data");
    assert_begins(
        of("data:;base64,?"),
        "a.gltf: buffer 0: has a data URI that is not base64",
    );
    assert_begins(
        of("data:text/plain,abc"),
        "a.gltf: buffer 0: has a data URI that is not base64",
    );
    assert_begins(of("data:;base64,AAAA"), "a.gltf: buffer 0: has 3 of its 60 bytes");
    let bare = Folder::new().with("a.gltf", square().json.to_string());
    assert_begins(bare.error("a.gltf"), "a.gltf: buffer 0: has no binary chunk");
}

#[test]
fn damaged_glb_containers_are_refused() {
    let whole = square().glb();
    let with = |at: usize, word: u32| {
        let mut glb = whole.clone();
        glb[at..at + 4].copy_from_slice(&word.to_le_bytes());
        Folder::new().with("a.glb", glb).error("a.glb")
    };
    assert_begins(with(4, 1), "a.glb: is glTF version 1: export it as version 2");
    assert_begins(with(8, 0), "a.glb: says that it is 0 bytes long: it is damaged");
    assert_begins(
        with(8, u32::MAX),
        &format!("a.glb: has {} of its {} bytes: it is cut off", whole.len(), u32::MAX),
    );
    assert_begins(with(12, u32::MAX), "a.glb: is not valid glTF 2.0: ");
    assert_begins(with(16, 0), "a.glb: is not valid glTF 2.0: ");
    assert_begins(
        Folder::new().with("a.glb", "glTF").error("a.glb"),
        "a.glb: is cut off within its header",
    );
    assert_begins(
        Folder::new().with("a.gltf", "{\"asset\":\n{").error("a.gltf"),
        "a.gltf: is not valid glTF 2.0: EOF while parsing",
    );
}

#[test]
fn too_many_instances_are_refused() {
    // 2000 nodes show 3000 triangles each.
    let mut gltf = square().view(&[0u8, 1, 2].repeat(3000));
    gltf.json["accessors"][1] = json!({"bufferView": 2, "componentType": 5121, "count": 9000, "type": "SCALAR"});
    gltf.json["nodes"] = json!(vec![json!({"mesh": 0}); 2000]);
    gltf.json["scenes"][0]["nodes"] = json!((0..2000).collect::<Vec<_>>());
    let error = gltf.error();
    assert!(
        error.ends_with("more than 4194304 faces cannot be solved: simplify the mesh"),
        "{error}"
    );
}
