//! Temporary folders for small files, and a glTF document to vary.

use common::Result;
use common::import::{ImportOptions, load_scene};
use common::scene::Scene;
use glam::DVec3;
use serde_json::{Value, json};
use std::path::PathBuf;
use std::sync::atomic::{AtomicU32, Ordering};
use std::{env, fs, process};

/// Temporary folder, removed with its contents when dropped.
pub struct Folder(PathBuf);

impl Folder {
    pub fn new() -> Self {
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let name = format!(
            "radiosity-import-{}-{}",
            process::id(),
            COUNT.fetch_add(1, Ordering::Relaxed)
        );
        let path = env::temp_dir().join(name);
        fs::create_dir_all(&path).expect("a temporary folder");
        Self(path)
    }

    pub fn with(self, name: &str, bytes: impl AsRef<[u8]>) -> Self {
        self.put(name, bytes);
        self
    }

    pub fn put(&self, name: &str, bytes: impl AsRef<[u8]>) {
        fs::write(self.path(name), bytes).expect("a temporary file");
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    pub fn load(&self, name: &str) -> Result<Scene> {
        load_scene(&self.path(name), &ImportOptions::default())
    }

    /// Returns the one-line error of loading `name`, without the folder.
    pub fn error(&self, name: &str) -> String {
        let error = match self.load(name) {
            Ok(scene) => panic!(
                "{name} was loaded: {} faces, notes {:?}",
                scene.faces.len(),
                scene.notes
            ),
            Err(error) => error.to_string(),
        };
        assert!(!error.contains('\n'), "more than a line: {error}");
        error.replace(&format!("{}/", self.0.display()), "")
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// Loads an OBJ without materials.
pub fn obj(text: &str) -> Result<Scene> {
    Folder::new().with("a.obj", text).load("a.obj")
}

/// Returns the notes that contain `words`.
pub fn notes<'a>(scene: &'a Scene, words: &str) -> Vec<&'a str> {
    scene
        .notes
        .iter()
        .map(String::as_str)
        .filter(|note| note.contains(words))
        .collect()
}

/// Returns the outline corners of each face.
pub fn corners(scene: &Scene) -> Vec<Vec<[f64; 3]>> {
    scene
        .faces
        .iter()
        .map(|face| face.outline().iter().map(DVec3::to_array).collect())
        .collect()
}

/// The glTF file under variation: a JSON document and the bytes of buffer 0.
#[derive(Clone)]
pub struct Gltf {
    pub json: Value,
    pub bytes: Vec<u8>,
}

/// Returns the unit square in z = 0 as two triangles, grey, front to +z. Bytes: 4 positions, 6 u16.
pub fn square() -> Gltf {
    let positions: [[f32; 3]; 4] = [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]];
    let mut bytes: Vec<u8> = positions.iter().flatten().flat_map(|v| v.to_le_bytes()).collect();
    bytes.extend([0u16, 1, 2, 0, 2, 3].iter().flat_map(|v| v.to_le_bytes()));
    let json = json!({
        "asset": { "version": "2.0" },
        "buffers": [{ "byteLength": 60 }],
        "bufferViews": [
            { "buffer": 0, "byteLength": 48 },
            { "buffer": 0, "byteOffset": 48, "byteLength": 12 },
        ],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0] },
            { "bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR" },
        ],
        "materials": [{ "name": "grey", "pbrMetallicRoughness": { "baseColorFactor": [0.5, 0.25, 0.125, 1] } }],
        "meshes": [{ "name": "square", "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 1, "material": 0 }] }],
        "nodes": [{ "mesh": 0 }],
        "scenes": [{ "nodes": [0] }],
        "scene": 0,
    });
    Gltf { json, bytes }
}

impl Gltf {
    /// Sets the value at a JSON pointer; a last part that is missing is added.
    pub fn set(mut self, pointer: &str, value: Value) -> Self {
        let (parent, key) = pointer.rsplit_once('/').expect("a pointer");
        let parent = self
            .json
            .pointer_mut(parent)
            .unwrap_or_else(|| panic!("no parent of {pointer}"));
        match parent {
            Value::Array(list) if key == "-" => list.push(value),
            Value::Array(list) => list[key.parse::<usize>().expect("an index")] = value,
            object => object[key] = value,
        }
        self
    }

    pub fn remove(mut self, pointer: &str) -> Self {
        let (parent, key) = pointer.rsplit_once('/').expect("a pointer");
        let parent = self.json.pointer_mut(parent).and_then(Value::as_object_mut);
        parent
            .and_then(|p| p.remove(key))
            .unwrap_or_else(|| panic!("no {pointer}"));
        self
    }

    /// Appends bytes to the buffer, in a new buffer view.
    pub fn view(mut self, bytes: &[u8]) -> Self {
        let view = json!({ "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len() });
        self.bytes.extend(bytes);
        let length = self.bytes.len();
        self.set("/bufferViews/-", view)
            .set("/buffers/0/byteLength", json!(length))
    }

    /// Gives the square's four corners an attribute of floats, `kind` of them each.
    pub fn attribute(self, name: &str, kind: &str, values: &[f32]) -> Self {
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        let next = |list: &str| self.json[list].as_array().map_or(0, Vec::len);
        let (view, accessor) = (next("bufferViews"), next("accessors"));
        self.view(&bytes)
            .set(
                "/accessors/-",
                json!({"bufferView": view, "componentType": 5126, "count": 4, "type": kind}),
            )
            .set(&format!("/meshes/0/primitives/0/attributes/{name}"), json!(accessor))
    }

    pub fn glb(&self) -> Vec<u8> {
        let mut text = self.json.to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        let mut bytes = self.bytes.clone();
        bytes.resize(bytes.len().next_multiple_of(4), 0);
        let word = |n: usize| (n as u32).to_le_bytes();
        [
            b"glTF".as_slice(),
            &word(2),
            &word(28 + text.len() + bytes.len()),
            &word(text.len()),
            b"JSON",
            &text,
            &word(bytes.len()),
            b"BIN\0",
            &bytes,
        ]
        .concat()
    }

    pub fn load(&self) -> Result<Scene> {
        self.load_with(&ImportOptions::default())
    }

    pub fn load_with(&self, options: &ImportOptions) -> Result<Scene> {
        let folder = Folder::new().with("a.glb", self.glb());
        load_scene(&folder.path("a.glb"), options)
    }

    pub fn error(&self) -> String {
        Folder::new().with("a.glb", self.glb()).error("a.glb")
    }
}

pub fn base64(bytes: &[u8]) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::new();
    for chunk in bytes.chunks(3) {
        let bits = chunk
            .iter()
            .enumerate()
            .fold(0u32, |bits, (k, b)| bits | u32::from(*b) << (16 - 8 * k));
        (0..=chunk.len()).for_each(|k| text.push(LETTERS[(bits >> (18 - 6 * k)) as usize & 63] as char));
        (chunk.len()..3).for_each(|_| text.push('='));
    }
    text
}
