//! Random rooms for property tests: rotated at random, with floating boxes, closed or with walls missing.

use crate::{box_faces, named_scene};
use common::form_factor::FormFactor;
use common::mesh::Mesh;
use common::scene::{Face, Scene, Shape};
use glam::{DMat3, DQuat, DVec3, Vec3};
use proptest::prelude::*;

/// A scene with its texels, patches and form factor.
#[derive(Clone, Debug)]
pub struct RandomRoom {
    /// Scene.
    pub scene: Scene,
    /// Texels of each face.
    pub resolutions: Vec<[u32; 2]>,
    /// Patches per side.
    pub patches: u32,
    /// Form factor.
    pub form_factor: FormFactor,
}

impl RandomRoom {
    /// Meshes the room.
    pub fn room_mesh(&self) -> Mesh {
        Mesh::new(&self.scene, &self.resolutions, self.patches).unwrap()
    }
}

/// Material and texels of a face.
#[derive(Clone, Copy, Debug)]
struct FaceLook {
    reflectance: Vec3,
    emission: Vec3,
    texels: [u32; 2],
    /// Two triangles instead of a quad.
    split: bool,
}

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
    (
        reflectance,
        emission,
        prop::array::uniform2(1u32..=9),
        prop::bool::weighted(0.3),
    )
        .prop_map(|(reflectance, emission, texels, split)| FaceLook {
            reflectance,
            emission,
            texels,
            split,
        })
}

fn any_rotation() -> impl Strategy<Value = DMat3> {
    prop::array::uniform4(-1.0f64..1.0)
        .prop_filter("has a direction", |q| q.iter().map(|x| x * x).sum::<f64>() > 0.01)
        .prop_map(|q| DMat3::from_quat(DQuat::from_array(q).normalize()))
}

/// A box that stays in |x| ≤ 1 under any rotation.
#[derive(Clone, Debug)]
struct Body {
    half: DVec3,
    turn: DMat3,
}

fn any_body() -> impl Strategy<Value = Body> {
    let side = prop::array::uniform3(0.05f64..0.57);
    (side, any_rotation()).prop_map(|(half, turn)| Body {
        half: half.into(),
        turn,
    })
}

fn move_faces(faces: Vec<Face>, move_point: &dyn Fn(DVec3) -> DVec3) -> Vec<Face> {
    faces
        .into_iter()
        .map(|face| Face {
            corners: face.corners.map(move_point),
            ..face
        })
        .collect()
}

/// Draws a room without its walls in `missing`, with up to `most` boxes.
fn any_room(missing: impl Strategy<Value = [bool; 6]>, most: usize) -> impl Strategy<Value = RandomRoom> {
    let kind = prop_oneof![
        Just(FormFactor::Paper),
        Just(FormFactor::Disc),
        Just(FormFactor::Polygon)
    ];
    (
        (prop::array::uniform3(0.5f64..3.0), any_rotation(), missing),
        prop::collection::vec(any_body(), 0..=most),
        prop::collection::vec(any_look(), 18),
        (1u32..=4, kind),
    )
        .prop_map(|((size, turn, missing), bodies, looks, (patches, form_factor))| {
            let size = DVec3::from(size);
            let walls = box_faces(DVec3::ZERO, size, true, Vec3::ZERO, Vec3::ZERO);
            let mut faces: Vec<Face> = walls
                .into_iter()
                .zip(missing)
                .filter_map(|(face, missing)| (!missing).then_some(face))
                .collect();
            // Each box floats in its own half: one that stood on a wall would absorb the light emitted under it.
            for (k, body) in bodies.iter().enumerate() {
                let centre = size * DVec3::new(0.25 + 0.5 * k as f64, 0.5, 0.5);
                let reach = (size * DVec3::new(0.24, 0.48, 0.48)).min_element();
                let place = |p: DVec3| centre + body.turn * p * reach;
                faces.extend(move_faces(
                    box_faces(-body.half, body.half, false, Vec3::ZERO, Vec3::ZERO),
                    &place,
                ));
            }
            assemble_room(move_faces(faces, &|p| turn * p), &looks, patches, form_factor)
        })
}

fn assemble_room(faces: Vec<Face>, looks: &[FaceLook], patches: u32, form_factor: FormFactor) -> RandomRoom {
    let (mut done, mut resolutions) = (Vec::new(), Vec::new());
    for (face, look) in faces.into_iter().zip(looks) {
        let face = Face {
            emission: look.emission,
            reflectance: look.reflectance,
            ..face
        };
        let [a, b, c, d] = face.corners;
        let pieces = if look.split {
            let half = |c| Face::triangle(&face.name, c, face.emission, face.reflectance);
            vec![half([a, b, c]), half([a, c, d])]
        } else {
            vec![face]
        };
        for piece in pieces {
            let [w, h] = look.texels;
            resolutions.push(if piece.shape == Shape::Triangle { [w, w] } else { [w, h] });
            done.push(piece);
        }
    }
    RandomRoom {
        scene: named_scene("random", done),
        resolutions,
        patches,
        form_factor,
    }
}

/// Draws a closed room.
pub fn closed_room() -> impl Strategy<Value = RandomRoom> {
    any_room(Just([false; 6]), 2)
}

/// Draws a closed room without boxes: all points of its surface see each other.
pub fn empty_room() -> impl Strategy<Value = RandomRoom> {
    any_room(Just([false; 6]), 0)
}

/// Draws a room without one to five of its walls.
pub fn open_room() -> impl Strategy<Value = RandomRoom> {
    any_room(
        any::<[bool; 6]>().prop_filter("some are missing, some are not", |m| {
            m.contains(&true) && m.contains(&false)
        }),
        2,
    )
}
