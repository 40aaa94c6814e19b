//! Messages for faults of glTF files.

use super::files::{Folder, Gltf, assert_begins, square};
use serde_json::json;

/// A value of the square's JSON that is replaced, and the beginning of the message. `P` is the mesh primitive, `A0` and
/// `A1` are its accessors.
const FAULTS: &str = "
/scene = 1 => scene 1: does not exist
/scenes/0/nodes = [7] => node 7: does not exist
/scenes/0/nodes = [0, 0] => node 0: has two parents
/nodes/0/children = [7] => node 7: does not exist
/nodes/0/children = [0] => node 0: has two parents, or is its own ancestor
/nodes/0/mesh = 7 => mesh 7: does not exist
/nodes/0/rotation = [0, 0, 0, 0] => face 1 (mesh 0 primitive 0, node square): a corner is not a finite number
/nodes/0/scale = [0, 0, 0] => none of its 2 faces has an area
/nodes/0/extensions = {\"KHR_lights_punctual\": {\"light\": 3}} => light 3: does not exist
/meshes/0/primitives = \"none\" => is not valid glTF 2.0
/meshes/0/primitives/0/mode = 9 => P: has an unknown mode
/meshes/0/primitives/0/material = 7 => material 7: does not exist
/meshes/0/primitives/0/indices = 7 => P: accessor 7 (indices) does not exist
/meshes/0/primitives/0/attributes = {} => P: has no POSITION
/meshes/0/primitives/0/attributes/POSITION = 7 => P: accessor 7 (positions) does not exist
/accessors/0/bufferView = 7 => A0 uses buffer view 7, which does not exist
/accessors/0/count = 3 => P: has index 3 but only 3 vertices
/accessors/0/count = 5 => A0 reaches beyond buffer view 0: is the file cut off?
/accessors/0/count = 18446744073709551615 => A0 reaches beyond buffer view 0
/accessors/0/byteOffset = 1 => A0 reaches beyond buffer view 0
/accessors/0/byteOffset = 18446744073709551615 => A0 reaches beyond buffer view 0
/accessors/0/componentType = 5125 => A0 holds neither floats nor short integers
/accessors/0/componentType = 1 => A0 is of no known type
/accessors/0/type = \"VEC2\" => A0 is of type Vec2 instead of Vec3
/accessors/1/count = 0 => has no faces
/accessors/1/count = 5 => P: has 5 corners, which is no multiple of 3
/accessors/1/componentType = 5126 => A1 holds no unsigned integers
/bufferViews/0/buffer = 7 => A0 uses buffer view 0, which reaches beyond its buffer
/bufferViews/0/byteLength = 47 => A0 reaches beyond buffer view 0
/bufferViews/0/byteLength = 61 => A0 uses buffer view 0, which reaches beyond its buffer
/bufferViews/0/byteLength = 18446744073709551615 => A0 uses buffer view 0, which reaches beyond its buffer
/bufferViews/0/byteOffset = 18446744073709551615 => A0 uses buffer view 0, which reaches beyond its buffer
/bufferViews/0/byteStride = 8 => A0 overlaps itself: buffer view 0 has stride 8
/bufferViews/0/byteStride = 13 => A0 reaches beyond buffer view 0
/bufferViews/0/byteStride = 18446744073709551615 => A0 reaches beyond buffer view 0
/buffers/0/byteLength = 100 => buffer 0: has 60 of its 100 bytes: is the file cut off?
/asset = 3 => is not valid glTF 2.0
/extensionsRequired = [\"EXT_meshopt_compression\"] => requires the extension EXT_meshopt_compression
/materials/0/emissiveFactor = [0, -1, 0] => material grey: emitted radiance emissiveFactor 0 -1 0
/materials/0/pbrMetallicRoughness/baseColorFactor = [1, 1, 1.5, 1] => material grey: reflectance baseColorFactor 1 1 1.5 must be
/materials/0/pbrMetallicRoughness/baseColorFactor = [-0.5, 0, 0, 1] => material grey: reflectance baseColorFactor -0.5 0 0 must be
/materials/0/pbrMetallicRoughness/baseColorTexture = {\"index\": 0} => material grey: texture 0 does not exist
";

/// Asserts the beginning of the message.
fn assert_refused(gltf: &Gltf, expected: &str) {
    let (first, rest) = expected.split_at(expected.len().min(2));
    let place = match first {
        "P:" => "mesh 0 primitive 0:",
        "A0" => "mesh 0 primitive 0: accessor 0 (positions)",
        "A1" => "mesh 0 primitive 0: accessor 1 (indices)",
        _ => first,
    };
    assert_begins(&gltf.error(), &format!("a.glb: {place}{rest}"));
}

#[test]
fn single_wrong_values_are_refused() {
    for (change, expected) in FAULTS.lines().filter_map(|row| row.split_once(" => ")) {
        let (pointer, value) = change.split_once(" = ").unwrap();
        let value = serde_json::from_str(value).unwrap();
        assert_refused(&square().set(pointer, value), expected);
    }
}

#[test]
fn invalid_sparse_accessors_are_refused() {
    let with = |gltf: Gltf, count: u64, view: u32| {
        let indices = json!({"bufferView": view, "componentType": 5121});
        let sparse = json!({"count": count, "indices": indices, "values": {"bufferView": 0}});
        gltf.set("/accessors/0/sparse", sparse)
    };
    let bare = square().view(&[0]).remove("/accessors/0/bufferView");
    let endless = bare.clone().set("/accessors/0/count", json!(1u64 << 60));
    for (gltf, expected) in [
        (with(square().view(&[4]), 1, 2), "A0 has a sparse index out of range"),
        (with(square().view(&[0]), 2, 2), "A0 reaches beyond buffer view 2"),
        (
            with(square().view(&[0]), u64::MAX, 2),
            "A0 reaches beyond buffer view 2",
        ),
        (with(square(), 1, 9), "A0 uses buffer view 9, which does not exist"),
        (bare, "A0 has no buffer view"),
        (with(endless, 1, 2), "A0 has 1152921504606846976 elements: too many"),
    ] {
        assert_refused(&gltf, expected);
    }
}

#[test]
fn values_that_contradict_each_other_are_refused() {
    let wide: Vec<u8> = [0u32, 1, 1 << 24].iter().flat_map(|k| k.to_le_bytes()).collect();
    let indices = json!({"bufferView": 2, "componentType": 5125, "count": 3, "type": "SCALAR"});
    let wide = square().view(&wide).set("/accessors/1", indices);
    assert_refused(&wide, "P: has index 16777216 but only 4 vertices");
    let glowing = square()
        .set("/materials/0/emissiveFactor", json!([1, 1, 1]))
        .set("/materials/0/emissiveTexture", json!({"index": 0}));
    assert_refused(&glowing, "material grey: texture 0 does not exist");
    let mut gltf = square();
    gltf.bytes[12..16].copy_from_slice(&f32::NAN.to_le_bytes());
    assert_refused(
        &gltf,
        "face 1 (mesh 0 primitive 0, node square): a corner is not a finite number",
    );
    // 2000 nodes show 3000 triangles each.
    let mut gltf = square().view(&[0u8, 1, 2].repeat(3000));
    gltf.json["accessors"][1] = json!({"bufferView": 2, "componentType": 5121, "count": 9000, "type": "SCALAR"});
    gltf.json["nodes"] = json!(vec![json!({"mesh": 0}); 2000]);
    gltf.json["scenes"][0]["nodes"] = json!((0..2000).collect::<Vec<_>>());
    let error = gltf.error();
    let expected = "more than 4194304 faces cannot be solved: simplify the mesh";
    assert!(error.ends_with(expected), "{error}");
}

/// Addresses of the buffer in a file `a.gltf`, and the beginning of the message.
const URI_FAULTS: &str = "
c.bin => buffer 0: c.bin cannot be read: there is no such file
b.bin => buffer 0: has 59 of its 60 bytes
. => buffer 0: . cannot be read: it is a directory
https://example.org/b.bin => buffer 0: is at https://example.org/b.bin: only files beside
%zz => buffer 0: has an invalid uri %zz
%2 => buffer 0: has an invalid uri %2
%ff => buffer 0: has an invalid uri %ff
b%C3%A9.bin => buffer 0: bé.bin cannot be read: there is no such file
data:;base64 => buffer 0: has a data URI without data
data:;base64,? => buffer 0: has a data URI that is not base64
data:text/plain,abc => buffer 0: has a data URI that is not base64
data:;base64,AAAA => buffer 0: has 3 of its 60 bytes
";

#[test]
fn unreadable_buffers_are_refused() {
    let folder = Folder::new().with("b.bin", [0; 59]);
    for (uri, expected) in URI_FAULTS.lines().filter_map(|row| row.split_once(" => ")) {
        let gltf = square().set("/buffers/0/uri", json!(uri));
        folder.put("a.gltf", gltf.json.to_string());
        assert_begins(&folder.error("a.gltf"), &format!("a.gltf: {expected}"));
    }
    folder.put("a.gltf", square().json.to_string());
    assert_begins(&folder.error("a.gltf"), "a.gltf: buffer 0: has no binary chunk");
    folder.put("a.gltf", "{\"asset\":\n{");
    assert_begins(
        &folder.error("a.gltf"),
        "a.gltf: is not valid glTF 2.0: EOF while parsing",
    );
}

#[test]
fn damaged_glb_containers_are_refused() {
    let whole = square().glb();
    let cut_off = format!("has {} of its {} bytes: it is cut off", whole.len(), u32::MAX);
    let folder = Folder::new();
    for (at, word, expected) in [
        (4, 1, "is glTF version 1: export it as version 2"),
        (8, 0, "says that it is 0 bytes long: it is damaged"),
        (8, u32::MAX, &cut_off),
        (12, u32::MAX, "is not valid glTF 2.0: "),
        (16, 0, "is not valid glTF 2.0: "),
    ] {
        let mut glb = whole.clone();
        glb[at..at + 4].copy_from_slice(&word.to_le_bytes());
        folder.put("a.glb", glb);
        assert_begins(&folder.error("a.glb"), &format!("a.glb: {expected}"));
    }
    folder.put("a.glb", "glTF");
    assert_begins(&folder.error("a.glb"), "a.glb: is cut off within its header");
}
