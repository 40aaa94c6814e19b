//! Random scenes: a room, turned at random, with floating boxes in it; closed or with walls missing.

use crate::{room, scene};
use common::form_factor::FormFactor;
use common::mesh::Mesh;
use common::scene::{Face, Scene, Shape};
use glam::{DMat3, DQuat, DVec3, Vec3};
use proptest::prelude::*;

/// A scene, its texels and the settings that differ from case to case.
#[derive(Clone, Debug)]
pub struct Sample {
    /// The faces.
    pub scene: Scene,
    /// Texels of each face.
    pub resolutions: Vec<[u32; 2]>,
    /// Cells a side.
    pub cells: u32,
    /// Form factor.
    pub form_factor: FormFactor,
}

impl Sample {
    /// Its mesh.
    pub fn mesh(&self) -> Mesh {
        Mesh::new(&self.scene, &self.resolutions, self.cells).unwrap()
    }
}

/// What a face looks like.
#[derive(Clone, Copy, Debug)]
struct Look {
    reflectance: Vec3,
    emission: Vec3,
    texels: [u32; 2],
    /// Two triangles instead of a quad.
    split: bool,
}

fn look() -> impl Strategy<Value = Look> {
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
        .prop_map(|(reflectance, emission, texels, split)| Look {
            reflectance,
            emission,
            texels,
            split,
        })
}

fn turn() -> impl Strategy<Value = DMat3> {
    prop::array::uniform4(-1.0f64..1.0)
        .prop_filter("has a direction", |q| {
            q.iter().map(|x| x * x).sum::<f64>() > 0.01
        })
        .prop_map(|q| DMat3::from_quat(DQuat::from_array(q).normalize()))
}

/// A box that stays in |x| ≤ 1 however it is turned.
#[derive(Clone, Debug)]
struct Body {
    half: DVec3,
    turn: DMat3,
}

fn body() -> impl Strategy<Value = Body> {
    let side = prop::array::uniform3(0.05f64..0.57);
    (side, turn()).prop_map(|(half, turn)| Body {
        half: half.into(),
        turn,
    })
}

fn moved(faces: Vec<Face>, move_point: &dyn Fn(DVec3) -> DVec3) -> Vec<Face> {
    faces
        .into_iter()
        .map(|face| Face {
            corners: face.corners.map(move_point),
            ..face
        })
        .collect()
}

/// A room whose walls are missing where `missing` says so, with up to `most` boxes.
fn sample(missing: impl Strategy<Value = [bool; 6]>, most: usize) -> impl Strategy<Value = Sample> {
    let kind = prop_oneof![
        Just(FormFactor::Paper),
        Just(FormFactor::Disc),
        Just(FormFactor::Polygon)
    ];
    (
        (prop::array::uniform3(0.5f64..3.0), turn(), missing),
        prop::collection::vec(body(), 0..=most),
        prop::collection::vec(look(), 18),
        (1u32..=4, kind),
    )
        .prop_map(
            |((size, turn, missing), bodies, looks, (cells, form_factor))| {
                let size = DVec3::from(size);
                let walls = room(DVec3::ZERO, size, true, Vec3::ZERO, Vec3::ZERO);
                let mut faces: Vec<Face> = walls
                    .into_iter()
                    .zip(missing)
                    .filter_map(|(face, missing)| (!missing).then_some(face))
                    .collect();
                // Each body floats in its own half: a closed body that stood on a wall would swallow
                // what the wall emits beneath it.
                for (k, body) in bodies.iter().enumerate() {
                    let centre = size * DVec3::new(0.25 + 0.5 * k as f64, 0.5, 0.5);
                    let reach = (size * DVec3::new(0.24, 0.48, 0.48)).min_element();
                    let place = |p: DVec3| centre + body.turn * p * reach;
                    faces.extend(moved(
                        room(-body.half, body.half, false, Vec3::ZERO, Vec3::ZERO),
                        &place,
                    ));
                }
                assemble(moved(faces, &|p| turn * p), &looks, cells, form_factor)
            },
        )
}

fn assemble(faces: Vec<Face>, looks: &[Look], cells: u32, form_factor: FormFactor) -> Sample {
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
            resolutions.push(if piece.shape == Shape::Triangle {
                [w, w]
            } else {
                [w, h]
            });
            done.push(piece);
        }
    }
    Sample {
        scene: scene("random", done),
        resolutions,
        cells,
        form_factor,
    }
}

/// A closed room.
pub fn closed() -> impl Strategy<Value = Sample> {
    sample(Just([false; 6]), 2)
}

/// A closed room with nothing in it: each point of its surface sees all of the others.
pub fn empty() -> impl Strategy<Value = Sample> {
    sample(Just([false; 6]), 0)
}

/// A room without one to five of its walls.
pub fn open() -> impl Strategy<Value = Sample> {
    sample(
        any::<[bool; 6]>().prop_filter("some are missing, some are not", |m| {
            m.contains(&true) && m.contains(&false)
        }),
        2,
    )
}
