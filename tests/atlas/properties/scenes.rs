//! Random scenes, small enough for hundreds of solves.

use common::form_factor::FormFactor;
use common::scene::Face;
use glam::{DMat3, DVec3, Vec3};
use proptest::prelude::*;
use radiosity_tests::random_rooms::{RandomRoom, closed_room, empty_room, open_room};
use radiosity_tests::solutions::{FACE_SHAPES, drawn_scene};

/// Sets sides of 2 or 4 texels, 2×2 patches, and reflectances of at most 0.8, so that errors are not amplified a
/// hundred times. Some face emits.
fn limit_room(mut room: RandomRoom) -> RandomRoom {
    for (face, sides) in room.scene.faces.iter_mut().zip(&mut room.resolutions) {
        face.reflectance = face.reflectance.min(Vec3::splat(0.8));
        *sides = sides.map(|side| if side > 4 { 4 } else { 2 });
    }
    if room.scene.faces.iter().all(|face| face.emission == Vec3::ZERO) {
        room.scene.faces[0].emission = Vec3::new(1.0, 2.0, 0.5);
    }
    RandomRoom { patches: 2, ..room }
}

/// Draws a closed room without objects, sheared so that hardly two of its walls are at right angles; walls are
/// parallelograms, or two triangles each.
pub fn convex_room() -> impl Strategy<Value = RandomRoom> {
    (empty_room(), prop::array::uniform3(-0.4f64..0.4)).prop_map(|(sample, [a, b, c])| {
        let shear = DMat3::from_cols(DVec3::X, DVec3::new(a, 1.0, 0.0), DVec3::new(b, c, 1.0));
        limit_room(sample).map_corners(|p| shear * p)
    })
}

/// Draws a room with floating boxes; closed, or without some of its walls.
pub fn furnished_room() -> impl Strategy<Value = RandomRoom> {
    prop_oneof![closed_room().prop_map(limit_room), open_room().prop_map(limit_room),]
}

/// Draws any scene of `studies::random`: rooms convex and not, closed and open, with boxes, sheets and lamps, of quads,
/// triangles or both.
pub fn random_scene() -> impl Strategy<Value = RandomRoom> {
    (any::<u64>(), prop::sample::select(&FACE_SHAPES[..])).prop_map(|(seed, faces)| {
        let scene = drawn_scene(seed, faces);
        RandomRoom {
            resolutions: vec![[2, 2]; scene.faces.len()],
            scene,
            patches: 1,
            form_factor: FormFactor::Polygon,
        }
    })
}

/// Draws a furnished room or any random scene.
pub fn any_scene() -> impl Strategy<Value = RandomRoom> {
    prop_oneof![2 => furnished_room(), 1 => random_scene()]
}

/// Returns the face with another first corner, and its texels rotated with it.
pub fn rotate_corners(face: &Face, [w, h]: [u32; 2], by: usize) -> (Face, [u32; 2]) {
    let n = face.outline().len();
    let mut corners = face.outline().to_vec();
    corners.rotate_left(by % n);
    let face = Face {
        corners: [corners[0], corners[1], corners[2], corners[n - 1]],
        ..face.clone()
    };
    let resolution = if by.is_multiple_of(2) || n == 3 { [w, h] } else { [h, w] };
    (face, resolution)
}
