//! What the cases are built of: squares, lamps, boxes. z is up.

use common::Result;
use common::import::{ImportOptions, load};
use common::scene::{Face, Scene};
use common::solution::{prepare, write_file};
use glam::{DQuat, DVec3, Vec3};
use std::sync::atomic::{AtomicUsize, Ordering};

/// A parallelogram from `corner` along `u` and `v`, its front along u × v; grey, not emitting.
pub fn square(corner: [f64; 3], u: [f64; 3], v: [f64; 3], reflectance: f32) -> Face {
    face("square", corner, [u, v], 0.0, reflectance)
}

/// The same as a lamp of radiosity `emission`, which reflects nothing.
pub fn lamp(corner: [f64; 3], u: [f64; 3], v: [f64; 3], emission: f32) -> Face {
    face("lamp", corner, [u, v], emission, 0.0)
}

/// A parallelogram with its own emission and reflectance.
pub fn face(
    name: &str,
    corner: [f64; 3],
    sides: [[f64; 3]; 2],
    emission: f32,
    reflectance: f32,
) -> Face {
    let c = DVec3::from(corner);
    let [u, v] = sides.map(DVec3::from);
    let corners = [c, c + u, c + u + v, c + v];
    Face::quad(
        name,
        corners,
        Vec3::splat(emission),
        Vec3::splat(reflectance),
    )
}

/// A floor [0, a]×[0, b] at height z that looks up.
pub fn floor(z: f64, [a, b]: [f64; 2], reflectance: f32) -> Face {
    square([0.0, 0.0, z], [a, 0.0, 0.0], [0.0, b, 0.0], reflectance)
}

/// The floor [0, 1]×[0, 1].
pub fn unit() -> Face {
    floor(0.0, [1.0; 2], 0.5)
}

/// A lamp that looks down, a×b about (x, y) at height z.
pub fn lamp_above([x, y, z]: [f64; 3], [a, b]: [f64; 2], emission: f32) -> Face {
    let corner = [x - a / 2.0, y - b / 2.0, z];
    lamp(corner, [0.0, b, 0.0], [a, 0.0, 0.0], emission)
}

/// A plate that looks up, a×b about (x, y) at height z.
pub fn plate([x, y, z]: [f64; 3], [a, b]: [f64; 2], reflectance: f32) -> Face {
    let corner = [x - a / 2.0, y - b / 2.0, z];
    square(corner, [a, 0.0, 0.0], [0.0, b, 0.0], reflectance)
}

/// The six faces of a box: floor, ceiling, left, right, front, back; looking inwards, or outwards.
pub fn cuboid(low: [f64; 3], high: [f64; 3], inwards: bool, reflectance: f32) -> Vec<Face> {
    let [x0, y0, z0] = low;
    let [x1, y1, z1] = high;
    let [a, b, c] = [x1 - x0, y1 - y0, z1 - z0];
    let (x, y, z) = ([a, 0.0, 0.0], [0.0, b, 0.0], [0.0, 0.0, c]);
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
        face(name, corner, sides, 0.0, reflectance)
    });
    made.collect()
}

/// A scene of these faces.
pub fn scene(name: &str, faces: Vec<Face>) -> Scene {
    Scene {
        name: name.to_owned(),
        faces,
        notes: Vec::new(),
    }
}

/// Every corner moved.
pub fn moved(mut scene: Scene, to: impl Fn(DVec3) -> DVec3) -> Scene {
    for face in &mut scene.faces {
        face.corners = face.corners.map(&to);
    }
    scene
}

/// Turned by an odd angle about an odd axis, so that every coordinate is rounded.
pub fn tilted(scene: Scene) -> Scene {
    let turn = DQuat::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 0.7);
    moved(scene, |p| turn * p)
}

/// A scene read as a user's file is: `mtl` is its m.mtl.
pub fn imported(name: &str, obj: &str, mtl: &str) -> Result<Scene> {
    static COUNT: AtomicUsize = AtomicUsize::new(0);
    let number = COUNT.fetch_add(1, Ordering::Relaxed);
    let folder = format!("radiosity-stress-{}-{number}", std::process::id());
    let folder = std::env::temp_dir().join(folder);
    prepare(&folder)?;
    let path = folder.join(format!("{name}.obj"));
    let read = write_file(&folder.join("m.mtl"), mtl.as_bytes())
        .and_then(|()| write_file(&path, obj.as_bytes()))
        .and_then(|()| load(&path, &ImportOptions::default()));
    // What is left behind in the temporary folder harms nobody.
    let _ = std::fs::remove_dir_all(&folder);
    read
}
