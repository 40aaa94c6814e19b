//! Light itself: reflectance near one, emission over decades, many shots, equal shooters, many lamps.

use super::shapes::{cuboid, lamp_above, moved, scene, unit};
use super::{FURNACE, LAMBERT, case};
use crate::study::stress::trial::{Case, Trial, Truth};
use common::Result;
use common::scene::Face;
use glam::{DVec3, Vec3};

/// The cases.
pub const CASES: &[Case] = &[
    case(
        ["white-walls", "reflectance"],
        "errors of closure that grow with every bounce",
        FURNACE,
        &[0.9, 0.99, 0.999, 0.9999, 0.99999],
        |reflectance| {
            Ok(furnace(1, reflectance as f32, 6).only(&[
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
    case(
        ["power", "emitted radiosity, W/m²"],
        "thresholds that depend on the unit of power",
        LAMBERT,
        &[1.0, 1e3, 1e-3, 1e6, 1e-6],
        |power| {
            let lamp = lamp_above([0.5, 0.5, 1.0], [1.0; 2], power as f32);
            lit(vec![unit(), lamp], 8)
        },
    ),
    case(
        ["faint-lamp", "power / power of the other lamp"],
        "a faint lamp beside a bright one",
        LAMBERT,
        &[1.0, 1e-3, 1e-6, 1e-9, 1e-12],
        |ratio| {
            let pair = |x: f64, power: f64| {
                let faces = vec![unit(), lamp_above([0.5, 0.5, 1.0], [1.0; 2], power as f32)];
                moved(scene("pair", faces), |p| p + DVec3::X * x).faces
            };
            lit([pair(0.0, 1.0), pair(10.0, ratio)].concat(), 8)
        },
    ),
    case(
        ["many-shots", "reflectance"],
        "sums in single precision over up to 1e5 shots",
        FURNACE,
        &[0.5, 0.9, 0.99, 0.999, 0.9996],
        |reflectance| {
            let methods: &[&str] = &["default", "polygon", "conserved", "southwell", "matrix"];
            Ok(furnace(1, reflectance as f32, 4).only(methods))
        },
    ),
    case(
        ["ties", "faces a wall, all alike, by side"],
        "shooters of equal power: the choice hangs on rounding",
        FURNACE,
        &[1.0, 2.0, 3.0, 4.0, 5.0],
        |side| {
            Ok(furnace(side as usize, 0.5, 1).only(&[
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
    case(
        ["lights", "lamps"],
        "very many lamps",
        LAMBERT,
        &[1.0, 10.0, 100.0, 300.0, 1000.0],
        |count| {
            let side = count.sqrt().ceil();
            let lamp = |k: usize| {
                let (i, j) = ((k as f64 % side).floor(), (k as f64 / side).floor());
                let centre = [(i + 0.5) / side, (j + 0.5) / side, 0.5];
                lamp_above(centre, [0.3 / side; 2], 1.0)
            };
            let mut faces = pieces(&unit(), 6);
            faces.extend((0..count as usize).map(lamp));
            Ok(lit(faces, 1)?.only(&["default", "fine", "polygon", "matrix"]))
        },
    ),
];

fn lit(faces: Vec<Face>, texels: u32) -> Result<Trial> {
    Ok(Trial::new(scene("light", faces), texels, Truth::Direct))
}

/// A unit cube whose walls, n×n faces each, all emit 1 and reflect alike.
fn furnace(n: usize, reflectance: f32, texels: u32) -> Trial {
    let walls = cuboid([0.0; 3], [1.0; 3], true, reflectance);
    let mut faces: Vec<Face> = walls.iter().flat_map(|wall| pieces(wall, n)).collect();
    for face in &mut faces {
        face.emission = Vec3::ONE;
    }
    // B − E = ρE/(1 − ρ), with ρ as the solvers have it.
    let rho = f64::from(reflectance);
    let truth = Truth::Constant(DVec3::splat(rho / (1.0 - rho)));
    Trial::new(scene("furnace", faces), texels, truth)
}

/// A face in n×n pieces.
fn pieces(face: &Face, n: usize) -> Vec<Face> {
    let at = |i: usize, j: usize| face.point(i as f64 / n as f64, j as f64 / n as f64);
    let piece = |k: usize| {
        let (i, j) = (k % n, k / n);
        Face {
            corners: [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)],
            ..face.clone()
        }
    };
    (0..n * n).map(piece).collect()
}
