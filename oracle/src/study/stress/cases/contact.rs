//! Faces that are close to each other, small, thin, far, or seen at a grazing angle. All are lit by
//! one lamp directly.

use super::shapes::{floor, lamp, lamp_above, scene, square, unit};
use super::{LAMBERT, case};
use crate::study::stress::trial::{Case, Trial, Truth};
use common::Result;
use common::scene::Face;

const TEXELS: u32 = 8;

/// The cases.
pub const CASES: &[Case] = &[
    case(
        ["closeness", "gap / size"],
        "one point that stands for an area",
        LAMBERT,
        &[1.0, 0.1, 0.01, 1e-3, 1e-4, 1e-5],
        |gap| lit(vec![unit(), lamp_above([0.5, 0.5, gap], [1.0; 2], 1.0)]),
    ),
    case(
        ["shared-edge", "angle between the faces, degrees"],
        "form factors where faces touch along an edge",
        LAMBERT,
        &[135.0, 90.0, 30.0, 10.0, 3.0, 1.0, 0.3],
        |degrees| {
            let (s, c) = degrees.to_radians().sin_cos();
            lit(vec![
                unit(),
                lamp([0.0; 3], [0.0, 1.0, 0.0], [c, 0.0, s], 1.0),
            ])
        },
    ),
    case(
        ["grazing", "height of the lamp / distance"],
        "cosines that nearly vanish",
        LAMBERT,
        &[1.0, 0.1, 0.01, 1e-3, 1e-4, 1e-5],
        |height| {
            let low = lamp([0.0; 3], [0.0, 1.0, 0.0], [0.0, 0.0, height], 1.0);
            let far = square([1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], 0.5);
            lit(vec![far, low])
        },
    ),
    case(
        ["sliver-shooter", "length / width of the lamp"],
        "a disc, or a few points, in place of a long thin shooter",
        LAMBERT,
        &[1.0, 10.0, 100.0, 1e3, 1e4, 1e6],
        |aspect| {
            lit(vec![
                unit(),
                lamp_above([0.5, 0.5, 0.5], [1.0, 1.0 / aspect], 1.0),
            ])
        },
    ),
    case(
        ["sliver-receiver", "length / width of the receiver"],
        "texels that are long and thin",
        LAMBERT,
        &[1.0, 10.0, 100.0, 1e3, 1e4, 1e6],
        |aspect| {
            let strip = floor(0.0, [1.0, 1.0 / aspect], 0.5);
            lit(vec![strip, lamp_above([0.5, 0.5, 0.5], [1.0; 2], 1.0)])
        },
    ),
    case(
        ["small-shooter", "side of the lamp / side of the floor"],
        "a shooter smaller than a texel, close to it",
        LAMBERT,
        &[0.3, 0.1, 0.01, 1e-3, 1e-4, 1e-5],
        |side| lit(vec![unit(), lamp_above([0.53, 0.46, 0.1], [side; 2], 1.0)]),
    ),
    case(
        ["large-texel", "height of the lamp / side of the floor"],
        "texels larger than the shooter's distance",
        LAMBERT,
        &[1.0, 0.1, 0.03, 0.01, 1e-3, 1e-4],
        |height| {
            lit(vec![
                unit(),
                lamp_above([0.53, 0.46, height], [0.1; 2], 1.0),
            ])
        },
    ),
    case(
        ["remote", "distance / size"],
        "coordinates of which distance takes the digits",
        LAMBERT,
        &[1.0, 10.0, 100.0, 1e3, 1e4, 1e5],
        |distance| {
            lit(vec![
                unit(),
                lamp_above([0.5, 0.5, distance], [1.0; 2], 1.0),
            ])
        },
    ),
];

fn lit(faces: Vec<Face>) -> Result<Trial> {
    Ok(Trial::new(scene("contact", faces), TEXELS, Truth::Direct))
}
