//! Random scenes, small enough for hundreds of solves.

use common::cover;
use common::mesh::Mesh;
use common::scene::{Face, Scene};
use glam::{DMat3, DVec3, Vec3};
use proptest::prelude::*;
use radiosity::studies::random::{self, FaceShapes, SceneKind, SceneOptions};
use radiosity_tests::random_rooms::{RandomRoom, closed_room, empty_room, open_room};

/// A scene with its texels and patches.
#[derive(Clone, Debug)]
pub struct MeshedScene {
    pub scene: Scene,
    pub resolutions: Vec<[u32; 2]>,
    pub patches: u32,
}

impl MeshedScene {
    /// Meshes the scene with `samples` points per patch.
    pub fn build_mesh(&self, samples: u32) -> Mesh {
        let mut mesh = Mesh::new(&self.scene, &self.resolutions, self.patches).unwrap();
        cover::sample_covers(&mut mesh, samples);
        mesh
    }

    /// Maps all corners by `to`.
    pub fn map_corners(&self, to: impl Fn(DVec3) -> DVec3) -> Self {
        let mut cut = self.clone();
        for face in &mut cut.scene.faces {
            face.corners = face.corners.map(&to);
        }
        cut
    }
}

/// Sets sides of 2 or 4 texels, 2×2 patches, and reflectances of at most 0.8, so that errors are not amplified a
/// hundred times. Some face emits.
fn mesh_room(sample: RandomRoom) -> MeshedScene {
    let mut scene = sample.scene;
    for face in &mut scene.faces {
        face.reflectance = face.reflectance.min(Vec3::splat(0.8));
    }
    if scene.faces.iter().all(|face| face.emission == Vec3::ZERO) {
        scene.faces[0].emission = Vec3::new(1.0, 2.0, 0.5);
    }
    let side = |n: &u32| if *n > 4 { 4 } else { 2 };
    MeshedScene {
        resolutions: (sample.resolutions.iter())
            .zip(&scene.faces)
            .map(|([w, h], face)| match face.outline().len() {
                3 => [side(w); 2],
                _ => [side(w), side(h)],
            })
            .collect(),
        scene,
        patches: 2,
    }
}

/// Draws a closed room without objects, sheared so that hardly two of its walls are at right angles; walls are
/// parallelograms, or two triangles each.
pub fn convex_room() -> impl Strategy<Value = MeshedScene> {
    (empty_room(), prop::array::uniform3(-0.4f64..0.4)).prop_map(|(sample, [a, b, c])| {
        let shear = DMat3::from_cols(DVec3::X, DVec3::new(a, 1.0, 0.0), DVec3::new(b, c, 1.0));
        mesh_room(sample).map_corners(|p| shear * p)
    })
}

/// Draws a room with floating boxes; closed, or without some of its walls.
pub fn furnished_room() -> impl Strategy<Value = MeshedScene> {
    prop_oneof![closed_room().prop_map(mesh_room), open_room().prop_map(mesh_room),]
}

/// Draws any scene of `studies::random`: rooms convex and not, closed and open, with boxes, sheets and lamps, of quads,
/// triangles or both.
pub fn random_scene() -> impl Strategy<Value = MeshedScene> {
    let faces = prop_oneof![
        Just(FaceShapes::Quads),
        Just(FaceShapes::Triangles),
        Just(FaceShapes::Mixed)
    ];
    (any::<u64>(), faces).prop_map(|(seed, faces)| {
        let drawn = random::draw_scene(
            seed,
            SceneOptions {
                kind: SceneKind::Any,
                faces,
            },
        );
        let count = drawn.scene.faces.len();
        MeshedScene {
            resolutions: vec![[2, 2]; count],
            scene: drawn.scene,
            patches: 1,
        }
    })
}

/// Draws a furnished room or any random scene.
pub fn any_scene() -> impl Strategy<Value = MeshedScene> {
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
