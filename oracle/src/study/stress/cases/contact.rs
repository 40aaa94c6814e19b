//! Faces that are close to each other, small, thin, far, or seen at a grazing angle. All are lit by
//! one lamp directly.

use super::shapes::{floor, lamp, lamp_above, scene, square};
use super::{LAMBERT, about};
use crate::study::stress::trial::{Case, Trial, Truth};
use common::Result;
use common::scene::Face;

const TEXELS: u32 = 8;

/// The cases.
pub const CASES: &[Case] = &[
    Case {
        about: about(
            ["closeness", "gap / size"],
            "one point that stands for an area",
            LAMBERT,
        ),
        values: &[1.0, 0.1, 0.01, 1e-3, 1e-4, 1e-5],
        build: |gap| lit(vec![unit(), lamp_above([0.5, 0.5, gap], [1.0; 2], 1.0)]),
    },
    Case {
        about: about(
            ["shared-edge", "angle between the faces, degrees"],
            "form factors where faces touch along an edge",
            LAMBERT,
        ),
        values: &[135.0, 90.0, 30.0, 10.0, 3.0, 1.0, 0.3],
        build: |degrees| {
            let (s, c) = degrees.to_radians().sin_cos();
            lit(vec![
                unit(),
                lamp([0.0; 3], [0.0, 1.0, 0.0], [c, 0.0, s], 1.0),
            ])
        },
    },
    Case {
        about: about(
            ["grazing", "height of the lamp / distance"],
            "cosines that nearly vanish",
            LAMBERT,
        ),
        values: &[1.0, 0.1, 0.01, 1e-3, 1e-4, 1e-5],
        build: |height| {
            let low = lamp([0.0; 3], [0.0, 1.0, 0.0], [0.0, 0.0, height], 1.0);
            let far = square([1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], 0.5);
            lit(vec![far, low])
        },
    },
    Case {
        about: about(
            ["sliver-shooter", "length / width of the lamp"],
            "a disc, or a few points, in place of a long thin shooter",
            LAMBERT,
        ),
        values: &[1.0, 10.0, 100.0, 1e3, 1e4, 1e6],
        build: |aspect| {
            lit(vec![
                unit(),
                lamp_above([0.5, 0.5, 0.5], [1.0, 1.0 / aspect], 1.0),
            ])
        },
    },
    Case {
        about: about(
            ["sliver-receiver", "length / width of the receiver"],
            "texels that are long and thin",
            LAMBERT,
        ),
        values: &[1.0, 10.0, 100.0, 1e3, 1e4, 1e6],
        build: |aspect| {
            let strip = floor(0.0, [1.0, 1.0 / aspect], 0.5);
            lit(vec![strip, lamp_above([0.5, 0.5, 0.5], [1.0; 2], 1.0)])
        },
    },
    Case {
        about: about(
            ["small-shooter", "side of the lamp / side of the floor"],
            "a shooter smaller than a texel, close to it",
            LAMBERT,
        ),
        values: &[0.3, 0.1, 0.01, 1e-3, 1e-4, 1e-5],
        build: |side| lit(vec![unit(), lamp_above([0.53, 0.46, 0.1], [side; 2], 1.0)]),
    },
    Case {
        about: about(
            ["large-texel", "height of the lamp / side of the floor"],
            "texels larger than the shooter's distance",
            LAMBERT,
        ),
        values: &[1.0, 0.1, 0.03, 0.01, 1e-3, 1e-4],
        build: |height| {
            lit(vec![
                unit(),
                lamp_above([0.53, 0.46, height], [0.1; 2], 1.0),
            ])
        },
    },
    Case {
        about: about(
            ["remote", "distance / size"],
            "coordinates of which distance takes the digits",
            LAMBERT,
        ),
        values: &[1.0, 10.0, 100.0, 1e3, 1e4, 1e5],
        build: |distance| {
            lit(vec![
                unit(),
                lamp_above([0.5, 0.5, distance], [1.0; 2], 1.0),
            ])
        },
    },
];

fn unit() -> Face {
    floor(0.0, [1.0; 2], 0.5)
}

fn lit(faces: Vec<Face>) -> Result<Trial> {
    Ok(Trial::new(scene("contact", faces), TEXELS, Truth::Direct))
}
