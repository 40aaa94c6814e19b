//! Cases of units and position, which must not affect a solution.

use super::rms_case;
use super::shapes::{box_faces, move_scene, plate_at, scene_of};
use crate::studies::stress::trial::{Case, Trial, TrialTruth};
use common::Result;
use common::scene::Scene;
use glam::{DVec3, Vec3};

const PLAIN_TRUTH: &str =
    "the matrix solver for the scene in plain units at the origin, on texels twice as fine, averaged";

/// The cases of this file.
pub const SPACE_CASES: &[Case] = &[
    rms_case(
        ["units", "units a side of the room"],
        "thresholds that depend on the unit of length",
        PLAIN_TRUTH,
        &[1.0, 1e3, 1e-3, 1e6, 1e-6],
        |unit| plain_trial(move_scene(plain_room(), |p| p * unit)),
    ),
    rms_case(
        ["translation", "distance from the origin / size"],
        "coordinates that lose their digits far from the origin",
        PLAIN_TRUTH,
        &[0.0, 1e3, 1e4, 1e5, 1e6, 1e7],
        |distance| {
            plain_trial(move_scene(plain_room(), |p| {
                p + DVec3::new(0.6, -0.64, 0.48) * distance
            }))
        },
    ),
];

/// Makes a room under an emitting ceiling with a plate in it. Some walls are black, since each
/// shooting face costs an item buffer per patch and sample.
fn plain_room() -> Scene {
    let mut faces = box_faces([0.0; 3], [1.0; 3], true, 0.0);
    faces[1].emission = Vec3::ONE;
    faces[0].reflectance = Vec3::splat(0.6);
    faces[2].reflectance = Vec3::splat(0.6);
    faces.push(plate_at([0.47, 0.54, 0.37], [0.4; 2], 0.6));
    scene_of("room", faces)
}

fn plain_trial(scene: Scene) -> Result<Trial> {
    Ok(Trial::new(scene, 6, TrialTruth::Alike(plain_room(), 2)))
}
