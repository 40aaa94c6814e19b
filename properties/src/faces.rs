//! Boxes, scenes of faces, and other orders of a face's corners.

use common::scene::{Face, Scene};
use glam::{DVec3, Vec3};

/// Makes an axis-aligned box of six quads from `low` to `high`; fronts point inward or outward.
pub fn box_faces(low: DVec3, high: DVec3, inward: bool, emission: Vec3, reflectance: Vec3) -> Vec<Face> {
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

/// Makes a scene of the given faces.
pub fn named_scene(name: &str, faces: Vec<Face>) -> Scene {
    Scene {
        name: name.to_owned(),
        faces,
        ..Scene::default()
    }
}

/// Returns the face with another first corner, and its texels rotated with it.
pub(crate) fn rotate_corners(face: &Face, [w, h]: [u32; 2], by: usize) -> (Face, [u32; 2]) {
    let n = face.outline().len();
    let mut corners = face.outline().to_vec();
    corners.rotate_left(by % n);
    let face = Face {
        corners: [corners[0], corners[1], corners[2], corners[n - 1]],
        ..face.clone()
    };
    let resolution = if by.is_multiple_of(2) || n == 3 { [w, h] } else { [h, w] };
    (face, resolution)
}
