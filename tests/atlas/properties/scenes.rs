//! The scenes, small enough for hundreds of solves.

use common::cover;
use common::mesh::Mesh;
use common::scene::{Face, Scene};
use glam::{DMat3, DVec3, Vec3};
use oracle::study::random::{self, Faces, Kind, Options};
use proptest::prelude::*;
use radiosity_tests::random::{Sample, closed, empty, open};

/// A scene and how it is cut.
#[derive(Clone, Debug)]
pub struct Cut {
    pub scene: Scene,
    pub resolutions: Vec<[u32; 2]>,
    pub cells: u32,
    /// Nothing escapes.
    pub closed: bool,
}

impl Cut {
    /// Its mesh, looked at in `samples` points.
    pub fn mesh(&self, samples: u32) -> Mesh {
        let mut mesh = Mesh::new(&self.scene, &self.resolutions, self.cells).unwrap();
        cover::sample(&mut mesh, samples);
        mesh
    }

    /// The same faces, moved.
    pub fn moved(&self, to: impl Fn(DVec3) -> DVec3) -> Self {
        let mut cut = self.clone();
        for face in &mut cut.scene.faces {
            face.corners = face.corners.map(&to);
        }
        cut
    }
}

/// Sides of at most `most` texels, 2×2 cells, and light that is not lost in rounding: reflectances
/// of 0.8 at most, so that errors are not made a hundred times as large.
fn cut(sample: Sample, most: u32, closed: bool) -> Cut {
    let mut scene = sample.scene;
    for face in &mut scene.faces {
        face.reflectance = face.reflectance.min(Vec3::splat(0.8));
    }
    // Some light is better than none.
    if scene.faces.iter().all(|face| face.emission == Vec3::ZERO) {
        scene.faces[0].emission = Vec3::new(1.0, 2.0, 0.5);
    }
    let side = |n: &u32| if *n > 4 { most } else { 2 };
    Cut {
        resolutions: (sample.resolutions.iter())
            .zip(&scene.faces)
            .map(|([w, h], face)| match face.outline().len() {
                3 => [side(w); 2],
                _ => [side(w), side(h)],
            })
            .collect(),
        scene,
        cells: 2,
        closed,
    }
}

/// A closed room with nothing in it, sheared so that hardly two of its walls are at right angles;
/// walls are parallelograms, or two triangles each.
pub fn convex() -> impl Strategy<Value = Cut> {
    (empty(), prop::array::uniform3(-0.4f64..0.4)).prop_map(|(sample, [a, b, c])| {
        let shear = DMat3::from_cols(DVec3::X, DVec3::new(a, 1.0, 0.0), DVec3::new(b, c, 1.0));
        cut(sample, 4, true).moved(|p| shear * p)
    })
}

/// A room with floating boxes; closed, or without some of its walls.
pub fn furnished() -> impl Strategy<Value = Cut> {
    prop_oneof![
        closed().prop_map(|sample| cut(sample, 4, true)),
        open().prop_map(|sample| cut(sample, 4, false)),
    ]
}

/// Anything: rooms convex and not, closed and open, with bodies, sheets and lamps, of quads,
/// triangles or both.
pub fn drawn() -> impl Strategy<Value = Cut> {
    let faces = prop_oneof![
        Just(Faces::Quads),
        Just(Faces::Triangles),
        Just(Faces::Mixed)
    ];
    (any::<u64>(), faces).prop_map(|(seed, faces)| {
        let drawn = random::scene(
            seed,
            Options {
                kind: Kind::Any,
                faces,
            },
        );
        let count = drawn.scene.faces.len();
        Cut {
            resolutions: vec![[2, 2]; count],
            scene: drawn.scene,
            cells: 1,
            closed: drawn.closed,
        }
    })
}

/// Both kinds.
pub fn any_scene() -> impl Strategy<Value = Cut> {
    prop_oneof![2 => furnished(), 1 => drawn()]
}

/// The face with its corners named from another one on, and its texels turned with it.
pub fn turned(face: &Face, [w, h]: [u32; 2], by: usize) -> (Face, [u32; 2]) {
    let n = face.outline().len();
    let mut corners = face.outline().to_vec();
    corners.rotate_left(by % n);
    let face = Face {
        corners: [corners[0], corners[1], corners[2], corners[n - 1]],
        ..face.clone()
    };
    let resolution = if by.is_multiple_of(2) || n == 3 {
        [w, h]
    } else {
        [h, w]
    };
    (face, resolution)
}
