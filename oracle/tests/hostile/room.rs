//! A healthy room, and results of it, to be damaged.

use super::kit::{folder, put, run};
use std::path::Path;

/// A closed room of one quad a wall; the ceiling is a lamp.
pub const ROOM: &str = "mtllib m.mtl
v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1
usemtl wall\nf 1 2 3 4\nf 6 5 8 7\nf 5 1 4 8\nf 2 6 7 3\nf 5 6 2 1\nusemtl lamp\nf 4 3 7 8
";
pub const MATERIALS: &str = "newmtl wall\nKd .6 .5 .4\nnewmtl lamp\nKd .5 .5 .5\nKe 1 1 1\n";

/// A folder with a healthy room in it, `room.obj`.
pub fn with_room(name: &str) -> std::path::PathBuf {
    let folder = folder(name);
    put(&folder, "room.obj", ROOM);
    put(&folder, "m.mtl", MATERIALS);
    folder
}

/// Solves `room.obj` into `dir`, with `more` options.
pub fn solved(folder: &Path, dir: &str, more: &[&str]) {
    let solve = ["solve", "room.obj", "--solver", "cpu", "--texels", "4"];
    let ended = run(
        folder,
        &[&solve[..], &["--quiet", "--out", dir], more].concat(),
    );
    assert_eq!((ended.code, ended.stderr.as_str()), (Some(0), ""));
}
