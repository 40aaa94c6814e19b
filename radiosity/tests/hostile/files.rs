//! Files that never end, are cut off, or have the wrong format.

use super::kit::{Row, assert_rows, empty_folder, row, write_file};
use super::room::folder_with_room;
use serde_json::json;
use std::fs;
use std::path::Path;
use std::process::Command;

/// Makes a pipe that nobody writes into.
fn make_pipe(folder: &Path, name: &str) {
    let made = Command::new("mkfifo").arg(folder.join(name)).status();
    assert!(made.unwrap().success(), "mkfifo {name}");
}

/// Writes the material of a triangle with this texture into `t.mtl`; returns the triangle.
fn textured_triangle(picture: &str, folder: &Path) -> &'static str {
    write_file(folder, "t.mtl", format!("newmtl m\nKe 1\nmap_Kd {picture}\n"));
    "mtllib t.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl m\nf 1/1 2/1 3/1\n"
}

/// Pipes, devices and huge files.
const ENDLESS: &[Row] = &[
    row("solve pipe.obj --out out", 2, "pipe.obj: cannot be read"),
    row("solve zero.obj --out out", 2, "zero.obj: cannot be read"),
    row("solve huge.obj --out out", 2, "huge.obj: cannot be read"),
    row("solve library.obj --out out", 2, "pipe.obj cannot be read"),
    row("solve buffer.gltf --out out", 2, "pipe.obj cannot be read"),
    row(
        "solve texture.obj --out out",
        2,
        "t.mtl: material m: map_Kd pipe.obj cannot be read",
    ),
    row("solve pipe.obj --dry-run", 2, "pipe.obj: cannot be read"),
    row("relight --room pipe.obj --out out", 2, "pipe.obj: cannot be read"),
    row(
        "relight --room zero.obj --room-size 1,1,1 --out out",
        2,
        "zero.obj: cannot be read",
    ),
    row(
        "relight --room room.obj --object pipe.obj --out out",
        2,
        "pipe.obj: cannot be read",
    ),
    row("relight --room piped --out out", 2, "piped/result.json: cannot be read"),
    row(
        "relight --room endless --out out",
        2,
        "endless/result.json: cannot be read",
    ),
    row("relight --room walls --out out", 2, "walls/000.exr: cannot be read"),
    row("diff dark endless --out out", 2, "dark/lightmap.exr: cannot be read"),
    row(
        "chart room.obj --solver cpu --peers pipe.obj --out out",
        2,
        "pipe.obj: cannot be read",
    ),
    row(
        "chart room.obj --solver cpu --truth piped --out out",
        2,
        "piped/result.json: cannot be read",
    ),
    row(
        "converge room.obj --truth piped --out out",
        2,
        "piped/result.json: cannot be read",
    ),
    row("table4 --composite pipe.obj --out out", 2, "pipe.obj: cannot be read"),
    row(
        "merge pipe.obj zero.obj --seconds 1,4 --out out",
        2,
        "pipe.obj: cannot be read",
    ),
    row("merge --exposures pipe.obj --out out", 2, "pipe.obj: cannot be read"),
    row("merge --exposures zero.obj --out out", 2, "zero.obj: cannot be read"),
];

/// Writes `dir`/result.json of one black quad of one texel.
fn write_one_quad(folder: &Path, dir: &str) {
    fs::create_dir_all(folder.join(dir)).unwrap();
    let quad = "[[0,0,0],[1,0,0],[1,1,0],[0,1,0]]";
    let text = format!(
        "{{\"faces\":[{{\"kind\":\"quad\",\"corners\":{quad},\"texels\":[1,1],\"rect\":[0,0,1,1],\"file\":\"000.exr\"}}]}}"
    );
    write_file(folder, &format!("{dir}/result.json"), text);
}

