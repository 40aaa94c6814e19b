//! Damaged files neither panic nor hang nor exhaust memory: each gives a scene or a one-line error.

use super::files::{Folder, square};
use serde_json::{Value, json};

/// Writes `bytes` to a file and loads `scene`; returns true on success, and checks that an error is one line with a
/// file's name.
fn load_damaged(folder: &Folder, file: &str, bytes: &[u8], scene: &str) -> bool {
    folder.put(file, bytes);
    match folder.load(scene) {
        Ok(scene) => {
            assert!(!scene.faces.is_empty() && scene.faces.iter().all(|f| f.corners.iter().all(|c| c.is_finite())));
            true
        }
        Err(error) => {
            let text = error.to_string();
            assert!(text.contains(file) || text.contains(scene), "{text}");
            assert!(!text.contains('\n'), "{text}");
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

const OBJ_TEXT: &str = "mtllib a.mtl\no room\nv 0 0 0\nv 1 0 0\nv 1 1 0 2\nv 0 1 0.5\nv -1e3 +.5 0\n\
    vt 0 0\nvn 0 0 1\nusemtl wall\nf 1/1/1 2/1/1 3/1/1 4/1/1\ng lamp\nusemtl lamp\nf -5 -4 -3 \\\n -2 -1\nf 1 2 3\nl 1 2\n";
/// A file with vertex colours has no weights.
const COLOURED_OBJ: &str = "v 0 0 0\nv 1 0 0 1 0 0.5\nv 1 1 0 -2 1e9 .1\nf 1 2 3\n";
const MTL_TEXT: &str =
    "# two\nnewmtl wall\nKd 0.5 0.5 0.5\nKs 0.1 0 0\nillum 2\nd 1\nnewmtl lamp\n  Kd 0.1\nKe 1 2 3\n";

#[test]
fn truncated_or_changed_files_do_not_panic() {
    let folder = Folder::new().with("m.obj", OBJ_TEXT);
    let mut number = pseudo_random_numbers();
    let glb = square().glb();
    for (file, whole, scene, bytes) in [
        ("a.glb", &glb[..], "a.glb", &b"\0\xff9"[..]),
        ("a.mtl", MTL_TEXT.as_bytes(), "m.obj", b"-9\n #"),
        ("a.obj", OBJ_TEXT.as_bytes(), "a.obj", b"-9\n /\\#"),
        ("a.obj", COLOURED_OBJ.as_bytes(), "a.obj", b"-9\n /\\#"),
    ] {
        for at in 0..whole.len() {
            let loaded = load_damaged(&folder, file, &whole[..at], scene);
            assert!(!loaded || file != "a.glb", "{at} bytes were accepted");
            for byte in [bytes, &[number(256) as u8, whole[at] ^ (1 << number(8))]].concat() {
                let mut damaged = whole.to_vec();
                damaged[at] = byte;
                load_damaged(&folder, file, &damaged, scene);
            }
        }
        assert!(load_damaged(&folder, file, whole, scene));
    }
}

#[test]
fn gltf_with_changed_value_does_not_panic() {
    let folder = Folder::new();
    let sparse = json!({
        "count": 2, "indices": {"bufferView": 2, "componentType": 5121, "byteOffset": 0},
        "values": {"bufferView": 0, "byteOffset": 0},
    });
    let node = json!({"mesh": 0, "scale": [1, 1, 1], "rotation": [0, 0, 0, 1], "translation": [0, 0, 0]});
    let gltf = square()
        .view(&[1, 3])
        .set("/accessors/0/sparse", sparse)
        .set("/bufferViews/0/byteStride", json!(12))
        .set("/meshes/0/primitives/0/mode", json!(4))
        .set("/nodes/0/children", json!([1]))
        .set("/nodes/-", node);
    let mut places = Vec::new();
    collect_pointers(&gltf.json, String::new(), &mut places);
    assert!(places.len() > 70, "{}", places.len());
    let values = r#"0 1 3 -1 2.5 4294967295 18446744073709551615 1e308 1e-320 null "x" [] {}"#;
    for place in &places {
        for value in values.split(' ') {
            let value = serde_json::from_str(value).unwrap();
            let glb = gltf.clone().set(place, value).glb();
            load_damaged(&folder, "a.glb", &glb, "a.glb");
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

#[test]
fn obj_of_random_words_does_not_panic() {
    let folder = Folder::new();
    let words = "v f g o l p usemtl mtllib vn 1 -1 2 3 0 1// / //2 1/2/3/4 nan inf -inf 1e999 99999999999999999999 \
        -9223372036854775808 \\ # é \t";
    let words: Vec<&str> = words.split(' ').collect();
    let mut number = pseudo_random_numbers();
    for _ in 0..3000 {
        let mut text = String::from("v 0 0 0\nv 1 0 0\nv 0 1 0\n");
        for _ in 0..number(40) {
            text.push_str(words[number(words.len())]);
            text.push(if number(4) == 0 { '\n' } else { ' ' });
        }
        load_damaged(&folder, "a.obj", text.as_bytes(), "a.obj");
    }
}
