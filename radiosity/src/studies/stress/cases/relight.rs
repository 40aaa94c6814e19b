//! Cases of objects put into a room that was captured without them.

use super::shapes::{box_faces, grey_square, plate_at, scene_of};
use super::{FINER_TRUTH, rms_case};
use crate::studies::stress::trial::{Case, Trial, TrialTruth};
use common::Result;
use common::scene::Face;
use glam::Vec3;

const TEXELS_PER_SIDE: u32 = 6;

/// Gap up to which the truth is that of a touching block, in sides of the room: there the dense solver
/// errs by several per cent, in the visible shares of texels that are half covered.
const TOUCHING_GAP: f64 = 1e-3;

const TOUCHING_TRUTH: &str =
    "the matrix solver on texels twice as fine, averaged; of the touching object where it is as close as 0.001";

/// The cases of this file.
pub const RELIGHT_CASES: &[Case] = &[
    rms_case(
        ["object-on-floor", "gap below the object / size of the room"],
        "an object that comes to touch the floor",
        TOUCHING_TRUTH,
        &[0.1, 0.01, 1e-3, 1e-5, 0.0],
        block_above_floor,
    ),
    rms_case(
        ["object-sunk", "share of its height below the floor"],
        "an object that is sunk in the floor",
        FINER_TRUTH,
        &[0.01, 0.1, 0.5, 0.9, 0.99],
        |depth| relight_trial(open_room(), block_at(-0.3 * depth, 0.5)),
    ),
    rms_case(
        ["object-in-its-shadow", "side of the table top / side of the room"],
        "an object in the shadow that it throws itself",
        FINER_TRUTH,
        &[0.1, 0.3, 0.5, 0.7, 0.9],
        |side| {
            let top = plate_at([0.5, 0.5, 0.5], [side; 2], 0.5);
            let under = top.reversed();
            relight_trial(open_room(), [vec![top, under], block_at(0.0, 0.5)].concat())
        },
    ),
    rms_case(
        ["object-black", "reflectance of the object"],
        "an object that only takes light away",
        FINER_TRUTH,
        &[0.1, 0.01, 1e-3, 1e-4, 0.0],
        |reflectance| relight_trial(open_room(), block_at(0.1, reflectance as f32)),
    ),
    rms_case(
        ["object-white", "reflectance of the object"],
        "an object that keeps no light",
        FINER_TRUTH,
        &[0.9, 0.99, 0.999, 0.9999, 0.99999],
        |reflectance| relight_trial(open_room(), block_at(0.1, reflectance as f32)),
    ),
    rms_case(
        ["object-at-window", "side of the object / side of the window"],
        "an object that is larger than the window before which it stands",
        FINER_TRUTH,
        &[0.3, 0.6, 1.0, 2.0, 3.0],
        |ratio| {
            let mut room = open_room();
            room[1].emission = Vec3::ZERO;
            let mut window = grey_square([0.99, 0.35, 0.35], [0.0, 0.0, 0.3], [0.0, 0.3, 0.0], 0.5);
            (window.emission, window.reflectance) = (Vec3::splat(10.0), Vec3::ZERO);
            room.push(window);
            let half = 0.15 * ratio;
            let (low, high) = ([0.8, 0.5 - half, 0.5 - half], [0.85, 0.5 + half, 0.5 + half]);
            relight_trial(room, box_faces(low, high, false, 0.5))
        },
    ),
];

/// Makes a floor, a wall and an emitting ceiling, which take half the time of a closed room.
fn open_room() -> Vec<Face> {
    let mut faces = box_faces([0.0; 3], [1.0; 3], true, 0.5);
    faces[1].emission = Vec3::ONE;
    faces[1].reflectance = Vec3::ZERO;
    let back = faces.remove(5);
    faces.truncate(2);
    faces.push(back);
    faces
}

/// Builds the trial of a block at a gap above the floor.
fn block_above_floor(gap: f64) -> Result<Trial> {
    let trial = relight_trial(open_room(), block_at(gap, 0.5))?;
    if gap > TOUCHING_GAP {
        return Ok(trial);
    }
    let touching = scene_of("touching", [open_room(), block_at(0.0, 0.5)].concat());
    Ok(Trial {
        truth: TrialTruth::Alike(touching, 2),
        ..trial
    })
}

/// Makes a block of side 0.3 whose bottom is at `height`.
fn block_at(height: f64, reflectance: f32) -> Vec<Face> {
    box_faces([0.31, 0.37, height], [0.61, 0.67, height + 0.3], false, reflectance)
}

fn relight_trial(room: Vec<Face>, object: Vec<Face>) -> Result<Trial> {
    let first = room.len();
    let all = scene_of("relight", [room, object].concat());
    Ok(Trial::new(all, TEXELS_PER_SIDE, TrialTruth::Matrix(2)).into_relight(first))
}
