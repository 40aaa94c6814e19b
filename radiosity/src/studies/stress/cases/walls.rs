//! Cases of two rooms: light through a door, and none through a wall or the seams of a box.

use super::shapes::{box_faces, grey_square, lamp_above, scene_of, tilt_scene, wall_strips};
use super::{SHADOW_TRUTH, rms_case};
use crate::studies::stress::trial::{BuildTrial, Case, Trial, TrialTruth};
use crate::studies::stress::{CaseInfo, LEAK_MEASURE};
use common::Result;
use common::scene::Face;
use glam::Vec3;

/// The cases of this file.
pub const WALL_CASES: &[Case] = &[
    rms_case(
        ["door", "width of the door / width of the rooms"],
        "a room that is lit through a small opening only",
        SHADOW_TRUTH,
        &[0.9, 0.3, 0.1, 0.03, 0.01, 1e-3, 1e-4],
        door_trial,
    ),
    leak_case(
        ["wall", "thickness / size"],
        "a wall between a lit room and a dark one",
        &[0.1, 0.01, 1e-3, 1e-4, 1e-5, 1e-6, 0.0],
        |thickness| {
            let mut lit = box_faces([0.0; 3], [1.0; 3], true, 0.0);
            lit[1].emission = Vec3::ONE;
            lit[3].reflectance = Vec3::splat(0.7);
            let unlit = box_faces([1.0 + thickness, 0.0, 0.0], [2.0 + thickness, 1.0, 1.0], true, 0.9);
            let both = tilt_scene(scene_of("wall", [lit, unlit].concat()));
            Ok(Trial::new(both, 6, TrialTruth::Dark).with_judged(6..12))
        },
    ),
    leak_case(
        ["cracks", "strips of a wall"],
        "the seams of a closed box, lit from outside",
        &[1.0, 2.0, 3.0, 5.0, 9.0, 17.0],
        cracks_trial,
    ),
];

/// Makes a case that is judged by its leak.
const fn leak_case(names: [&'static str; 2], breaks: &'static str, values: &'static [f64], build: BuildTrial) -> Case {
    let case = rms_case(names, breaks, "no light behind a wall", values, build);
    Case {
        info: CaseInfo {
            measure: LEAK_MEASURE,
            ..case.info
        },
        ..case
    }
}

/// Builds two adjacent rooms with a door of full height between them. Only the far wall of the second
/// room reflects, and all its light comes through the door.
fn door_trial(width: f64) -> Result<Trial> {
    let mut first = box_faces([0.0; 3], [1.0; 3], true, 0.0);
    let mut second = box_faces([1.0, 0.0, 0.0], [2.0, 1.0, 1.0], true, 0.0);
    first[2].emission = Vec3::ONE;
    second[3].reflectance = Vec3::splat(0.5);
    let (up, across) = ([0.0, 0.0, 1.0], [0.0, (1.0 - width) / 2.0, 0.0]);
    let side = |y: f64| grey_square([1.0, y, 0.0], up, across, 0.0);
    let halves = [side(0.0), side((1.0 + width) / 2.0)];
    first.remove(3);
    second.remove(2);
    let both: Vec<Face> = halves
        .iter()
        .cloned()
        .chain(halves.iter().map(Face::reversed))
        .collect();
    let both = scene_of("door", [both, first, second].concat());
    Ok(Trial::new(both, 8, TrialTruth::Shadowed(vec![0, 1])))
}

/// Builds a closed box under a lamp, its left wall in strips; the inside is judged.
fn cracks_trial(count: f64) -> Result<Trial> {
    let mut faces = box_faces([0.0; 3], [1.0; 3], true, 0.9);
    let wall = faces.remove(2);
    faces.extend(wall_strips(&wall, count));
    let inside = faces.len();
    faces.push(lamp_above([0.2, 0.4, 2.0], [3.0; 2], 1.0));
    let all = tilt_scene(scene_of("cracks", faces));
    Ok(Trial::new(all, 6, TrialTruth::Dark).with_judged(0..inside))
}
