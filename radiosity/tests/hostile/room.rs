//! A valid room, and results of it, which tests damage.

use super::kit::{empty_folder, run_program, write_file};
use std::path::Path;

/// A closed room of one quad per wall; the ceiling is a lamp.
pub const ROOM: &str = "mtllib m.mtl
v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1
usemtl wall\nf 1 2 3 4\nf 6 5 8 7\nf 5 1 4 8\nf 2 6 7 3\nf 5 6 2 1\nusemtl lamp\nf 4 3 7 8
";
pub const MATERIALS: &str = "newmtl wall\nKd .6 .5 .4\nnewmtl lamp\nKd .5 .5 .5\nKe 1 1 1\n";

/// Makes a folder with a valid room, `room.obj`.
pub fn folder_with_room(name: &str) -> std::path::PathBuf {
    let folder = empty_folder(name);
    write_file(&folder, "room.obj", ROOM);
    write_file(&folder, "m.mtl", MATERIALS);
    folder
}

/// Runs `solve` or `shoot` on `room.obj` into `dir`, with `more` options.
pub fn solve_into(command: &str, folder: &Path, dir: &str, more: &[&str]) {
    let solve = [command, "room.obj", "--solver", "cpu", "--texels", "4"];
    let ended = run_program(folder, &[&solve[..], &["--quiet", "--out", dir], more].concat());
    assert_eq!((ended.code, ended.stderr.as_str()), (Some(0), ""));
}
