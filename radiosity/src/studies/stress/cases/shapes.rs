//! Shapes that the cases are built of: squares, lamps, boxes. z points up.

use common::Result;
use common::file::keep_in_memory;
use common::import::{ImportOptions, load_scene};
use common::scene::{Face, Scene};
use glam::{DQuat, DVec3, Vec3};
use std::path::PathBuf;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Makes a parallelogram from `corner` along `u` and `v` that faces u × v; grey, not emitting.
pub fn grey_square(corner: [f64; 3], u: [f64; 3], v: [f64; 3], reflectance: f32) -> Face {
    parallelogram("square", corner, [u, v], reflectance)
}

/// Makes a black parallelogram lamp of emitted radiosity `emission`, W/m².
pub fn square_lamp(corner: [f64; 3], u: [f64; 3], v: [f64; 3], emission: f32) -> Face {
    Face {
        emission: Vec3::splat(emission),
        ..parallelogram("lamp", corner, [u, v], 0.0)
    }
}

fn parallelogram(name: &str, corner: [f64; 3], sides: [[f64; 3]; 2], reflectance: f32) -> Face {
    let c = DVec3::from(corner);
    let [u, v] = sides.map(DVec3::from);
    Face::quad(name, [c, c + u, c + u + v, c + v], Vec3::ZERO, Vec3::splat(reflectance))
}

/// Makes a floor [0, a]×[0, b] at height z that faces up.
pub fn floor_square(z: f64, [a, b]: [f64; 2]) -> Face {
    grey_square([0.0, 0.0, z], [a, 0.0, 0.0], [0.0, b, 0.0], 0.5)
}

/// Makes the floor [0, 1]×[0, 1].
pub fn unit_floor() -> Face {
    floor_square(0.0, [1.0; 2])
}

/// Makes an a×b lamp that faces down, centred at (x, y, z).
pub fn lamp_above([x, y, z]: [f64; 3], [a, b]: [f64; 2], emission: f32) -> Face {
    let corner = [x - a / 2.0, y - b / 2.0, z];
    square_lamp(corner, [0.0, b, 0.0], [a, 0.0, 0.0], emission)
}

/// Makes a square lamp on the ground that faces up, centred at (x, y).
pub fn ground_lamp([x, y]: [f64; 2], side: f64) -> Face {
    let corner = [x - side / 2.0, y - side / 2.0, 0.0];
    square_lamp(corner, [side, 0.0, 0.0], [0.0, side, 0.0], 1.0)
}

/// Makes an a×b plate that faces up, centred at (x, y, z).
pub fn plate_at([x, y, z]: [f64; 3], [a, b]: [f64; 2], reflectance: f32) -> Face {
    let corner = [x - a / 2.0, y - b / 2.0, z];
    grey_square(corner, [a, 0.0, 0.0], [0.0, b, 0.0], reflectance)
}

/// Makes the six faces of a box: floor, ceiling, left, right, front, back; they face inwards or
/// outwards.
pub fn box_faces(low: [f64; 3], high: [f64; 3], inwards: bool, reflectance: f32) -> Vec<Face> {
    let [x0, y0, z0] = low;
    let [x1, y1, z1] = high;
    let (x, y, z) = ([x1 - x0, 0.0, 0.0], [0.0, y1 - y0, 0.0], [0.0, 0.0, z1 - z0]);
    let faces = [
        ("floor", [x0, y0, z0], [x, y]),
        ("ceiling", [x0, y0, z1], [y, x]),
        ("left", [x0, y0, z0], [y, z]),
        ("right", [x1, y0, z0], [z, y]),
        ("front", [x0, y0, z0], [z, x]),
        ("back", [x0, y1, z0], [x, z]),
    ];
    let made = faces.into_iter().map(|(name, corner, [u, v])| {
        let sides = if inwards { [u, v] } else { [v, u] };
        parallelogram(name, corner, sides, reflectance)
    });
    made.collect()
}

/// Makes the inside of the unit cube, as [`box_faces`].
pub fn unit_room(reflectance: f32) -> Vec<Face> {
    box_faces([0.0; 3], [1.0; 3], true, reflectance)
}

/// Cuts a face into n×m pieces: n from its edge 0–3 to its edge 1–2.
pub fn cut_face(face: &Face, [n, m]: [usize; 2]) -> Vec<Face> {
    let at = |i: usize, j: usize| face.point_at(i as f64 / n as f64, j as f64 / m as f64);
    let piece = |k: usize| {
        let (i, j) = (k % n, k / n);
        Face {
            corners: [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)],
            ..face.clone()
        }
    };
    (0..n * m).map(piece).collect()
}

/// Makes a scene of these faces.
pub fn scene_of(faces: Vec<Face>) -> Scene {
    Scene {
        name: "case".to_owned(),
        faces,
        ..Scene::default()
    }
}

/// Applies `to` to every corner.
pub fn move_faces(mut faces: Vec<Face>, to: impl Fn(DVec3) -> DVec3) -> Vec<Face> {
    for face in &mut faces {
        face.corners = face.corners.map(&to);
    }
    faces
}

/// Rotates faces about an oblique axis, so that every coordinate is rounded.
pub fn tilt_faces(faces: Vec<Face>) -> Vec<Face> {
    let turn = DQuat::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 0.7);
    move_faces(faces, |p| turn * p)
}

/// Imports an OBJ text; `mtl` is its m.mtl. Errors: the import fails.
pub fn import_text(obj: &str, mtl: &str) -> Result<Scene> {
    static COUNT: AtomicUsize = AtomicUsize::new(0);
    let number = COUNT.fetch_add(1, Ordering::Relaxed);
    let folder = PathBuf::from(format!("case-{number}"));
    let files = [("m.mtl", mtl), ("case.obj", obj)].map(|(name, text)| (folder.join(name), text));
    for (path, text) in &files {
        keep_in_memory(path, Some(text.as_bytes().to_vec()));
    }
    let read = load_scene(&files[1].0, &ImportOptions::default());
    for (path, _) in &files {
        keep_in_memory(path, None);
    }
    read
}
