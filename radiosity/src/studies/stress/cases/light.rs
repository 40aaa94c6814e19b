//! Cases of the light itself: reflectance near one, emission over decades, many shots, equal shooters,
//! many lamps.

use super::shapes::{box_faces, lamp_above, move_scene, scene_of, unit_floor};
use super::{FURNACE_TRUTH, LAMBERT_TRUTH, rms_case};
use crate::studies::stress::trial::{Case, Trial, TrialTruth};
use common::Result;
use common::scene::Face;
use glam::{DVec3, Vec3};

/// The cases of this file.
pub const LIGHT_CASES: &[Case] = &[
    rms_case(
        ["white-walls", "reflectance"],
        "errors of closure that grow with every bounce",
        FURNACE_TRUTH,
        &[0.9, 0.99, 0.999, 0.9999, 0.99999],
        |reflectance| {
            Ok(furnace_trial(1, reflectance as f32, 6).with_methods(&[
                "default",
                "fine",
                "polygon",
                "conserved",
                "disc",
                "stereographic",
                "hemicube",
                "matrix",
            ]))
        },
    ),
    rms_case(
        ["power", "emitted radiosity, W/m²"],
        "thresholds that depend on the unit of power",
        LAMBERT_TRUTH,
        &[1.0, 1e3, 1e-3, 1e6, 1e-6],
        |power| {
            let lamp = lamp_above([0.5, 0.5, 1.0], [1.0; 2], power as f32);
            direct_trial(vec![unit_floor(), lamp], 8)
        },
    ),
    rms_case(
        ["faint-lamp", "power / power of the other lamp"],
        "a faint lamp beside a bright one",
        LAMBERT_TRUTH,
        &[1.0, 1e-3, 1e-6, 1e-9, 1e-12],
        |ratio| {
            let pair = |x: f64, power: f64| {
                let faces = vec![unit_floor(), lamp_above([0.5, 0.5, 1.0], [1.0; 2], power as f32)];
                move_scene(scene_of("pair", faces), |p| p + DVec3::X * x).faces
            };
            direct_trial([pair(0.0, 1.0), pair(10.0, ratio)].concat(), 8)
        },
    ),
    rms_case(
        ["many-shots", "reflectance"],
        "sums in single precision over up to 1e5 shots",
        FURNACE_TRUTH,
        &[0.5, 0.9, 0.99, 0.999, 0.9996],
        |reflectance| {
            let methods: &[&str] = &["default", "polygon", "conserved", "southwell", "matrix"];
            Ok(furnace_trial(1, reflectance as f32, 4).with_methods(methods))
        },
    ),
    rms_case(
        ["ties", "faces a wall, all alike, by side"],
        "shooters of equal power: the choice hangs on rounding",
        FURNACE_TRUTH,
        &[1.0, 2.0, 3.0, 4.0, 5.0],
        |side| {
            Ok(furnace_trial(side as usize, 0.5, 1).with_methods(&[
                "default",
                "fine",
                "polygon",
                "southwell",
                "disc",
                "stereographic",
                "matrix",
            ]))
        },
    ),
    rms_case(
        ["lights", "lamps"],
        "very many lamps",
        LAMBERT_TRUTH,
        &[1.0, 10.0, 100.0, 300.0, 1000.0],
        |count| {
            let side = count.sqrt().ceil();
            let lamp = |k: usize| {
                let (i, j) = ((k as f64 % side).floor(), (k as f64 / side).floor());
                let centre = [(i + 0.5) / side, (j + 0.5) / side, 0.5];
                lamp_above(centre, [0.3 / side; 2], 1.0)
            };
            let mut faces = cut_face(&unit_floor(), 6);
            faces.extend((0..count as usize).map(lamp));
            Ok(direct_trial(faces, 1)?.with_methods(&["default", "fine", "polygon", "matrix"]))
        },
    ),
];

fn direct_trial(faces: Vec<Face>, texels: u32) -> Result<Trial> {
    Ok(Trial::new(scene_of("light", faces), texels, TrialTruth::Direct))
}

/// Builds a unit cube whose walls, n×n faces each, all emit 1 and have one reflectance.
fn furnace_trial(n: usize, reflectance: f32, texels: u32) -> Trial {
    let walls = box_faces([0.0; 3], [1.0; 3], true, reflectance);
    let mut faces: Vec<Face> = walls.iter().flat_map(|wall| cut_face(wall, n)).collect();
    for face in &mut faces {
        face.emission = Vec3::ONE;
    }
    // B − E = ρE/(1 − ρ), with ρ rounded to f32 as in the solvers.
    let rho = f64::from(reflectance);
    let truth = TrialTruth::Constant(DVec3::splat(rho / (1.0 - rho)));
    Trial::new(scene_of("furnace", faces), texels, truth)
}

/// Cuts a face into n×n pieces.
fn cut_face(face: &Face, n: usize) -> Vec<Face> {
    let at = |i: usize, j: usize| face.point_at(i as f64 / n as f64, j as f64 / n as f64);
    let piece = |k: usize| {
        let (i, j) = (k % n, k / n);
        Face {
            corners: [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)],
            ..face.clone()
        }
    };
    (0..n * n).map(piece).collect()
}
