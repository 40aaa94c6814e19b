//! A unit cube in several forms, and with small triangles in it.

use super::kit::{empty_folder, write_file};
use common::sampling::pcg_hash;
use serde_json::Value;
use std::fmt::Write;
use std::fs;
use std::path::Path;

pub const MATERIALS: &str = "newmtl wall\nKd .5 .5 .5\nnewmtl lamp\nKd .5 .5 .5\nKe 1 1 1\n\
    newmtl sun\nKd .5 .5 .5\nKe 1e38 1e38 1e38\n";
/// Walls of a unit cube, fronts inwards; the second is the ceiling.
const WALLS: [[u32; 4]; 6] = [
    [1, 2, 3, 4],
    [8, 7, 6, 5],
    [1, 5, 6, 2],
    [4, 3, 7, 8],
    [1, 4, 8, 5],
    [2, 6, 7, 3],
];

/// A form of the room.
#[derive(Clone, Copy)]
pub struct Room {
    pub side: f64,
    pub lamp: &'static str,
    /// Number of copies of the room, every second one in triangles if `mixed`.
    pub times: u32,
    pub mixed: bool,
    pub inside_out: bool,
}

pub const ROOM: Room = Room {
    side: 1.0,
    lamp: "lamp",
    times: 1,
    mixed: false,
    inside_out: false,
};

impl Room {
    pub fn obj_text(self) -> String {
        let mut text = "mtllib m.mtl\n".to_owned();
        for z in [0.0, self.side] {
            for [x, y] in [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]] {
                writeln!(text, "v {:e} {:e} {z:e}", x * self.side, y * self.side).unwrap();
            }
        }
        for time in 0..self.times {
            for (k, mut wall) in WALLS.into_iter().enumerate() {
                if self.inside_out {
                    wall.reverse();
                }
                let material = if k == 1 { self.lamp } else { "wall" };
                let [a, b, c, d] = wall;
                writeln!(text, "usemtl {material}").unwrap();
                if self.mixed && time % 2 == 1 {
                    writeln!(text, "f {a} {b} {c}\nf {a} {c} {d}").unwrap();
                } else {
                    writeln!(text, "f {a} {b} {c} {d}").unwrap();
                }
            }
        }
        text
    }
}

pub fn folder_with_materials(name: &str) -> std::path::PathBuf {
    let folder = empty_folder(name);
    write_file(&folder, "m.mtl", MATERIALS);
    write_file(&folder, "room.obj", ROOM.obj_text());
    folder
}

/// Returns a number of 0…1.
pub fn unit_hash(k: u32) -> f64 {
    f64::from(pcg_hash(k)) / 2f64.powi(32)
}

/// Writes a room with `count` small triangles at random positions.
pub fn room_with_triangles(count: u32) -> String {
    let mut text = ROOM.obj_text() + "usemtl wall\n";
    for k in 0..count {
        let at = [0, 1, 2].map(|c| 0.03 + 0.9 * unit_hash(12 * k + c));
        for corner in 1..4 {
            let p = [0, 1, 2].map(|c| at[c as usize] + 0.03 * unit_hash(12 * k + 3 * corner + c));
            writeln!(text, "v {:.6} {:.6} {:.6}", p[0], p[1], p[2]).unwrap();
        }
        text += "f -3 -2 -1\n";
    }
    text
}

pub fn read_result(folder: &Path) -> Value {
    serde_json::from_slice(&fs::read(folder.join("out/result.json")).unwrap()).unwrap()
}
