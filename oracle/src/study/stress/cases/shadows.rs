//! Shadows: a slit, blinds and gratings, plates on plates, a body on the lamp. Everything but the
//! receiver is black, so the truth is exact.

use super::shapes::{cuboid, floor, lamp, lamp_above, plate, scene, unit};
use super::{SHADOWS, case};
use crate::study::stress::trial::{Case, Trial, Truth};
use common::Result;
use common::scene::Face;

const TEXELS: u32 = 8;

/// The cases.
pub const CASES: &[Case] = &[
    case(
        ["slit", "width / side of the screen"],
        "light through an opening thinner than samples and pixels",
        SHADOWS,
        &[0.3, 0.1, 0.03, 0.01, 1e-3, 1e-4],
        |width| shaded(opening(width)),
    ),
    case(
        ["blinds", "slats"],
        "slats finer than samples and pixels, under a wide lamp",
        SHADOWS,
        &[2.0, 4.0, 8.0, 16.0, 32.0],
        |count| shaded(blinds(count)),
    ),
    case(
        ["grating", "pitch / height"],
        "slats at and below the size of a pixel, in an opening",
        SHADOWS,
        &[0.1, 0.03, 0.01, 3e-3, 1e-3, 1e-4],
        |pitch| {
            let mut faces = opening(8.0 * pitch);
            for k in 0..8 {
                let x = 0.5 + pitch * (f64::from(k) - 3.6);
                faces.push(plate([x, 0.5, 0.5], [pitch / 2.0, 2.0], 0.0));
            }
            shaded(faces)
        },
    ),
    case(
        ["plates", "gap between the plates / size"],
        "plates stacked close: light comes in at the edges only",
        SHADOWS,
        &[1.0, 0.3, 0.1, 0.03, 0.01, 1e-3, 1e-4],
        |gap| {
            let mut faces = vec![
                floor(-4.0 * gap, [1.0; 2], 0.5),
                lamp_above([0.5, 0.5, 0.5], [0.5; 2], 1.0),
            ];
            for k in 0..4 {
                let side = 0.23 + 0.2 * f64::from(k);
                faces.push(plate([0.5, 0.5, -gap * f64::from(k)], [side; 2], 0.5));
            }
            shaded(faces)
        },
    ),
    case(
        ["covered-lamp", "open share of the lamp"],
        "a body on the shooter's centre, from which all its light leaves",
        SHADOWS,
        &[0.99, 0.9, 0.5, 0.1, 0.01],
        |open| {
            let side = (1.0f64 - open).sqrt();
            let (low, high) = (0.5 - side / 2.0, 0.5 + side / 2.0);
            let ceiling = floor(1.0, [1.0; 2], 0.5).reversed();
            let below = lamp([0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], 1.0);
            let body = cuboid([low, low, 0.0], [high, high, 0.3], false, 0.0);
            shaded([vec![ceiling, below], body].concat())
        },
    ),
];

/// A floor, a lamp above it, and between them two plates that leave `width` open.
fn opening(width: f64) -> Vec<Face> {
    let half = |x: f64| plate([x, 0.5, 0.5], [1.0, 2.0], 0.0);
    let lamp = lamp_above([0.5, 0.5, 1.0], [1.0; 2], 1.0);
    vec![unit(), lamp, half(-width / 2.0), half(1.0 + width / 2.0)]
}

/// A floor, a lamp above it, and slats that cover every second part of the way.
fn blinds(count: f64) -> Vec<Face> {
    let mut faces = vec![unit(), lamp_above([0.5, 0.5, 1.0], [1.0; 2], 1.0)];
    let pitch = 2.0 / count;
    for k in 0..count as usize {
        let x = -0.5 + pitch * (k as f64 + 0.37);
        faces.push(plate([x, 0.5, 0.5], [pitch / 2.0, 2.0], 0.0));
    }
    faces
}

/// Everything from the third face on may hide the second from the others.
fn shaded(faces: Vec<Face>) -> Result<Trial> {
    let truth = Truth::Shadowed((2..faces.len()).collect());
    Ok(Trial::new(scene("shadows", faces), TEXELS, truth))
}
