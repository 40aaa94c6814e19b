//! A lamp in the plane of a ceiling lights the room, wherever it comes in the file, on every solver.

use super::sky::{ERROR, mean_irradiance, mean_irradiance_by_rays, solve_by_all};
use common::scene::{Face, Scene};
use glam::{DVec3, Vec3};
use radiosity_tests::factor_cases::rectangle;
use radiosity_tests::{box_faces, named_scene};

/// Reflectance of the walls.
const WALL_REFLECTANCE: Vec3 = Vec3::splat(0.6);
/// Sides of the lamp along x and z, across texels.
const LAMP_SIDES: [[f64; 2]; 2] = [[0.68, 1.31], [0.55, 1.19]];

/// Excess of the light by shots: texels receive as a whole if only a part of their patch lies under the lamp. Of the room's
/// surface of 24 these are less than the lamp's 0.41, and each bounce of their light, ρ/(1 − ρ) in all, is too much.
const SHOTS_EXCESS: f64 = 0.41 / 24.0 * 0.6 / 0.4;

/// A part of the ceiling of a room two units wide, which faces down.
fn ceiling_part([x, z]: [[f64; 2]; 2], emission: Vec3) -> Face {
    let along = [[x[1] - x[0], 0.0, 0.0], [0.0, 0.0, z[1] - z[0]]];
    let corners = rectangle([x[0], 2.0, z[0]], along[0], along[1]);
    Face::quad("ceiling", corners, emission, WALL_REFLECTANCE)
}

/// Floor and walls of the room; the floor is the first.
fn room_below_ceiling() -> Vec<Face> {
    let mut faces = box_faces(DVec3::ZERO, DVec3::splat(2.0), true, Vec3::ZERO, WALL_REFLECTANCE);
    faces.retain(|face| face.corners.iter().any(|corner| corner.y == 0.0));
    let is_floor = |face: &Face| face.corners.iter().all(|corner| corner.y == 0.0);
    faces.sort_by_key(|face| !is_floor(face));
    faces
}

/// The same room three times: the ceiling around the lamp, a whole ceiling after the lamp, and one before it.
fn draw_rooms() -> [Scene; 3] {
    let lamp = ceiling_part(LAMP_SIDES, Vec3::splat(10.0));
    let [[x0, x1], [z0, z1]] = LAMP_SIDES;
    let around = [
        [[0.0, 2.0], [0.0, z0]],
        [[0.0, 2.0], [z1, 2.0]],
        [[0.0, x0], [z0, z1]],
        [[x1, 2.0], [z0, z1]],
    ];
    let around = around.map(|part| ceiling_part(part, Vec3::ZERO));
    let whole = ceiling_part([[0.0, 2.0]; 2], Vec3::ZERO);
    let room = |name: &str, ceiling: &[Face]| named_scene(name, [&room_below_ceiling(), ceiling].concat());
    [
        room("around", &[&around[..], std::slice::from_ref(&lamp)].concat()),
        room("after", &[lamp.clone(), whole.clone()]),
        room("before", &[whole, lamp]),
    ]
}

/// Returns the irradiance of floor and first wall by each solver.
fn find_irradiance(scene: &Scene) -> Vec<(&'static str, [f64; 2])> {
    let by_rays = [0, 1].map(|face| mean_irradiance_by_rays(scene, face));
    let solved = solve_by_all(scene).into_iter();
    let means = solved.map(|(name, solved)| (name, [0, 1].map(|face| mean_irradiance(&solved, face))));
    means.chain([("rays", by_rays)]).collect()
}

#[test]
fn lamp_in_the_plane_of_a_ceiling_lights_the_room() {
    let [around, after, before] = draw_rooms().map(|scene| find_irradiance(&scene));
    for ((name, expected), (after, before)) in around.into_iter().zip(after.into_iter().zip(before)) {
        assert!(expected.iter().all(|h| *h > 0.1), "{name}: {expected:?}");
        for found in [after.1, before.1] {
            let off = [0, 1].map(|k| (found[k] / expected[k] - 1.0).abs());
            let excess = if name.starts_with("shots") { SHOTS_EXCESS } else { 0.0 };
            assert!(
                off.iter().all(|off| *off < ERROR + excess),
                "{name}: {found:?} instead of {expected:?}"
            );
        }
    }
}
