//! Random rooms for property tests: rotated at random, with floating boxes, closed or with walls missing.

use crate::{box_faces, named_scene};
use common::cover;
use common::form_factor::FormFactor;
use common::mesh::Mesh;
use common::scene::{Face, Scene};
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

    /// Meshes the room with `samples` points per patch.
    pub fn sampled_mesh(&self, samples: u32) -> Mesh {
        let mut mesh = self.room_mesh();
        cover::sample_covers(&mut mesh, samples);
        mesh
    }

    /// Maps all corners by `to`.
    pub fn map_corners(&self, to: impl Fn(DVec3) -> DVec3) -> Self {
        let mut room = self.clone();
        for face in &mut room.scene.faces {
            face.corners = face.corners.map(&to);
        }
        room
    }

    fn add_face(&mut self, corners: [DVec3; 4], (reflectance, emission, [w, h], split): FaceLook) {
        let [a, b, c, d] = corners;
        let triangle = |corners| (Face::triangle("triangle", corners, emission, reflectance), [w, w]);
        let pieces = if split {
            vec![triangle([a, b, c]), triangle([a, c, d])]
        } else {
            vec![(Face::quad("quad", corners, emission, reflectance), [w, h])]
        };
        for (face, resolution) in pieces {
            self.scene.faces.push(face);
            self.resolutions.push(resolution);
        }
    }
}

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

/// Draws a rotation.
pub fn any_rotation() -> impl Strategy<Value = DMat3> {
    prop::array::uniform4(-1.0f64..1.0)
        .prop_filter("has a direction", |q| q.iter().map(|x| x * x).sum::<f64>() > 0.01)
        .prop_map(|q| DMat3::from_quat(DQuat::from_array(q).normalize()))
}

/// Draws a room without its walls in `missing`, with up to `most` boxes.
fn any_room(missing: impl Strategy<Value = [bool; 6]>, most: usize) -> impl Strategy<Value = RandomRoom> {
    let kind = prop::sample::select(&[FormFactor::Paper, FormFactor::Disc, FormFactor::Polygon][..]);
    // Half of a box's sides: it stays in |x| ≤ 1 under any rotation.
    let body = (prop::array::uniform3(0.05f64..0.57), any_rotation());
    (
        (prop::array::uniform3(0.5f64..3.0), any_rotation(), missing),
        prop::collection::vec(body, 0..=most),
        prop::collection::vec(any_look(), 18),
        (1u32..=4, kind),
    )
        .prop_map(|((size, turn, missing), bodies, looks, (patches, form_factor))| {
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
            let mut room = RandomRoom {
                scene: named_scene("random", Vec::new()),
                resolutions: Vec::new(),
                patches,
                form_factor,
            };
            for (face, look) in faces.into_iter().zip(looks) {
                room.add_face(face.corners.map(|p| turn * p), look);
            }
            room
        })
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