#[test]
fn endless_files_are_refused() {
    let folder = folder_with_room("endless");
    make_pipe(&folder, "pipe.obj");
    let link = |from: &str, to: &str| std::os::unix::fs::symlink(from, folder.join(to)).unwrap();
    link("/dev/zero", "zero.obj");
    let huge = fs::File::create(folder.join("huge.obj")).unwrap();
    huge.set_len(1 << 42).unwrap();
    write_file(&folder, "library.obj", "mtllib pipe.obj\n");
    write_file(&folder, "texture.obj", textured_triangle("pipe.obj", &folder));
    let buffer = r#"{"asset":{"version":"2.0"},"buffers":[{"uri":"pipe.obj","byteLength":4}]}"#;
    write_file(&folder, "buffer.gltf", buffer);
    for dir in ["piped", "endless", "walls"] {
        fs::create_dir(folder.join(dir)).unwrap();
    }
    make_pipe(&folder, "piped/result.json");
    link("/dev/zero", "endless/result.json");
    write_one_quad(&folder, "dark");
    make_pipe(&folder, "dark/lightmap.exr");
    write_one_quad(&folder, "walls");
    fs::rename(folder.join("walls/result.json"), folder.join("walls/room.json")).unwrap();
    make_pipe(&folder, "walls/000.exr");
    assert_rows(&folder, ENDLESS);
    fs::remove_dir_all(folder).unwrap();
}

/// Files that are cut off or of another version, and healthy ones like them.
const DAMAGED: &[Row] = &[
    row(
        "merge cut.jpg long.jpg --seconds 1,4 --out out",
        2,
        "cut.jpg: is cut off",
    ),
    row(
        "merge almost.jpg long.jpg --seconds 1,4 --out out",
        2,
        "almost.jpg: is cut off",
    ),
    row(
        "solve v1.gltf --out out",
        2,
        "v1.gltf: is glTF version 1.0: export it as version 2",
    ),
    row(
        "solve v3.gltf --out out",
        2,
        "v3.gltf: is glTF version 3.0: export it as version 2",
    ),
    row("merge short.jpg long.jpg --seconds 1,4 --out out", 0, "2 exposures"),
    row(
        "solve fine.gltf --allow-dark --solver cpu --texels 2 --out out",
        0,
        "1 faces",
    ),
    row(
        "solve texture.obj --out out",
        2,
        "t.mtl: material m: map_Kd cut.jpg is cut off",
    ),
    row(
        "solve index.gltf --out out",
        2,
        "index.gltf: has the index 4294967296 in `mesh`",
    ),
];

/// Makes a glTF of one triangle, whose node has the mesh index `mesh`.
fn gltf_triangle(version: &str, mesh: u64) -> String {
    use base64::{Engine, engine::general_purpose::STANDARD};
    let corners = [[0.0_f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let bytes: Vec<u8> = corners.as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect();
    let uri = format!("data:application/octet-stream;base64,{}", STANDARD.encode(&bytes));
    json!({
        "asset": {"version": version},
        "nodes": [{"mesh": mesh}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "buffers": [{"byteLength": 36, "uri": uri}],
    })
    .to_string()
}

#[test]
fn damaged_files_are_refused() {
    let folder = empty_folder("damaged");
    // Codes of a smooth scene, gamma 2, and of four times the exposure.
    for (name, brightness) in [("short.jpg", 1), ("long.jpg", 2)] {
        let code = |x: u32| (brightness * x).min(255) as u8;
        let image = image::RgbImage::from_fn(120, 90, |x, _| image::Rgb([code(x + 10); 3]));
        image.save(folder.join(name)).unwrap();
    }
    let bytes = fs::read(folder.join("short.jpg")).unwrap();
    write_file(&folder, "cut.jpg", &bytes[..bytes.len() * 4 / 5]);
    write_file(&folder, "almost.jpg", &bytes[..bytes.len() - 1]);
    write_file(&folder, "v1.gltf", gltf_triangle("1.0", 0));
    write_file(&folder, "v3.gltf", gltf_triangle("3.0", 0));
    write_file(&folder, "index.gltf", gltf_triangle("2.0", 1 << 32));
    write_file(&folder, "texture.obj", textured_triangle("cut.jpg", &folder));
    write_file(&folder, "fine.gltf", gltf_triangle("2.0", 0));
    assert_rows(&folder, DAMAGED);
    fs::remove_dir_all(folder).unwrap();
}
