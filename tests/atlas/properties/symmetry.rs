//! Invariance of links under similarity transforms, reflection, the order of faces and corners, and splitting of
//! faces.

use super::equivalence::assert_same_links;
use super::pairing::Pairing;
use super::scenes::{any_scene, convex_room, furnished_room, rotate_corners};
use super::setups::{SolverSetup, check_every_engine};
use common::mesh::Mesh;
use glam::DVec3;
use proptest::prelude::*;
use radiosity_tests::engines::all_patches;
use radiosity_tests::random_rooms::{RandomRoom, any_rotation};

/// A similarity transform: rotation, scaling, and a shift by a few times the scene's size.
#[test]
fn similarity_transform_keeps_links() {
    let motion = (any_rotation(), prop::array::uniform3(-9.0f64..9.0), -2.0f64..2.0);
    check_every_engine(3, &(furnished_room(), motion), |way, (cut, (turn, shift, power))| {
        let scale = 10f64.powf(power);
        let to = |p: DVec3| (turn * p + DVec3::from(shift)) * scale;
        let [a, b] = [cut.clone(), cut.map_corners(to)].map(|cut| cut.sampled_mesh(way.samples));
        assert_same_links(way, &a, &b, &Pairing::new(&a, &b, to))
    });
}

/// Returns the room for a setup. Renumbering of texels and patches moves sample points: with several samples only rooms
/// without occluders are equal up to rounding.
fn scene_for_setup(way: SolverSetup, convex: RandomRoom, furnished: RandomRoom) -> RandomRoom {
    if way.samples > 1 { convex } else { furnished }
}

/// Returns the mirror image, with fronts on the same side.
fn mirror_scene(cut: &RandomRoom, normal: DVec3) -> (RandomRoom, impl Fn(DVec3) -> DVec3 + use<>) {
    let to = move |p: DVec3| p - 2.0 * normal * normal.dot(p);
    let mut image = cut.map_corners(to);
    for (face, resolution) in image.scene.faces.iter_mut().zip(&mut image.resolutions) {
        *face = face.reversed();
        resolution.reverse();
    }
    (image, to)
}

fn any_axis() -> impl Strategy<Value = DVec3> {
    any_rotation().prop_map(|turn| turn.x_axis)
}

#[test]
fn mirrored_scene_has_mirrored_links() {
    check_every_engine(
        6,
        &(convex_room(), furnished_room(), any_axis()),
        |way, (empty, full, axis)| {
            let cut = scene_for_setup(way, empty, full);
            let (image, to) = mirror_scene(&cut, axis);
            let [a, b] = [&cut, &image].map(|cut| cut.sampled_mesh(way.samples));
            assert_same_links(way, &a, &b, &Pairing::new(&a, &b, to))
        },
    );
}

/// Returns the scene with its faces in another order.
fn reorder_faces(cut: &RandomRoom, order: &[usize]) -> RandomRoom {
    let mut other = cut.clone();
    other.scene.faces = order.iter().map(|k| cut.scene.faces[*k].clone()).collect();
    other.resolutions = order.iter().map(|k| cut.resolutions[*k]).collect();
    other
}

/// Returns a permutation of `count` indices from random keys.
fn order(count: usize, keys: &[u32]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..count).collect();
    order.sort_by_key(|k| (keys[k % keys.len()].rotate_left((k / keys.len()) as u32), *k));
    order
}

fn random_keys() -> impl Strategy<Value = Vec<u32>> {
    prop::collection::vec(any::<u32>(), 64)
}

