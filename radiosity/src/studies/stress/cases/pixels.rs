//! Cases that an item buffer cannot represent: faces smaller than a pixel, straight edges that are
//! curves on a hemisphere, faces across the horizon, and its rim.

use super::shapes::{box_faces, floor_square, grey_square, scene_of, square_lamp};
use super::{LAMBERT_TRUTH, rms_case};
use crate::studies::stress::trial::{Case, Trial, TrialTruth};
use common::Result;
use common::scene::Face;
use glam::Vec3;

const TEXELS_PER_SIDE: u32 = 8;

/// The cases of this file.
pub const PIXEL_CASES: &[Case] = &[
    rms_case(
        ["vanishing-face", "side of the face / distance"],
        "a face smaller than an item buffer's pixel, before a wall",
        LAMBERT_TRUTH,
        &[0.3, 0.1, 0.01, 1e-3, 1e-4, 1e-5],
        |side| {
            let tiny = hanging_square(1.0, [0.51, 0.47], side, 0.5);
            let wall = hanging_square(1.2, [0.5; 2], 4.0, 0.0);
            direct_trial(vec![tiny, wall, ground_lamp([0.5; 2], 1.0)])
        },
    ),
    rms_case(
        ["tessellation", "side of the ceiling / its height"],
        "corners projected, and straight lines drawn between them",
        LAMBERT_TRUTH,
        &[1.0, 3.0, 10.0, 30.0, 100.0],
        |side| {
            let (low, high) = ([-side / 2.0, -side / 2.0, 0.0], [side / 2.0, side / 2.0, 1.0]);
            let mut faces = box_faces(low, high, true, 0.0);
            faces[1].reflectance = Vec3::splat(0.5);
            faces[0] = ground_lamp([0.0; 2], 0.2);
            direct_trial(faces)
        },
    ),
    rms_case(
        ["horizon", "depth of the wall below the horizon / distance"],
        "faces that cross the shooter's horizon",
        LAMBERT_TRUTH,
        &[0.1, 0.3, 1.0, 3.0, 10.0, 30.0],
        |depth| {
            let up = [0.0, 0.0, 1.0 + depth];
            let wall = grey_square([1.0, -0.5, -depth], up, [0.0, 1.0, 0.0], 0.5);
            direct_trial(vec![wall, ground_lamp([0.0; 2], 0.5)])
        },
    ),
    rms_case(
        ["rim", "height of the wall / distance"],
        "the rim of the hemisphere: everything low is in its last pixels",
        LAMBERT_TRUTH,
        &[1.0, 0.1, 0.03, 0.01, 1e-3, 1e-4],
        |height| {
            let strip = grey_square([1.0, -0.5, 0.0], [0.0, 0.0, height], [0.0, 1.0, 0.0], 0.5);
            let behind = grey_square([1.2, -1.0, 0.0], [0.0, 0.0, 2.0], [0.0, 2.0, 0.0], 0.0);
            direct_trial(vec![strip, behind, ground_lamp([0.0; 2], 0.1)])
        },
    ),
];

/// Makes a square lamp at z = 0 that faces up, centred at (x, y).
fn ground_lamp([x, y]: [f64; 2], side: f64) -> Face {
    let corner = [x - side / 2.0, y - side / 2.0, 0.0];
    square_lamp(corner, [side, 0.0, 0.0], [0.0, side, 0.0], 1.0)
}

/// Makes a square that faces down, centred at (x, y).
fn hanging_square(height: f64, [x, y]: [f64; 2], side: f64, reflectance: f32) -> Face {
    let mut face = floor_square(height, [side; 2], reflectance).reversed();
    for corner in &mut face.corners {
        corner.x += x - side / 2.0;
        corner.y += y - side / 2.0;
    }
    face
}

fn direct_trial(faces: Vec<Face>) -> Result<Trial> {
    Ok(Trial::new(
        scene_of("pixels", faces),
        TEXELS_PER_SIDE,
        TrialTruth::Direct,
    ))
}
