//! Strategies of `proptest` for scenes: rooms rotated at random, with floating boxes, closed or with walls missing. Some
//! face of each emits light, over six decades and in each channel by itself.

use crate::faces::{box_faces, named_scene};
use crate::scene::MeshedScene;
use common::scene::Face;
use glam::{DMat3, DQuat, DVec3, Vec3};
use proptest::prelude::*;

/// Emission of a face where no face of a room emits light, W/m².
const LAMP_EMISSION: Vec3 = Vec3::new(1.0, 2.0, 0.5);
/// Largest reflectance of [`convex_room`] and [`furnished_room`]: an error of a form factor grows fivefold.
const MAX_LIMITED_REFLECTANCE: f32 = 0.8;

/// Reflectance, emission and texels of a face, and true if two triangles take its place.
type FaceLook = (Vec3, Vec3, [u32; 2], bool);

fn any_look() -> impl Strategy<Value = FaceLook> {
    let reflectance = prop_oneof![
        1 => Just(Vec3::ZERO),
        3 => prop::array::uniform3(0.0f32..0.95).prop_map(Vec3::from),
    ];
    // Six decades; most faces are dark.
    let emission = prop_oneof![
        2 => Just(Vec3::ZERO),
        1 => prop::array::uniform3(-3.0f32..3.0).prop_map(|e| Vec3::from(e.map(|e| 10f32.powf(e)))),
    ];
    let texels = prop::array::uniform2(1u32..=9);
    (reflectance, emission, texels, prop::bool::weighted(0.3))
}

fn add_face(room: &mut MeshedScene, corners: [DVec3; 4], (reflectance, emission, [w, h], split): FaceLook) {
    let [a, b, c, d] = corners;
    let triangle = |corners| (Face::triangle("triangle", corners, emission, reflectance), [w, w]);
    let pieces = if split {
        vec![triangle([a, b, c]), triangle([a, c, d])]
    } else {
        vec![(Face::quad("quad", corners, emission, reflectance), [w, h])]
    };
    for (face, resolution) in pieces {
        room.scene.faces.push(face);
        room.resolutions.push(resolution);
    }
}

fn light_dark_room(mut room: MeshedScene) -> MeshedScene {
    if room.scene.faces.iter().all(|face| face.emission == Vec3::ZERO) {
        room.scene.faces[0].emission = LAMP_EMISSION;
    }
    room
}

/// Draws a room without its walls in `missing`, with up to `most` boxes.
fn any_room(missing: impl Strategy<Value = [bool; 6]>, most: usize) -> impl Strategy<Value = MeshedScene> {
    // Half of a box's sides: it stays in |x| ≤ 1 under any rotation.
    let body = (prop::array::uniform3(0.05f64..0.57), any_rotation());
    (
        (prop::array::uniform3(0.5f64..3.0), any_rotation(), missing),
        prop::collection::vec(body, 0..=most),
        prop::collection::vec(any_look(), 18),
        1u32..=4,
    )
        .prop_map(|((size, turn, missing), bodies, looks, patches)| {
            let size = DVec3::from(size);
            let mut faces = box_faces(DVec3::ZERO, size, true, Vec3::ZERO, Vec3::ZERO);
            let mut missing = missing.into_iter();
            faces.retain(|_| missing.next() == Some(false));
            // Each box floats in its own half: one that stood on a wall would absorb the light emitted under it.
            for (k, (half, body_turn)) in bodies.into_iter().enumerate() {
                let centre = size * DVec3::new(0.25 + 0.5 * k as f64, 0.5, 0.5);
                let reach = (size * DVec3::new(0.24, 0.48, 0.48)).min_element();
                let half = DVec3::from(half);
                for mut face in box_faces(-half, half, false, Vec3::ZERO, Vec3::ZERO) {
                    face.corners = face.corners.map(|p| centre + body_turn * p * reach);
                    faces.push(face);
                }
            }
            let mut room = MeshedScene {
                scene: named_scene("random", Vec::new()),
                resolutions: Vec::new(),
                patches,
            };
            for (face, look) in faces.into_iter().zip(looks) {
                add_face(&mut room, face.corners.map(|p| turn * p), look);
            }
            light_dark_room(room)
        })
}

/// Draws a closed room with up to two boxes, 1 to 9 texels and 1 to 4 patches per side, and reflectances up to 0.95.
pub fn closed_room() -> impl Strategy<Value = MeshedScene> {
    any_room(Just([false; 6]), 2)
}

/// Draws a closed room without boxes: all points of its surface see each other.
pub fn empty_room() -> impl Strategy<Value = MeshedScene> {
    any_room(Just([false; 6]), 0)
}

/// Draws a room without one to five of its walls.
pub fn open_room() -> impl Strategy<Value = MeshedScene> {
    any_room(
        any::<[bool; 6]>().prop_filter("some are missing, some are not", |m| {
            m.contains(&true) && m.contains(&false)
        }),
        2,
    )
}

/// Sets sides of 2 or 4 texels, 2×2 patches, and reflectances of at most [`MAX_LIMITED_REFLECTANCE`].
fn limit_room(mut room: MeshedScene) -> MeshedScene {
    for (face, sides) in room.scene.faces.iter_mut().zip(&mut room.resolutions) {
        face.reflectance = face.reflectance.min(Vec3::splat(MAX_LIMITED_REFLECTANCE));
        *sides = sides.map(|side| if side > 4 { 4 } else { 2 });
    }
    MeshedScene { patches: 2, ..room }
}

/// Draws a closed room without objects, sheared so that hardly two of its walls are at right angles; walls are
/// parallelograms, or two triangles each, with sides of 2 or 4 texels. Reflectances are 0.8 at most.
pub fn convex_room() -> impl Strategy<Value = MeshedScene> {
    (empty_room(), prop::array::uniform3(-0.4f64..0.4)).prop_map(|(room, [a, b, c])| {
        let shear = DMat3::from_cols(DVec3::X, DVec3::new(a, 1.0, 0.0), DVec3::new(b, c, 1.0));
        limit_room(room).map_corners(|p| shear * p)
    })
}

/// Draws a room with floating boxes; closed, or without some of its walls. Sides have 2 or 4 texels, and reflectances are
/// 0.8 at most.
pub fn furnished_room() -> impl Strategy<Value = MeshedScene> {
    prop_oneof![closed_room().prop_map(limit_room), open_room().prop_map(limit_room),]
}

/// Draws a rotation.
pub fn any_rotation() -> impl Strategy<Value = DMat3> {
    prop::array::uniform4(-1.0f64..1.0)
        .prop_filter("has a direction", |q| q.iter().map(|x| x * x).sum::<f64>() > 0.01)
        .prop_map(|q| DMat3::from_quat(DQuat::from_array(q).normalize()))
}

/// Draws a unit vector.
pub fn any_axis() -> impl Strategy<Value = DVec3> {
    any_rotation().prop_map(|turn| turn.x_axis)
}

/// Draws the matrix and the shift of a similarity transform p → M·p + shift: a rotation, a scale of 0.01 to 100, and a
/// shift by a few times the scene's size.
pub fn any_similarity() -> impl Strategy<Value = (DMat3, DVec3)> {
    (any_rotation(), prop::array::uniform3(-9.0f64..9.0), -2.0f64..2.0).prop_map(|(turn, shift, power)| {
        let scale = 10f64.powf(power);
        (turn * scale, DVec3::from(shift) * scale)
    })
}

/// Draws keys of an order of faces or corners (see [`crate::order_by_keys`]).
pub fn random_keys() -> impl Strategy<Value = Vec<u32>> {
    prop::collection::vec(any::<u32>(), 64)
}
