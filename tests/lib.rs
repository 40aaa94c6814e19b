//! Scenes and helpers that several tests share.

use common::scene::{Face, Scene};
use glam::{DVec3, Vec3};

/// An axis-aligned box of six quads from `low` to `high`; fronts point inward or outward.
pub fn room(low: DVec3, high: DVec3, inward: bool, emission: Vec3, reflectance: Vec3) -> Vec<Face> {
    let p = |x: usize, y: usize, z: usize| {
        let c = [low, high];
        DVec3::new(c[x].x, c[y].y, c[z].z)
    };
    let quads = [
        ("floor", [p(0, 0, 0), p(0, 0, 1), p(1, 0, 1), p(1, 0, 0)]),
        ("ceiling", [p(0, 1, 0), p(1, 1, 0), p(1, 1, 1), p(0, 1, 1)]),
        ("left", [p(0, 0, 0), p(0, 1, 0), p(0, 1, 1), p(0, 0, 1)]),
        ("right", [p(1, 0, 0), p(1, 0, 1), p(1, 1, 1), p(1, 1, 0)]),
        ("front", [p(0, 0, 0), p(1, 0, 0), p(1, 1, 0), p(0, 1, 0)]),
        ("back", [p(0, 0, 1), p(0, 1, 1), p(1, 1, 1), p(1, 0, 1)]),
    ];
    quads
        .into_iter()
        .map(|(name, corners)| {
            let face = Face::quad(name, corners, emission, reflectance);
            if inward { face } else { face.reversed() }
        })
        .collect()
}

/// A scene of the given faces.
pub fn scene(name: &str, faces: Vec<Face>) -> Scene {
    Scene { name: name.to_owned(), faces, notes: Vec::new() }
}

/// The closed unit cube in which every face emits 1 W/m² and reflects `reflectance`.
pub fn furnace(reflectance: f32) -> Scene {
    scene("furnace", room(DVec3::ZERO, DVec3::ONE, true, Vec3::ONE, Vec3::splat(reflectance)))
}
