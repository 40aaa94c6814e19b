//! A closed room in several forms, and with small triangles in it.

use super::command::TestFolder;
use common::sampling::pcg_hash;
use std::fmt::Write;

pub const MATERIALS: &str = "newmtl wall\nKd .6 .5 .4\nnewmtl lamp\nKd .5 .5 .5\nKe 1 1 1\n\
    newmtl sun\nKd .5 .5 .5\nKe 1e38 1e38 1e38\n";
/// Walls of a cube, fronts inwards; the second is the ceiling.
const WALLS: [[u32; 4]; 6] = [
    [1, 2, 3, 4],
    [8, 7, 6, 5],
    [1, 5, 6, 2],
    [4, 3, 7, 8],
    [1, 4, 8, 5],
    [2, 6, 7, 3],
];

/// A cube with fronts inwards, face 1 in the material `lamp`.
#[derive(Clone, Copy)]
pub struct Cube {
    pub low: f64,
    pub high: f64,
    pub lamp: &'static str,
    /// Number of copies, every second one in triangles if `mixed`.
    pub times: u32,
    pub mixed: bool,
    pub inside_out: bool,
}

/// The unit cube.
pub const ROOM: Cube = Cube {
    low: 0.0,
    high: 1.0,
    lamp: "lamp",
    times: 1,
    mixed: false,
    inside_out: false,
};

impl Cube {
    pub fn obj_text(self) -> String {
        let mut text = "mtllib m.mtl\n".to_owned();
        let (low, high) = (self.low, self.high);
        for z in [low, high] {
            for [x, y] in [[low, low], [high, low], [high, high], [low, high]] {
                writeln!(text, "v {x:e} {y:e} {z:e}").unwrap();
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

/// Makes a folder with the room, `room.obj`, a cube to put into it, `cube.obj`, and their materials, `m.mtl`.
pub fn folder_with_room() -> TestFolder {
    let folder = TestFolder::new();
    folder.write("m.mtl", MATERIALS);
    folder.write("room.obj", ROOM.obj_text());
    let cube = Cube {
        low: -0.1,
        high: 0.1,
        lamp: "wall",
        inside_out: true,
        ..ROOM
    };
    folder.write("cube.obj", cube.obj_text());
    folder
}

/// Returns a number of 0…1.
pub fn unit_hash(k: u32) -> f64 {
    f64::from(pcg_hash(k)) / 2f64.powi(32)
}

/// Returns the text of a room with `count` small triangles at random positions.
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
