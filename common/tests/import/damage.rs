//! Damaged files neither panic nor hang nor exhaust memory: each gives a scene or a one-line error.

use super::files::{Folder, square};
use serde_json::{Value, json};

/// Loads `bytes`; returns true on success, and checks that an error is one line with the file name.
fn load_damaged(folder: &Folder, name: &str, bytes: &[u8]) -> bool {
    folder.put(name, bytes);
    match folder.load(name) {
        Ok(scene) => {
            assert!(!scene.faces.is_empty() && scene.faces.iter().all(|f| f.corners.iter().all(|c| c.is_finite())));
            true
        }
        Err(error) => {
            let text = error.to_string();
            assert!(text.contains(name) && !text.contains('\n'), "{text}");
            false
        }
    }
}

/// Returns a generator with a fixed seed (Knuth's MMIX generator, upper bits).
fn pseudo_random_numbers() -> impl FnMut(usize) -> usize {
    let mut state = 1u64;
    move |below| {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % below
    }
}

#[test]
fn truncated_glb_is_refused() {
    let folder = Folder::new();
    let glb = square().glb();
    for length in 0..glb.len() {
        assert!(
            !load_damaged(&folder, "a.glb", &glb[..length]),
            "{length} bytes of {} were accepted",
            glb.len()
        );
    }
}

#[test]
fn glb_with_changed_byte_does_not_panic() {
    let folder = Folder::new();
    let glb = square().glb();
    let mut number = pseudo_random_numbers();
    for at in 0..glb.len() {
        for byte in [0, 255, b'9', glb[at] ^ (1 << number(8))] {
            let mut damaged = glb.clone();
            damaged[at] = byte;
            load_damaged(&folder, "a.glb", &damaged);
        }
    }
}

#[test]
fn gltf_with_changed_value_does_not_panic() {
    let folder = Folder::new();
    let gltf = square()
        .view(&[1, 3])
        .set("/accessors/0/sparse", json!({"count": 2, "indices": {"bufferView": 2, "componentType": 5121, "byteOffset": 0}, "values": {"bufferView": 0, "byteOffset": 0}}))
        .set("/bufferViews/0/byteStride", json!(12))
        .set("/meshes/0/primitives/0/mode", json!(4))
        .set("/nodes/0/children", json!([1]))
        .set("/nodes/-", json!({"mesh": 0, "scale": [1, 1, 1], "rotation": [0, 0, 0, 1], "translation": [0, 0, 0]}));
    let mut places = Vec::new();
    collect_pointers(&gltf.json, String::new(), &mut places);
    assert!(places.len() > 70, "{}", places.len());
    let values = [
        json!(0),
        json!(1),
        json!(3),
        json!(-1),
        json!(2.5),
        json!(u32::MAX),
        json!(u64::MAX),
        json!(1e308),
        json!(1e-320),
        json!(null),
        json!("x"),
        json!([]),
        json!({}),
    ];
    for place in &places {
        for value in &values {
            load_damaged(&folder, "a.glb", &gltf.clone().set(place, value.clone()).glb());
        }
    }
}

fn collect_pointers(value: &Value, at: String, places: &mut Vec<String>) {
    let children: Vec<(String, &Value)> = match value {
        Value::Array(list) => list.iter().enumerate().map(|(k, v)| (k.to_string(), v)).collect(),
        Value::Object(map) => map.iter().map(|(k, v)| (k.clone(), v)).collect(),
        _ => Vec::new(),
    };
    for (key, child) in children {
        let place = format!("{at}/{key}");
        places.push(place.clone());
        collect_pointers(child, place, places);
    }
}

const OBJ_TEXT: &str = "mtllib a.mtl\no room\nv 0 0 0\nv 1 0 0\nv 1 1 0 2\nv 0 1 0.5\nv -1e3 +.5 0\n\
    vt 0 0\nvn 0 0 1\nusemtl wall\nf 1/1/1 2/1/1 3/1/1 4/1/1\ng lamp\nusemtl lamp\nf -5 -4 -3 \\\n -2 -1\nf 1 2 3\nl 1 2\n";
/// A file with vertex colours has no weights.
const COLOURED_OBJ: &str = "v 0 0 0\nv 1 0 0 1 0 0.5\nv 1 1 0 -2 1e9 .1\nf 1 2 3\n";
const MTL_TEXT: &str =
    "# two\nnewmtl wall\nKd 0.5 0.5 0.5\nKs 0.1 0 0\nillum 2\nd 1\nnewmtl lamp\n  Kd 0.1\nKe 1 2 3\n";

#[test]
fn truncated_or_changed_obj_does_not_panic() {
    let folder = Folder::new().with("a.mtl", MTL_TEXT);
    let mut number = pseudo_random_numbers();
    for whole in [OBJ_TEXT, COLOURED_OBJ].map(str::as_bytes) {
        assert!(load_damaged(&folder, "a.obj", whole));
        for at in 0..whole.len() {
            load_damaged(&folder, "a.obj", &whole[..at]);
            for byte in [b'-', b'9', b'\n', b' ', b'/', b'\\', b'#', number(256) as u8] {
                let mut damaged = whole.to_vec();
                damaged[at] = byte;
                load_damaged(&folder, "a.obj", &damaged);
            }
        }
    }
}

#[test]
fn truncated_or_changed_mtl_does_not_panic() {
    let folder = Folder::new().with("a.obj", OBJ_TEXT);
    let load = |bytes: &[u8]| {
        folder.put("a.mtl", bytes);
        if let Err(error) = folder.load("a.obj") {
            let text = error.to_string();
            assert!(
                (text.contains("a.mtl") || text.contains("a.obj")) && !text.contains('\n'),
                "{text}"
            );
        }
    };
    let mut number = pseudo_random_numbers();
    for at in 0..MTL_TEXT.len() {
        load(&MTL_TEXT.as_bytes()[..at]);
        for byte in [b'-', b'9', b'\n', b' ', b'#', number(256) as u8] {
            let mut damaged = MTL_TEXT.as_bytes().to_vec();
            damaged[at] = byte;
            load(&damaged);
        }
    }
}

#[test]
fn obj_of_random_words_does_not_panic() {
    let folder = Folder::new();
    let words = [
        "v",
        "f",
        "g",
        "o",
        "l",
        "p",
        "usemtl",
        "mtllib",
        "vn",
        "1",
        "-1",
        "2",
        "3",
        "0",
        "1//",
        "/",
        "//2",
        "1/2/3/4",
        "nan",
        "inf",
        "-inf",
        "1e999",
        "99999999999999999999",
        "-9223372036854775808",
        "\\",
        "#",
        "é",
        "\t",
    ];
    let mut number = pseudo_random_numbers();
    for _ in 0..3000 {
        let mut text = String::from("v 0 0 0\nv 1 0 0\nv 0 1 0\n");
        for _ in 0..number(40) {
            text.push_str(words[number(words.len())]);
            text.push(if number(4) == 0 { '\n' } else { ' ' });
        }
        load_damaged(&folder, "a.obj", text.as_bytes());
    }
}
