//! Invariance of links under similarity transforms, reflection, the order of faces and corners, and splitting of
//! faces.

use super::equivalence::assert_same_links;
use super::scenes::any_scene;
use super::setups::{SolverSetup, allow_dark, check_every_engine};
use glam::DVec3;
use properties::strategies::{any_axis, any_similarity, convex_room, furnished_room, random_keys};
use properties::{MeshedScene, check_face_order, order_by_keys};
use proptest::prelude::*;

#[test]
fn similarity_transform_keeps_links() {
    check_every_engine(
        3,
        &(furnished_room(), any_similarity()),
        |setup, (scene, (matrix, shift))| {
            let to = |p: DVec3| matrix * p + shift;
            assert_same_links(setup, [&scene, &scene.map_corners(to)], to)
        },
    );
}

/// Returns the room for a setup. Renumbering of texels and patches moves sample points: with several samples only rooms
/// without occluders are equal up to rounding.
fn scene_for_setup(setup: SolverSetup, convex: MeshedScene, furnished: MeshedScene) -> MeshedScene {
    if setup.samples > 1 { convex } else { furnished }
}

#[test]
fn mirrored_scene_has_mirrored_links() {
    check_every_engine(
        6,
        &(convex_room(), furnished_room(), any_axis()),
        |setup, (empty, full, axis)| {
            let scene = scene_for_setup(setup, empty, full);
            let (image, to) = scene.mirror(axis);
            assert_same_links(setup, [&scene, &image], to)
        },
    );
}

/// With one sample links do not depend on the numbering, and the same shots add the same to each texel.
#[test]
fn order_of_faces_keeps_every_bit() {
    check_every_engine(
        4,
        &(any_scene(), convex_room(), random_keys()),
        |setup, (full, empty, keys)| {
            let scene = scene_for_setup(setup, empty, full);
            let order = order_by_keys(scene.scene.faces.len(), &keys);
            check_face_order(&|_, mesh| setup.shoot_rounds(mesh, 1).radiosity, &scene, &order, 0.0)?;
            allow_dark(check_face_order(
                &|_, mesh| setup.shoot_rounds(mesh, 1).irradiance,
                &scene,
                &order,
                0.0,
            ))?;
            Ok(())
        },
    );
}

/// The patches of a triangle depend on its first corner: only those that both have are compared.
#[test]
fn order_of_faces_and_corners_changes_only_rounding() {
    check_every_engine(
        6,
        &(convex_room(), furnished_room(), random_keys()),
        |setup, (empty, full, keys)| {
            let scene = scene_for_setup(setup, empty, full);
            let order = order_by_keys(scene.scene.faces.len(), &keys);
            let other = scene.rotate_first_corners(&keys).reorder_faces(&order);
            assert_same_links(setup, [&scene, &other], |p| p)
        },
    );
}

#[test]
fn split_face_keeps_links() {
    check_every_engine(
        6,
        &(convex_room(), furnished_room(), any::<usize>()),
        |setup, (empty, full, at)| {
            let scene = scene_for_setup(setup, empty, full);
            let [one, many] = scene.split_face(at);
            assert_same_links(setup, [&one, &many], |p| p)
        },
    );
}
