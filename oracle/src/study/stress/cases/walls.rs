//! Two rooms: light through a door, and none through a wall or the cracks of a box.

use super::shapes::{cuboid, lamp_above, scene, square, tilted};
use super::{SHADOWS, case};
use crate::study::stress::trial::{Build, Case, Trial, Truth};
use crate::study::stress::{About, LEAK};
use common::Result;
use common::scene::Face;
use glam::Vec3;

/// The cases.
pub const CASES: &[Case] = &[
    case(
        ["door", "width of the door / width of the rooms"],
        "a room that is lit through a small opening only",
        SHADOWS,
        &[0.9, 0.3, 0.1, 0.03, 0.01, 1e-3, 1e-4],
        door,
    ),
    dark(
        ["wall", "thickness / size"],
        "a wall between a lit room and a dark one",
        &[0.1, 0.01, 1e-3, 1e-4, 1e-5, 1e-6, 0.0],
        |thickness| {
            let mut lit = cuboid([0.0; 3], [1.0; 3], true, 0.0);
            lit[1].emission = Vec3::ONE;
            lit[3].reflectance = Vec3::splat(0.7);
            let unlit = cuboid(
                [1.0 + thickness, 0.0, 0.0],
                [2.0 + thickness, 1.0, 1.0],
                true,
                0.9,
            );
            let both = tilted(scene("wall", [lit, unlit].concat()));
            Ok(Trial::new(both, 6, Truth::Dark).judging(6..12))
        },
    ),
    dark(
        ["cracks", "strips of a wall"],
        "the seams of a closed box, lit from outside",
        &[1.0, 2.0, 3.0, 5.0, 9.0, 17.0],
        cracks,
    ),
];

/// One judged by the light that is where none may be.
const fn dark(
    names: [&'static str; 2],
    breaks: &'static str,
    values: &'static [f64],
    build: Build,
) -> Case {
    let case = case(names, breaks, "no light behind a wall", values, build);
    Case {
        about: About {
            measure: LEAK,
            ..case.about
        },
        ..case
    }
}

/// Two rooms side by side, and a door as high as they are in the middle of the wall between them. Only
/// the far wall of the second one reflects: what comes through the door is all the light there is.
fn door(width: f64) -> Result<Trial> {
    let mut first = cuboid([0.0; 3], [1.0; 3], true, 0.0);
    let mut second = cuboid([1.0, 0.0, 0.0], [2.0, 1.0, 1.0], true, 0.0);
    first[2].emission = Vec3::ONE;
    second[3].reflectance = Vec3::splat(0.5);
    let (up, across) = ([0.0, 0.0, 1.0], [0.0, (1.0 - width) / 2.0, 0.0]);
    let side = |y: f64| square([1.0, y, 0.0], up, across, 0.0);
    let halves = [side(0.0), side((1.0 + width) / 2.0)];
    first.remove(3);
    second.remove(2);
    let both: Vec<Face> = halves
        .iter()
        .cloned()
        .chain(halves.iter().map(Face::reversed))
        .collect();
    let both = scene("door", [both, first, second].concat());
    Ok(Trial::new(both, 8, Truth::Shadowed(vec![0, 1])))
}

/// A closed box, its left wall in strips, under a lamp; what is inside is judged.
fn cracks(count: f64) -> Result<Trial> {
    let mut faces = cuboid([0.0; 3], [1.0; 3], true, 0.9);
    let wall = faces.remove(2);
    let strip = |k: usize| {
        let at = |i: f64, v: f64| wall.point(i / count, v);
        let (low, high) = (k as f64, k as f64 + 1.0);
        Face {
            corners: [at(low, 0.0), at(high, 0.0), at(high, 1.0), at(low, 1.0)],
            ..wall.clone()
        }
    };
    faces.extend((0..count as usize).map(strip));
    let inside = faces.len();
    faces.push(lamp_above([0.2, 0.4, 2.0], [3.0; 2], 1.0));
    let all = tilted(scene("cracks", faces));
    Ok(Trial::new(all, 6, Truth::Dark).judging(0..inside))
}
