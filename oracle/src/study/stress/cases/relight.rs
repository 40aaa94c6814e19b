//! Objects put into a room that was captured without them.

use super::shapes::{cuboid, plate, scene, square};
use super::{FINER, case};
use crate::study::stress::trial::{Case, Trial, Truth};
use common::Result;
use common::scene::Face;
use glam::Vec3;

const TEXELS: u32 = 6;

/// So close to the floor a block is lit as if it touched it; the matrix errs there by several per cent
/// (its visible shares of texels that a near plate half covers).
const CLOSE: f64 = 1e-3;

const TOUCHING: &str = "the matrix solver on texels twice as fine, averaged; of the touching object where it is as close as 0.001";

/// The cases.
pub const CASES: &[Case] = &[
    case(
        ["object-on-floor", "gap below the object / size of the room"],
        "an object that comes to touch the floor",
        TOUCHING,
        &[0.1, 0.01, 1e-3, 1e-5, 0.0],
        above_floor,
    ),
    case(
        ["object-sunk", "share of its height below the floor"],
        "an object that is sunk in the floor",
        FINER,
        &[0.01, 0.1, 0.5, 0.9, 0.99],
        |depth| relit(room(), block(-0.3 * depth, 0.5)),
    ),
    case(
        [
            "object-in-its-shadow",
            "side of the table top / side of the room",
        ],
        "an object in the shadow that it throws itself",
        FINER,
        &[0.1, 0.3, 0.5, 0.7, 0.9],
        |side| {
            let top = plate([0.5, 0.5, 0.5], [side; 2], 0.5);
            let under = top.reversed();
            relit(room(), [vec![top, under], block(0.0, 0.5)].concat())
        },
    ),
    case(
        ["object-black", "reflectance of the object"],
        "an object that only takes light away",
        FINER,
        &[0.1, 0.01, 1e-3, 1e-4, 0.0],
        |reflectance| relit(room(), block(0.1, reflectance as f32)),
    ),
    case(
        ["object-white", "reflectance of the object"],
        "an object that keeps no light",
        FINER,
        &[0.9, 0.99, 0.999, 0.9999, 0.99999],
        |reflectance| relit(room(), block(0.1, reflectance as f32)),
    ),
    case(
        [
            "object-at-window",
            "side of the object / side of the window",
        ],
        "an object that is larger than the window before which it stands",
        FINER,
        &[0.3, 0.6, 1.0, 2.0, 3.0],
        |ratio| {
            let mut room = room();
            room[1].emission = Vec3::ZERO;
            let mut window = square([0.99, 0.35, 0.35], [0.0, 0.0, 0.3], [0.0, 0.3, 0.0], 0.5);
            (window.emission, window.reflectance) = (Vec3::splat(10.0), Vec3::ZERO);
            room.push(window);
            let half = 0.15 * ratio;
            let (low, high) = (
                [0.8, 0.5 - half, 0.5 - half],
                [0.85, 0.5 + half, 0.5 + half],
            );
            relit(room, cuboid(low, high, false, 0.5))
        },
    ),
];

/// A floor, a wall and a shining ceiling: two shoot what they reflect, and that takes half the time of
/// a closed room.
fn room() -> Vec<Face> {
    let mut faces = cuboid([0.0; 3], [1.0; 3], true, 0.5);
    faces[1].emission = Vec3::ONE;
    faces[1].reflectance = Vec3::ZERO;
    let back = faces.remove(5);
    faces.truncate(2);
    faces.push(back);
    faces
}

/// A block over the floor.
fn above_floor(gap: f64) -> Result<Trial> {
    let trial = relit(room(), block(gap, 0.5))?;
    if gap > CLOSE {
        return Ok(trial);
    }
    let touching = scene("touching", [room(), block(0.0, 0.5)].concat());
    Ok(Trial {
        truth: Truth::Alike(touching, 2),
        ..trial
    })
}

/// A block of 0.3 that begins at `height`.
fn block(height: f64, reflectance: f32) -> Vec<Face> {
    cuboid(
        [0.31, 0.37, height],
        [0.61, 0.67, height + 0.3],
        false,
        reflectance,
    )
}

fn relit(room: Vec<Face>, object: Vec<Face>) -> Result<Trial> {
    let first = room.len();
    let all = scene("relight", [room, object].concat());
    Ok(Trial::new(all, TEXELS, Truth::Matrix(2)).relit(first))
}
