//! Cases of faces that are close to each other, small, thin, far, or seen at a grazing angle. All are
//! lit directly by one lamp.

use super::shapes::{floor_square, grey_square, lamp_above, scene_of, square_lamp, unit_floor};
use super::{LAMBERT_TRUTH, rms_case};
use crate::studies::stress::trial::{Case, Trial, TrialTruth};
use common::Result;
use common::scene::Face;

const TEXELS_PER_SIDE: u32 = 8;

/// The cases of this file.
pub const CONTACT_CASES: &[Case] = &[
    rms_case(
        ["closeness", "gap / size"],
        "one point that stands for an area",
        LAMBERT_TRUTH,
        &[1.0, 0.1, 0.01, 1e-3, 1e-4, 1e-5],
        |gap| direct_trial(vec![unit_floor(), lamp_above([0.5, 0.5, gap], [1.0; 2], 1.0)]),
    ),
    rms_case(
        ["shared-edge", "angle between the faces, degrees"],
        "form factors where faces touch along an edge",
        LAMBERT_TRUTH,
        &[135.0, 90.0, 30.0, 10.0, 3.0, 1.0, 0.3],
        |degrees| {
            let (s, c) = degrees.to_radians().sin_cos();
            direct_trial(vec![
                unit_floor(),
                square_lamp([0.0; 3], [0.0, 1.0, 0.0], [c, 0.0, s], 1.0),
            ])
        },
    ),
    rms_case(
        ["grazing", "height of the lamp / distance"],
        "cosines that nearly vanish",
        LAMBERT_TRUTH,
        &[1.0, 0.1, 0.01, 1e-3, 1e-4, 1e-5],
        |height| {
            let low = square_lamp([0.0; 3], [0.0, 1.0, 0.0], [0.0, 0.0, height], 1.0);
            let far = grey_square([1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], 0.5);
            direct_trial(vec![far, low])
        },
    ),
    rms_case(
        ["sliver-shooter", "length / width of the lamp"],
        "a disc, or a few points, in place of a long thin shooter",
        LAMBERT_TRUTH,
        &[1.0, 10.0, 100.0, 1e3, 1e4, 1e6],
        |aspect| {
            direct_trial(vec![
                unit_floor(),
                lamp_above([0.5, 0.5, 0.5], [1.0, 1.0 / aspect], 1.0),
            ])
        },
    ),
    rms_case(
        ["sliver-receiver", "length / width of the receiver"],
        "texels that are long and thin",
        LAMBERT_TRUTH,
        &[1.0, 10.0, 100.0, 1e3, 1e4, 1e6],
        |aspect| {
            let strip = floor_square(0.0, [1.0, 1.0 / aspect], 0.5);
            direct_trial(vec![strip, lamp_above([0.5, 0.5, 0.5], [1.0; 2], 1.0)])
        },
    ),
    rms_case(
        ["small-shooter", "side of the lamp / side of the floor"],
        "a shooter smaller than a texel, close to it",
        LAMBERT_TRUTH,
        &[0.3, 0.1, 0.01, 1e-3, 1e-4, 1e-5],
        |side| direct_trial(vec![unit_floor(), lamp_above([0.53, 0.46, 0.1], [side; 2], 1.0)]),
    ),
    rms_case(
        ["large-texel", "height of the lamp / side of the floor"],
        "texels larger than the shooter's distance",
        LAMBERT_TRUTH,
        &[1.0, 0.1, 0.03, 0.01, 1e-3, 1e-4],
        |height| direct_trial(vec![unit_floor(), lamp_above([0.53, 0.46, height], [0.1; 2], 1.0)]),
    ),
    rms_case(
        ["remote", "distance / size"],
        "coordinates of which distance takes the digits",
        LAMBERT_TRUTH,
        &[1.0, 10.0, 100.0, 1e3, 1e4, 1e5],
        |distance| direct_trial(vec![unit_floor(), lamp_above([0.5, 0.5, distance], [1.0; 2], 1.0)]),
    ),
];

fn direct_trial(faces: Vec<Face>) -> Result<Trial> {
    Ok(Trial::new(
        scene_of("contact", faces),
        TEXELS_PER_SIDE,
        TrialTruth::Direct,
    ))
}
