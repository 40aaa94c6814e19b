//! Walls of two sides around a room are lit as walls of one side are, on every solver.

use super::sky::{ERROR, mean_irradiance, mean_irradiance_by_rays, solve_by_all};
use common::scene::{Face, Scene};
use glam::{DVec3, Vec3};
use radiosity_tests::{box_faces, named_scene};

/// A closed room whose lamp shines down and shows its back to the ceiling: of what the ceiling sees, only that back is no
/// front.
fn room_with_hanging_lamp() -> Scene {
    let mut faces = box_faces(DVec3::ZERO, DVec3::splat(2.0), true, Vec3::ZERO, Vec3::splat(0.7));
    let corner = |x: f64, y: f64| DVec3::new(x, y, 1.8);
    let corners = [corner(0.7, 0.7), corner(0.7, 1.3), corner(1.3, 1.3), corner(1.3, 0.7)];
    faces.push(Face::quad("lamp", corners, Vec3::splat(10.0), Vec3::ZERO));
    named_scene("hanging lamp", faces)
}

/// Returns the outer side of a wall, cut into two triangles.
fn halve_outer_side(wall: &Face) -> [Face; 2] {
    let [a, b, c, d] = wall.reversed().corners;
    [[a, b, c], [a, c, d]].map(|corners| Face::triangle("outside", corners, Vec3::ZERO, wall.reflectance))
}

#[test]
fn back_of_a_lamp_darkens_no_two_sided_wall() {
    let thin = room_with_hanging_lamp();
    let mut walled = thin.clone();
    walled.faces.extend(thin.faces[..6].iter().map(Face::reversed));
    let mut cut = thin.clone();
    cut.faces.extend(thin.faces[..6].iter().flat_map(halve_outer_side));
    let by_rays = |scene: &Scene| [0, 1].map(|face| mean_irradiance_by_rays(scene, face));
    let of_solvers = |scene: &Scene| {
        let solved = solve_by_all(scene).into_iter();
        solved.map(|(name, solved)| (name, [0, 1].map(|face| mean_irradiance(&solved, face))))
    };
    let found = |scene: &Scene| of_solvers(scene).chain([("rays", by_rays(scene))]).collect::<Vec<_>>();
    let both = found(&walled).into_iter().zip(found(&cut));
    for ((name, expected), (walled, cut)) in found(&thin).into_iter().zip(both) {
        // Floor and ceiling; each answer is within the requested error of the light.
        let [floor, ceiling] = expected;
        assert!(ceiling > 0.3 * floor, "{name}: {expected:?}");
        for found in [walled.1, cut.1] {
            let off = [0, 1].map(|k| (found[k] - expected[k]).abs() / floor);
            assert!(
                off.iter().all(|off| *off < 2.0 * ERROR),
                "{name}: {found:?} instead of {expected:?}"
            );
        }
    }
}
