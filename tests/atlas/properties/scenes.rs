//! Random scenes, small enough for hundreds of solves.

use properties::MeshedScene;
use properties::strategies::furnished_room;
use proptest::prelude::*;
use radiosity_tests::solutions::{FACE_SHAPES, drawn_scene};

/// Draws any scene of `studies::random`: rooms convex and not, closed and open, with boxes, sheets and lamps, of quads,
/// triangles or both.
fn random_scene() -> impl Strategy<Value = MeshedScene> {
    (any::<u64>(), prop::sample::select(&FACE_SHAPES[..])).prop_map(|(seed, faces)| {
        let scene = drawn_scene(seed, faces);
        MeshedScene {
            resolutions: vec![[2, 2]; scene.faces.len()],
            scene,
            patches: 1,
        }
    })
}

/// Draws a furnished room or any random scene.
pub fn any_scene() -> impl Strategy<Value = MeshedScene> {
    prop_oneof![2 => furnished_room(), 1 => random_scene()]
}
