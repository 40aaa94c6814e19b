//! What an item buffer cannot hold: faces smaller than a pixel, straight edges that are curves on a
//! hemisphere, faces that cross the horizon, and its rim.

use super::shapes::{cuboid, floor, lamp, scene, square};
use super::{LAMBERT, case};
use crate::study::stress::trial::{Case, Trial, Truth};
use common::Result;
use common::scene::Face;
use glam::Vec3;

const TEXELS: u32 = 8;

/// The cases.
pub const CASES: &[Case] = &[
    case(
        ["vanishing-face", "side of the face / distance"],
        "a face smaller than an item buffer's pixel, before a wall",
        LAMBERT,
        &[0.3, 0.1, 0.01, 1e-3, 1e-4, 1e-5],
        |side| {
            let tiny = hanging(1.0, [0.51, 0.47], side, 0.5);
            let wall = hanging(1.2, [0.5; 2], 4.0, 0.0);
            lit(vec![tiny, wall, shining([0.5; 2], 1.0)])
        },
    ),
    case(
        ["tessellation", "side of the ceiling / its height"],
        "corners projected, and straight lines drawn between them",
        LAMBERT,
        &[1.0, 3.0, 10.0, 30.0, 100.0],
        |side| {
            let (low, high) = (
                [-side / 2.0, -side / 2.0, 0.0],
                [side / 2.0, side / 2.0, 1.0],
            );
            let mut faces = cuboid(low, high, true, 0.0);
            faces[1].reflectance = Vec3::splat(0.5);
            faces[0] = shining([0.0; 2], 0.2);
            lit(faces)
        },
    ),
    case(
        ["horizon", "depth of the wall below the horizon / distance"],
        "faces that cross the shooter's horizon",
        LAMBERT,
        &[0.1, 0.3, 1.0, 3.0, 10.0, 30.0],
        |depth| {
            let up = [0.0, 0.0, 1.0 + depth];
            let wall = square([1.0, -0.5, -depth], up, [0.0, 1.0, 0.0], 0.5);
            lit(vec![wall, shining([0.0; 2], 0.5)])
        },
    ),
    case(
        ["rim", "height of the wall / distance"],
        "the rim of the hemisphere: everything low is in its last pixels",
        LAMBERT,
        &[1.0, 0.1, 0.03, 0.01, 1e-3, 1e-4],
        |height| {
            let strip = square([1.0, -0.5, 0.0], [0.0, 0.0, height], [0.0, 1.0, 0.0], 0.5);
            let behind = square([1.2, -1.0, 0.0], [0.0, 0.0, 2.0], [0.0, 2.0, 0.0], 0.0);
            lit(vec![strip, behind, shining([0.0; 2], 0.1)])
        },
    ),
];

/// A lamp on the ground that looks up, about (x, y).
fn shining([x, y]: [f64; 2], side: f64) -> Face {
    let corner = [x - side / 2.0, y - side / 2.0, 0.0];
    lamp(corner, [side, 0.0, 0.0], [0.0, side, 0.0], 1.0)
}

/// A square that looks down, about (x, y).
fn hanging(height: f64, [x, y]: [f64; 2], side: f64, reflectance: f32) -> Face {
    let mut face = floor(height, [side; 2], reflectance).reversed();
    for corner in &mut face.corners {
        corner.x += x - side / 2.0;
        corner.y += y - side / 2.0;
    }
    face
}

fn lit(faces: Vec<Face>) -> Result<Trial> {
    Ok(Trial::new(scene("pixels", faces), TEXELS, Truth::Direct))
}
