//! Readers of scene files: OBJ with MTL, glTF with its buffers, GLB, Draco.

use crate::allow_caught_panics;
use crate::folder::Folder;
use crate::numbers::Numbers;
use crate::requirements::{require_one_line, require_sound_scene};
use common::Result;
use common::import::{ImportOptions, SceneFile, load_scene, load_scene_file};
use common::scene::{Face, Scene};
use glam::{DVec3, Vec3};
use serde_json::{Map, Value, json};

/// A red and a green pixel above a blue and a white one.
pub const PICTURE: &[u8] = include_bytes!("../../fuzz/corpus/texture/four_pixels.png");

/// Materials of an OBJ whose own are not checked.
const MATERIALS: &[u8] = b"newmtl wall\nKd 0.5 0.25 0.125\nnewmtl lamp\nKe 1 2 3\nnewmtl picture\nmap_Kd p.png\n";

/// An OBJ that uses every material that an MTL may have by these names.
const USERS_OF_MATERIALS: &[u8] = b"mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n\
    usemtl a\nf 1/1 2/2 3/3 4/4\nusemtl b\nf 4/1 3/2 2/3 1/4\n";

/// Largest number of corners of a polygon that is made of an input.
const MAX_CORNERS: usize = 48;

thread_local! {
    static OBJ_FOLDER: Folder = Folder::new(&[("m.mtl", MATERIALS), ("p.png", PICTURE)]);
    static MTL_FOLDER: Folder = Folder::new(&[("a.obj", USERS_OF_MATERIALS), ("p.png", PICTURE)]);
    static GLTF_FOLDER: Folder = Folder::new(&[("p.png", PICTURE)]);
}

/// Checks the reader of OBJ files, beside which lie `m.mtl` with the materials wall, lamp and picture.
pub fn check_obj(data: &[u8]) {
    OBJ_FOLDER.with(|folder| {
        folder.write("a.obj", data);
        let path = folder.path("a.obj");
        require_sound_file(load_scene_file(&path, &ImportOptions::default()));
    });
}

/// Checks the reader of MTL files, by an OBJ that uses the materials a and b.
pub fn check_mtl(data: &[u8]) {
    MTL_FOLDER.with(|folder| {
        folder.write("m.mtl", data);
        require_sound(load_scene(&folder.path("a.obj"), &ImportOptions::default()));
    });
}

/// Checks the reader of glTF files: JSON up to the first byte 0, and behind it the buffer `b.bin`. Beside it lies the
/// picture `p.png`.
pub fn check_gltf(data: &[u8]) {
    allow_caught_panics();
    GLTF_FOLDER.with(|folder| {
        let (json, buffer) = split_at_zero(data);
        folder.write("a.gltf", json);
        folder.write("b.bin", buffer);
        let path = folder.path("a.gltf");
        require_sound_file(load_scene_file(&path, &joined_and_two_sided()));
        let charts = ImportOptions {
            charts: true,
            reflectance: Some(Vec3::splat(0.5)),
            ..ImportOptions::default()
        };
        require_sound(load_scene(&path, &charts));
    });
}

/// Checks the reader of GLB files.
pub fn check_glb(data: &[u8]) {
    allow_caught_panics();
    GLTF_FOLDER.with(|folder| {
        folder.write("a.glb", data);
        require_sound_file(load_scene_file(&folder.path("a.glb"), &ImportOptions::default()));
    });
}

/// Checks the reader of meshes that are compressed by Draco: of the positions alone, then of normals and texture coordinates
/// as well.
pub fn check_draco(data: &[u8]) {
    allow_caught_panics();
    GLTF_FOLDER.with(|folder| {
        folder.write("b.bin", data);
        for attributes in [&["POSITION"][..], &["POSITION", "NORMAL", "TEXCOORD_0"]] {
            let document = compressed_mesh(data.len(), attributes);
            folder.write("a.gltf", document.to_string().as_bytes());
            require_sound(load_scene(&folder.path("a.gltf"), &ImportOptions::default()));
        }
    });
}

