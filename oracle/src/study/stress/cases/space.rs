//! Where a scene lies and in which unit it is measured must not matter.

use super::case;
use super::shapes::{cuboid, moved, plate, scene};
use crate::study::stress::trial::{Case, Trial, Truth};
use common::Result;
use common::scene::Scene;
use glam::{DVec3, Vec3};

const PLAIN: &str = "the matrix solver for the scene in plain units at the origin, on texels twice as fine, averaged";

/// The cases.
pub const CASES: &[Case] = &[
    case(
        ["units", "units a side of the room"],
        "thresholds that depend on the unit of length",
        PLAIN,
        &[1.0, 1e3, 1e-3, 1e6, 1e-6],
        |unit| as_plain(moved(room(), |p| p * unit)),
    ),
    case(
        ["translation", "distance from the origin / size"],
        "coordinates that lose their digits far from the origin",
        PLAIN,
        &[0.0, 1e3, 1e4, 1e5, 1e6, 1e7],
        |distance| {
            as_plain(moved(room(), |p| {
                p + DVec3::new(0.6, -0.64, 0.48) * distance
            }))
        },
    ),
];

/// A room under a shining ceiling with a plate in it. Black walls: each face that shoots costs an item
/// buffer a cell and sample.
fn room() -> Scene {
    let mut faces = cuboid([0.0; 3], [1.0; 3], true, 0.0);
    faces[1].emission = Vec3::ONE;
    faces[0].reflectance = Vec3::splat(0.6);
    faces[2].reflectance = Vec3::splat(0.6);
    faces.push(plate([0.47, 0.54, 0.37], [0.4; 2], 0.6));
    scene("room", faces)
}

fn as_plain(scene: Scene) -> Result<Trial> {
    Ok(Trial::new(scene, 6, Truth::Alike(room(), 2)))
}
