//! Faces that are close to each other, small, thin, or seen at a grazing angle. All are lit by one
//! lamp directly: the truth is Lambert's, exactly.

use super::shapes::{floor, lamp, lamp_above, scene, square};
use crate::stress::trial::{Case, Trial, Truth};
use crate::stress::{About, RELATIVE};
use common::Result;
use common::scene::Face;

/// A side has so many texels.
const TEXELS: u32 = 8;

const LAMBERT: &str = "Lambert's factor, exact, mean over each texel";

/// The cases.
pub const CASES: &[Case] = &[
    Case {
        about: about("closeness", "gap / size", "a point that stands for an area"),
        values: &[1.0, 0.1, 0.01, 1e-3, 1e-4, 1e-5],
        build: |gap| {
            lit(vec![
                floor(0.0, [1.0; 2], 0.5),
                lamp_above([0.5, 0.5, gap], [1.0; 2], 1.0),
            ])
        },
    },
    Case {
        about: about(
            "shared-edge",
            "angle between the faces, degrees",
            "form factors from centres, where faces touch along an edge",
        ),
        values: &[135.0, 90.0, 30.0, 10.0, 3.0, 1.0, 0.3],
        build: |degrees| {
            let (s, c) = degrees.to_radians().sin_cos();
            let leaf = lamp([0.0; 3], [0.0, 1.0, 0.0], [c, 0.0, s], 1.0);
            lit(vec![floor(0.0, [1.0; 2], 0.5), leaf])
        },
    },
    Case {
        about: about(
            "grazing",
            "height of the lamp / distance",
            "cosines that nearly vanish; light along the rim of an item buffer",
        ),
        values: &[1.0, 0.1, 0.01, 1e-3, 1e-4, 1e-5],
        build: |height| {
            let low = lamp([0.0; 3], [0.0, 1.0, 0.0], [0.0, 0.0, height], 1.0);
            let far = square([1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], 0.5);
            lit(vec![far, low])
        },
    },
];

const fn about(name: &'static str, parameter: &'static str, breaks: &'static str) -> About {
    About {
        name,
        parameter,
        breaks,
        truth: LAMBERT,
        measure: RELATIVE,
    }
}

fn lit(faces: Vec<Face>) -> Result<Trial> {
    Ok(Trial::new(scene("contact", faces), TEXELS, Truth::Direct))
}
