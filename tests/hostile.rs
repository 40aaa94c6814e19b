//! No input ends in a panic, a hang, an abort or a lost result: each row of these tables is one
//! call of the program in a folder of hostile files, its exit code, and what it has to say.

#![cfg(unix)]

#[path = "hostile/mod.rs"]
mod hostile;

use hostile::{Row, folder, judge, row};
use std::fs;
use std::path::Path;
use std::process::Command;

/// A closed room of one quad a wall; the ceiling is a lamp.
const ROOM: &str = "mtllib m.mtl
v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1
usemtl wall\nf 1 2 3 4\nf 6 5 8 7\nf 5 1 4 8\nf 2 6 7 3\nf 5 6 2 1\nusemtl lamp\nf 4 3 7 8
";
const MATERIALS: &str = "newmtl wall\nKd .6 .5 .4\nnewmtl lamp\nKd .5 .5 .5\nKe 1 1 1\n";

/// A folder with a healthy room in it, `room.obj`.
fn with_room(name: &str) -> std::path::PathBuf {
    let folder = folder(name);
    put(&folder, "room.obj", ROOM);
    put(&folder, "m.mtl", MATERIALS);
    folder
}

fn put(folder: &Path, name: &str, text: impl AsRef<[u8]>) {
    fs::write(folder.join(name), text).unwrap();
}

/// A pipe that nobody writes into.
fn pipe(folder: &Path, name: &str) {
    let made = Command::new("mkfifo").arg(folder.join(name)).status();
    assert!(made.unwrap().success(), "mkfifo {name}");
}

/// Files that never end, or never begin.
const ENDLESS: &[Row] = &[
    row("solve pipe.obj --out out", 2, "pipe.obj: cannot be read"),
    row("solve zero.obj --out out", 2, "zero.obj: cannot be read"),
    row("solve huge.obj --out out", 2, "huge.obj: cannot be read"),
    row("solve library.obj --out out", 2, "pipe.obj cannot be read"),
    row("solve buffer.gltf --out out", 2, "pipe.obj cannot be read"),
    row("plan pipe.obj", 2, "pipe.obj: cannot be read"),
    row(
        "relight --room pipe.obj --out out",
        2,
        "pipe.obj: cannot be read",
    ),
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
    row(
        "relight --room piped --out out",
        2,
        "piped/result.json: cannot be read",
    ),
    row(
        "relight --room endless --out out",
        2,
        "endless/result.json: cannot be read",
    ),
    row(
        "relight --room walls --out out",
        2,
        "walls/000.exr: cannot be read",
    ),
    row(
        "diff dark endless --out out",
        2,
        "dark/lightmap.exr: cannot be read",
    ),
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
    row(
        "table4 --composite pipe.obj --out out",
        2,
        "pipe.obj: cannot be read",
    ),
    row(
        "merge pipe.obj zero.obj --seconds 1,4 --out out",
        2,
        "pipe.obj: cannot be read",
    ),
    row(
        "merge --exposures pipe.obj --out out",
        2,
        "pipe.obj: cannot be read",
    ),
    row(
        "merge --exposures zero.obj --out out",
        2,
        "zero.obj: cannot be read",
    ),
];

/// `dir`/result.json of one black quad of one texel.
fn one_quad(folder: &Path, dir: &str) {
    fs::create_dir_all(folder.join(dir)).unwrap();
    let quad = "[[0,0,0],[1,0,0],[1,1,0],[0,1,0]]";
    let text = format!(
        "{{\"faces\":[{{\"kind\":\"quad\",\"corners\":{quad},\"texels\":[1,1],\"rect\":[0,0,1,1],\"file\":\"000.exr\"}}]}}"
    );
    put(folder, &format!("{dir}/result.json"), text);
}

#[test]
fn what_never_ends_is_refused() {
    let folder = with_room("endless");
    pipe(&folder, "pipe.obj");
    let link = |from: &str, to: &str| std::os::unix::fs::symlink(from, folder.join(to)).unwrap();
    link("/dev/zero", "zero.obj");
    let huge = fs::File::create(folder.join("huge.obj")).unwrap();
    huge.set_len(1 << 42).unwrap();
    put(&folder, "library.obj", "mtllib pipe.obj\n");
    let buffer = r#"{"asset":{"version":"2.0"},"buffers":[{"uri":"pipe.obj","byteLength":4}]}"#;
    put(&folder, "buffer.gltf", buffer);
    for dir in ["piped", "endless", "walls"] {
        fs::create_dir(folder.join(dir)).unwrap();
    }
    pipe(&folder, "piped/result.json");
    link("/dev/zero", "endless/result.json");
    one_quad(&folder, "dark");
    pipe(&folder, "dark/lightmap.exr");
    one_quad(&folder, "walls");
    fs::rename(
        folder.join("walls/result.json"),
        folder.join("walls/room.json"),
    )
    .unwrap();
    pipe(&folder, "walls/000.exr");
    judge(&folder, ENDLESS);
    fs::remove_dir_all(folder).unwrap();
}