/// With one sample links do not depend on the numbering, and the same shots add the same to each texel.
#[test]
fn order_of_faces_keeps_every_bit() {
    check_every_engine(
        4,
        &(any_scene(), convex_room(), random_keys()),
        |way, (full, empty, keys)| {
            let cut = scene_for_setup(way, empty, full);
            let order = order(cut.scene.faces.len(), &keys);
            let [a, b] = [cut.clone(), reorder_faces(&cut, &order)].map(|cut| cut.sampled_mesh(way.samples));
            // A texel keeps its index in its face. A search by place could confuse bodies that touch.
            let mut places = vec![0; order.len()];
            order.iter().enumerate().for_each(|(k, face)| places[*face] = k as u32);
            let number = |mesh: &Mesh, face: u32, index: u32| {
                mesh.texels.iter().position(|t| t.face == face && t.index == index)
            };
            let texels: Vec<usize> = (a.texels.iter())
                .filter_map(|t| number(&b, places[t.face as usize], t.index))
                .collect();
            let patch_of = |texel: usize| b.patches.iter().position(|c| c.texels().contains(&texel));
            let log = all_patches(&a);
            let other: Vec<u32> = (a.patches.iter())
                .filter_map(|patch| patch_of(texels[patch.first as usize]).map(|k| k as u32))
                .collect();
            let [a, b] = [(&a, log), (&b, other)].map(|(mesh, log)| way.replay_log(mesh, &log).field);
            for (k, j) in texels.iter().enumerate() {
                prop_assert_eq!(a.radiosity[k], b.radiosity[*j], "texel {}", k);
                prop_assert_eq!(a.irradiance[k].truncate(), b.irradiance[*j].truncate());
            }
            Ok(())
        },
    );
}

/// Rotates the first corner of all faces.
fn rotate_first_corners(cut: &RandomRoom, by: &[u32]) -> RandomRoom {
    let mut other = cut.clone();
    let faces = other.scene.faces.iter_mut().zip(&mut other.resolutions);
    for ((face, resolution), by) in faces.zip(by.iter().cycle()) {
        (*face, *resolution) = rotate_corners(face, *resolution, *by as usize % 12);
    }
    other
}

/// The patches of a triangle depend on its first corner: only those that both have are compared.
#[test]
fn order_of_faces_and_corners_changes_only_rounding() {
    check_every_engine(
        6,
        &(convex_room(), furnished_room(), random_keys()),
        |way, (empty, full, keys)| {
            let cut = scene_for_setup(way, empty, full);
            let other = reorder_faces(&rotate_first_corners(&cut, &keys), &order(cut.scene.faces.len(), &keys));
            let [a, b] = [&cut, &other].map(|cut| cut.sampled_mesh(way.samples));
            assert_same_links(way, &a, &b, &Pairing::new(&a, &b, |p| p))
        },
    );
}

/// Returns a scene with a face of 2×N texels, and with it split into two of 1×N; a triangle of 2² texels into four of one.
fn split_face(cut: &RandomRoom, at: usize) -> [RandomRoom; 2] {
    let mut one = cut.clone();
    let at = at % cut.scene.faces.len();
    let face = &cut.scene.faces[at];
    let [a, b, c, d] = face.corners;
    let middle = |p: DVec3, q: DVec3| 0.5 * (p + q);
    let quad = face.outline().len() == 4;
    one.resolutions[at][0] = 2;
    if !quad {
        one.resolutions[at] = [2, 2];
    }
    let height = one.resolutions[at][1];
    let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
    let (parts, resolution) = if quad {
        let cd = middle(c, d);
        (vec![[a, ab, cd, d], [ab, b, c, cd]], [1, height])
    } else {
        let parts = [[a, ab, ca], [ab, b, bc], [ab, bc, ca], [ca, bc, c]];
        (parts.map(|[a, b, c]| [a, b, c, c]).to_vec(), [1, 1])
    };
    let mut parts = parts.into_iter().map(|corners| common::scene::Face {
        corners,
        ..face.clone()
    });
    let mut many = one.clone();
    many.scene.faces[at] = parts.next().unwrap();
    many.resolutions[at] = resolution;
    for part in parts {
        many.scene.faces.push(part);
        many.resolutions.push(resolution);
    }
    [one, many]
}

#[test]
fn split_face_keeps_links() {
    check_every_engine(
        6,
        &(convex_room(), furnished_room(), any::<usize>()),
        |way, (empty, full, at)| {
            let cut = scene_for_setup(way, empty, full);
            let [a, b] = split_face(&cut, at).map(|cut| cut.sampled_mesh(way.samples));
            assert_same_links(way, &a, &b, &Pairing::new(&a, &b, |p| p))
        },
    );
}
