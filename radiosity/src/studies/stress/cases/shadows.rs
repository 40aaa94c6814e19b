//! Cases of shadows: a slit, blinds and gratings, stacked plates, a body on the lamp. Everything but
//! the receiver is black, so the truth is exact.

use super::shapes::{box_faces, floor_square, lamp_above, plate_at, scene_of, square_lamp, unit_floor};
use super::{SHADOW_TRUTH, rms_case};
use crate::studies::stress::trial::{Case, Trial, TrialTruth};
use common::Result;
use common::scene::Face;

const TEXELS_PER_SIDE: u32 = 8;

/// The cases of this file.
pub const SHADOW_CASES: &[Case] = &[
    rms_case(
        ["slit", "width / side of the screen"],
        "light through an opening thinner than samples and pixels",
        SHADOW_TRUTH,
        &[0.3, 0.1, 0.03, 0.01, 1e-3, 1e-4],
        |width| shadowed_trial(slit_faces(width)),
    ),
    rms_case(
        ["blinds", "slats"],
        "slats finer than samples and pixels, under a wide lamp",
        SHADOW_TRUTH,
        &[2.0, 4.0, 8.0, 16.0, 32.0],
        |count| shadowed_trial(blind_faces(count)),
    ),
    rms_case(
        ["grating", "pitch / height"],
        "slats at and below the size of a pixel, in an opening",
        SHADOW_TRUTH,
        &[0.1, 0.03, 0.01, 3e-3, 1e-3, 1e-4],
        |pitch| {
            let mut faces = slit_faces(8.0 * pitch);
            for k in 0..8 {
                let x = 0.5 + pitch * (f64::from(k) - 3.6);
                faces.push(plate_at([x, 0.5, 0.5], [pitch / 2.0, 2.0], 0.0));
            }
            shadowed_trial(faces)
        },
    ),
    rms_case(
        ["plates", "gap between the plates / size"],
        "plates stacked close: light comes in at the edges only",
        SHADOW_TRUTH,
        &[1.0, 0.3, 0.1, 0.03, 0.01, 1e-3, 1e-4],
        |gap| {
            let mut faces = vec![
                floor_square(-4.0 * gap, [1.0; 2], 0.5),
                lamp_above([0.5, 0.5, 0.5], [0.5; 2], 1.0),
            ];
            for k in 0..4 {
                let side = 0.23 + 0.2 * f64::from(k);
                faces.push(plate_at([0.5, 0.5, -gap * f64::from(k)], [side; 2], 0.5));
            }
            shadowed_trial(faces)
        },
    ),
    rms_case(
        ["covered-lamp", "open share of the lamp"],
        "a body on the shooter's centre, from which all its light leaves",
        SHADOW_TRUTH,
        &[0.99, 0.9, 0.5, 0.1, 0.01],
        |open| {
            let side = (1.0f64 - open).sqrt();
            let (low, high) = (0.5 - side / 2.0, 0.5 + side / 2.0);
            let ceiling = floor_square(1.0, [1.0; 2], 0.5).reversed();
            let below = square_lamp([0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], 1.0);
            let body = box_faces([low, low, 0.0], [high, high, 0.3], false, 0.0);
            shadowed_trial([vec![ceiling, below], body].concat())
        },
    ),
];

/// Makes a floor, a lamp above it, and between them two plates that leave `width` open.
fn slit_faces(width: f64) -> Vec<Face> {
    let half = |x: f64| plate_at([x, 0.5, 0.5], [1.0, 2.0], 0.0);
    let lamp = lamp_above([0.5, 0.5, 1.0], [1.0; 2], 1.0);
    vec![unit_floor(), lamp, half(-width / 2.0), half(1.0 + width / 2.0)]
}

/// Makes a floor, a lamp above it, and between them slats that cover half of the width.
fn blind_faces(count: f64) -> Vec<Face> {
    let mut faces = vec![unit_floor(), lamp_above([0.5, 0.5, 1.0], [1.0; 2], 1.0)];
    let pitch = 2.0 / count;
    for k in 0..count as usize {
        let x = -0.5 + pitch * (k as f64 + 0.37);
        faces.push(plate_at([x, 0.5, 0.5], [pitch / 2.0, 2.0], 0.0));
    }
    faces
}

/// Makes a trial in which all faces from the third on may occlude the lamp.
fn shadowed_trial(faces: Vec<Face>) -> Result<Trial> {
    let truth = TrialTruth::Shadowed((2..faces.len()).collect());
    Ok(Trial::new(scene_of("shadows", faces), TEXELS_PER_SIDE, truth))
}