/// Checks the division of polygons: the pieces have the vector area of the polygon. The first byte chooses the distance from
/// the origin, every six bytes are a corner.
pub fn check_polygon(data: &[u8]) {
    let mut numbers = Numbers(data);
    let offset = numbers.choice(&[0.0, 1.0, 1e3, 1e6]);
    let mut corners = Vec::new();
    while !numbers.0.is_empty() && corners.len() < MAX_CORNERS {
        let mut coordinate = || offset + f64::from(i16::from_le_bytes(numbers.take())) / 256.0;
        corners.push(DVec3::new(coordinate(), coordinate(), coordinate()));
    }
    let lines = corners.iter().map(|p| format!("v {} {} {}\n", p.x, p.y, p.z));
    let numbers = (1..=corners.len()).map(|k| format!(" {k}"));
    let text = lines.collect::<String>() + "f" + &numbers.collect::<String>() + "\n";
    OBJ_FOLDER.with(|folder| {
        folder.write("a.obj", text.as_bytes());
        match load_scene(&folder.path("a.obj"), &ImportOptions::default()) {
            Ok(scene) => {
                require_sound_scene(&scene);
                require_area_of(&scene, &corners);
            }
            Err(error) => require_one_line(&error),
        }
    });
}

fn joined_and_two_sided() -> ImportOptions {
    ImportOptions {
        join_quads: true,
        two_sided: true,
        ..ImportOptions::default()
    }
}

/// Splits at the first byte 0, which belongs to neither part.
pub fn split_at_zero(data: &[u8]) -> (&[u8], &[u8]) {
    match data.iter().position(|byte| *byte == 0) {
        Some(at) => (&data[..at], &data[at + 1..]),
        None => (data, &[]),
    }
}

fn require_sound(loaded: Result<Scene>) {
    match loaded {
        Ok(scene) => require_sound_scene(&scene),
        Err(error) => require_one_line(&error),
    }
}

/// Requires of a kept file that its triangles are those of the scene's faces.
fn require_sound_file(loaded: Result<(Scene, SceneFile)>) {
    match loaded {
        Ok((scene, file)) => {
            require_sound_scene(&scene);
            for triangle in file.primitives.iter().flat_map(|primitive| &primitive.triangles) {
                let face = &scene.faces[triangle.face as usize];
                let is_known = |p: &DVec3| face.corners.contains(p);
                assert!(triangle.positions.iter().all(is_known), "{triangle:?} of {face:?}");
            }
        }
        Err(error) => require_one_line(&error),
    }
}

/// Requires that the faces have the vector area of a polygon, but for pieces without area that were dropped.
fn require_area_of(scene: &Scene, corners: &[DVec3]) {
    let from_first = |w: &[DVec3]| (w[0] - corners[0]).cross(w[1] - corners[0]) * 0.5;
    let whole: DVec3 = corners.windows(2).map(from_first).sum();
    let pieces: DVec3 = scene.faces.iter().map(Face::vector_area).sum();
    let size = corners.iter().map(|p| p.distance(corners[0])).fold(0.0, f64::max);
    let far = corners.iter().map(|p| p.length()).fold(0.0, f64::max);
    let Some(normal) = whole.try_normalize() else {
        return;
    };
    let tolerance = 1e-9 * size * size + 1e-12 * far * size;
    let off = (pieces - whole).dot(normal);
    assert!(off.abs() <= tolerance, "{pieces} instead of {whole}: {corners:?}");
}

/// Returns a document of one mesh whose data, of `length` bytes, lie in `b.bin`; they have these attributes.
fn compressed_mesh(length: usize, attributes: &[&str]) -> Value {
    let extension = "KHR_draco_mesh_compression";
    let numbered = |first: usize| -> Map<String, Value> {
        let names = attributes.iter().enumerate();
        names.map(|(k, name)| ((*name).to_owned(), json!(first + k))).collect()
    };
    let values = |kind: &str, component: u32| json!({ "componentType": component, "count": 3, "type": kind });
    json!({
        "asset": { "version": "2.0" },
        "extensionsRequired": [extension],
        "extensionsUsed": [extension],
        "buffers": [{ "uri": "b.bin", "byteLength": length }],
        "bufferViews": [{ "buffer": 0, "byteLength": length }],
        "accessors": [values("SCALAR", 5123), values("VEC3", 5126), values("VEC3", 5126), values("VEC2", 5126)],
        "meshes": [{ "primitives": [{
            "attributes": numbered(1),
            "indices": 0,
            "extensions": { extension: { "bufferView": 0, "attributes": numbered(0) } },
        }] }],
        "nodes": [{ "mesh": 0 }],
        "scenes": [{ "nodes": [0] }],
        "scene": 0,
    })
}
