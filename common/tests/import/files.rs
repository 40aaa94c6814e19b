//! Temporary folders for small files, and a glTF document to vary.

use common::Result;
use common::import::{ImportOptions, load_scene};
use common::scene::Scene;
use glam::DVec3;
use serde_json::{Value, json};
use std::io::Write;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU32, Ordering};
use std::{env, fs, process};

/// Returns the lines of an OBJ that stand in one: `;` ends a line, and `S` stands for the vertices of the unit square.
pub fn text_lines(text: &str) -> String {
    let square = "v 0 0 0; v 1 0 0; v 1 1 0; v 0 1 0; ";
    text.replace("S ", square).replace("; ", "\n").replace(';', "\n")
}

/// Temporary folder, removed with its contents when dropped.
pub struct Folder(PathBuf);

impl Folder {
    pub fn new() -> Self {
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let number = COUNT.fetch_add(1, Ordering::Relaxed);
        let path = env::temp_dir().join(format!("radiosity-common-{}-{number}", process::id()));
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
        let loaded = self.load(name).map(|scene| scene.notes);
        let error = loaded.expect_err(name).to_string();
        assert!(!error.contains('\n'), "more than a line: {error}");
        error.replace(&format!("{}/", self.0.display()), "")
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// Returns the folder RADIOSITY_DATA; prints a line on stderr if it is not set.
pub fn data_folder() -> Option<PathBuf> {
    let folder = env::var_os("RADIOSITY_DATA").map(PathBuf::from);
    if folder.is_none() {
        // Bypasses the test runner, which hides the output of passing tests.
        let thread = std::thread::current();
        let test = thread.name().unwrap_or("a test");
        let _ = writeln!(std::io::stderr(), "skipped {test}: RADIOSITY_DATA is not set");
    }
    folder
}

pub fn join_quads() -> ImportOptions {
    ImportOptions {
        join_quads: true,
        ..Default::default()
    }
}

/// Loads an OBJ of [`text_lines`] without materials.
pub fn obj(text: &str) -> Result<Scene> {
    Folder::new().with("a.obj", text_lines(text)).load("a.obj")
}

pub fn assert_begins(error: &str, expected: &str) {
    assert!(
        error.starts_with(expected),
        "`{error}` does not begin with `{expected}`"
    );
}

/// Returns the notes that contain `words`.
pub fn notes<'a>(scene: &'a Scene, words: &str) -> Vec<&'a str> {
    let notes = scene.notes.iter().map(String::as_str);
    notes.filter(|note| note.contains(words)).collect()
}

/// Returns the volume that fronts enclose: positive of a body, negative of a room seen from inside.
pub fn enclosed_volume(scene: &Scene) -> f64 {
    let cone = |c: &[DVec3]| c.windows(2).map(|w| c[0].dot(w[0].cross(w[1]))).sum::<f64>() / 6.0;
    scene.faces.iter().map(|f| cone(f.outline())).sum()
}

/// Returns the outline corners of each face.
pub fn corners(scene: &Scene) -> Vec<Vec<[f64; 3]>> {
    let outlines = scene.faces.iter().map(|face| face.outline().iter());
    outlines.map(|outline| outline.map(DVec3::to_array).collect()).collect()
}

pub fn float_bytes(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

/// The glTF file under variation: a JSON document and the bytes of buffer 0.
#[derive(Clone)]
pub struct Gltf {
    pub json: Value,
    pub bytes: Vec<u8>,
}

/// Returns the unit square in z = 0 as two triangles, grey, front to +z. Bytes: 4 positions, 6 u16.
pub fn square() -> Gltf {
    let mut bytes = float_bytes(&[0., 0., 0., 1., 0., 0., 1., 1., 0., 0., 1., 0.]);
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
        match self.json.pointer_mut(parent).expect(pointer) {
            Value::Array(list) if key == "-" => list.push(value),
            Value::Array(list) => list[key.parse::<usize>().expect("an index")] = value,
            object => object[key] = value,
        }
        self
    }

    pub fn remove(mut self, pointer: &str) -> Self {
        let (parent, key) = pointer.rsplit_once('/').expect("a pointer");
        let parent = self.json.pointer_mut(parent).and_then(Value::as_object_mut);
        parent.and_then(|parent| parent.remove(key)).expect(pointer);
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
        let next = |list: &str| self.json[list].as_array().map_or(0, Vec::len);
        let (view, accessor) = (next("bufferViews"), next("accessors"));
        let floats = json!({"bufferView": view, "componentType": 5126, "count": 4, "type": kind});
        self.view(&float_bytes(values))
            .set("/accessors/-", floats)
            .set(&format!("/meshes/0/primitives/0/attributes/{name}"), json!(accessor))
    }

    pub fn glb(&self) -> Vec<u8> {
        let header = gltf::binary::Header {
            magic: *b"glTF",
            version: 2,
            length: 0,
        };
        let glb = gltf::Glb {
            header,
            json: self.json.to_string().into_bytes().into(),
            bin: Some((&self.bytes).into()),
        };
        glb.to_vec().expect("a GLB")
    }

    pub fn load_with(&self, options: &ImportOptions) -> Result<Scene> {
        let folder = Folder::new().with("a.glb", self.glb());
        load_scene(&folder.path("a.glb"), options)
    }

    /// Loads a valid file.
    pub fn scene(&self) -> Scene {
        self.load_with(&ImportOptions::default()).expect("a scene")
    }

    pub fn error(&self) -> String {
        Folder::new().with("a.glb", self.glb()).error("a.glb")
    }
}
