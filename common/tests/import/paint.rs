//! Variation over a face, texel by texel: textures with their transforms, and vertex colours.

use super::files::{Folder, Gltf, float_bytes, join_quads, notes, square};
use super::textures::{assert_close, embedded_image, picture_bytes, textured_square};
use common::import::ImportOptions;
use common::mesh::Mesh;
use common::scene::{Scene, Shape};
use glam::Vec3;
use serde_json::json;
use std::f32::consts::PI;

const RED: [f32; 3] = [0.5, 0., 0.];
const GREEN: [f32; 3] = [0., 0.25, 0.];
const BLUE: [f32; 3] = [0., 0., 0.125];
const BLACK: [f32; 3] = [0.; 3];

/// Loads the file with its triangles joined.
fn load_joined(gltf: &Gltf, two_sided: bool) -> Scene {
    let options = ImportOptions {
        two_sided,
        ..join_quads()
    };
    gltf.load_with(&options).expect("a scene")
}

fn assert_all_close(found: &[Vec3], expected: &[[f32; 3]]) {
    assert_eq!(found.len(), expected.len());
    for (found, expected) in found.iter().zip(expected) {
        assert_close(*found, *expected);
    }
}

/// Returns the reflectance of the texels of face `f`, n×n per face, in texel order.
fn texel_reflectances(scene: &Scene, f: u32, n: u32) -> Vec<Vec3> {
    let mesh = Mesh::uniform(scene, n, 1).expect("a mesh");
    let own = mesh.texels.iter().filter(|texel| texel.face == f);
    own.map(|texel| texel.reflectance).collect()
}

/// Returns the square with an RGBA colour at each corner.
fn coloured_square(colours: [[f32; 4]; 4]) -> Gltf {
    square().attribute("COLOR_0", "VEC4", colours.as_flattened())
}

#[test]
fn texel_reflectance_is_mean_of_its_pixels() {
    // Texel (0, 0) is at the lower left, and the picture has blue there.
    let scene = load_joined(&textured_square(embedded_image(), [0., 0.], [1., 1.]), true);
    let found = texel_reflectances(&scene, 0, 2);
    assert_all_close(&found, &[BLUE, BLACK, RED, GREEN]);
    // Seen from behind, corner 1 is what corner 3 was.
    assert_all_close(&texel_reflectances(&scene, 1, 2), &[BLUE, RED, BLACK, GREEN]);
    // A third of the way across lies between pixels: the middle one has a part of each.
    let middle = texel_reflectances(&scene, 0, 3)[4];
    assert_close(middle, [0.125, 0.0625, 0.031_25]);
    assert_close(texel_reflectances(&scene, 0, 1)[0], scene.faces[0].reflectance.into());
}

#[test]
fn emission_texture_varies_over_texels() {
    let gltf = textured_square(embedded_image(), [0., 0.], [1., 1.])
        .set("/materials/0/emissiveFactor", json!([1, 0.5, 1]))
        .set("/materials/0/emissiveTexture", json!({"index": 0, "texCoord": 1}));
    let scene = load_joined(&gltf, false);
    let mesh = Mesh::uniform(&scene, 2, 1).expect("a mesh");
    let found: Vec<Vec3> = mesh.texels.iter().map(|texel| texel.emission / PI).collect();
    let expected = [[0., 0., 1.], [0.; 3], [1., 0., 0.], [0., 0.5, 0.]];
    assert_all_close(&found, &expected);
    // What was replaced does not vary; the light still does.
    let options = ImportOptions {
        reflectance: Some(Vec3::splat(0.25)),
        ..join_quads()
    };
    let given = gltf.load_with(&options).expect("a scene");
    let mesh = Mesh::uniform(&given, 2, 1).expect("a mesh");
    assert!(mesh.texels.iter().all(|t| t.reflectance == Vec3::splat(0.25)));
    assert!(mesh.texels[0].emission != mesh.texels[1].emission);
}

#[test]
fn vertex_colours_interpolate_linearly() {
    let [r, g, b] = [[1., 0., 0., 1.], [0., 1., 0., 1.], [0., 0., 1., 0.5]];
    let scene = coloured_square([r, g, b, b]).scene();
    assert_eq!(notes(&scene, "colour"), [""; 0]);
    // Each corner weighs a third of the first triangle.
    assert_close(scene.faces[0].reflectance, [0.5 / 3.0, 0.25 / 3.0, 0.125 / 3.0]);
    // Of its four parts, those at corners weigh these by ⅔, the middle one all three alike.
    let found = texel_reflectances(&scene, 0, 2);
    let of = |[r, g, b]: [f32; 3]| [0.5 * r / 6.0, 0.25 * g / 6.0, 0.125 * b / 6.0];
    let expected = [[4., 1., 1.], [2., 2., 2.], [1., 4., 1.], [1., 1., 4.]].map(of);
    assert_all_close(&found, &expected);
}

#[test]
fn vertex_colours_without_material_stay_below_white() {
    let [white, grey] = [[1.; 4], [0.5, 0.5, 0.5, 1.]];
    let bare = |colours| coloured_square(colours).remove("/meshes/0/primitives/0/material");
    let even = bare([white; 4]).scene();
    assert_eq!(even.faces[0].reflectance, Vec3::splat(0.95));
    assert!(!even.is_painted());
    let scene = bare([white, grey, grey, grey]).scene();
    assert_close(scene.faces[0].reflectance, [(0.95 + 1.0) / 3.0; 3]);
    assert_eq!(notes(&scene, "reflect all light in places").len(), 1);
    // Beyond 1 is 1.
    let beyond = bare([[7., 7., 7., 1.]; 4]).scene();
    assert_eq!(beyond.faces[0].reflectance, Vec3::splat(0.95));
    let odd = coloured_square([white; 4]).set("/accessors/2/type", json!("SCALAR"));
    assert!(odd.error().contains("accessor 2 (colours) is of type"));
}

#[test]
fn triangles_are_not_joined_over_a_seam() {
    // Six vertices: those of the second triangle that it shares with the first are black.
    let on = |second: f32| {
        let corners = [[0., 0.], [1., 0.], [1., 1.], [0., 0.], [1., 1.], [0., 1.]];
        let place = corners.map(|[x, y]| [x, y, 0.]);
        let light = [1., 1., 1., second, second, second].map(|x| [x; 3]);
        let bytes = float_bytes([place, light].as_flattened().as_flattened());
        let vectors = |offset: u32| json!({"bufferView": 2, "byteOffset": offset, "componentType": 5126, "count": 6, "type": "VEC3"});
        let gltf = square()
            .view(&bytes)
            .set("/accessors/-", vectors(0))
            .set("/accessors/-", vectors(72))
            .remove("/meshes/0/primitives/0/indices")
            .set("/meshes/0/primitives/0/attributes/POSITION", json!(2))
            .set("/meshes/0/primitives/0/attributes/COLOR_0", json!(3));
        load_joined(&gltf, false)
    };
    assert_eq!(on(1.0).faces[0].shape, Shape::Quad);
    let seam = on(0.0);
    let found: Vec<f32> = seam.faces.iter().map(|f| f.reflectance.x).collect();
    assert_eq!(found, [0.5, 0.0]);
}

#[test]
fn obj_texture_varies_over_texels() {
    // A quad, and a pentagon that becomes triangles: each of them has its own part.
    let text = "mtllib a.mtl\nusemtl a\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 2 0\nv -1 1 0\n\
        vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\nf 1/1 2/2 3/3 5/4 6/4\n";
    let folder = Folder::new()
        .with("a.obj", text)
        .with("a.mtl", "newmtl a\nKd 0.5 0.25 0.125\nmap_Kd a.png\n")
        .with("a.png", picture_bytes());
    let scene = folder.load("a.obj").expect("a scene");
    assert_all_close(&texel_reflectances(&scene, 0, 2), &[BLUE, BLACK, RED, GREEN]);
    let pieces: Vec<_> = scene.faces.iter().filter(|f| f.input_face == Some(1)).collect();
    assert_eq!(pieces.len(), 3);
    // The first lies below the picture's diagonal, the last on its upper left corner and left side.
    assert_close(pieces[0].reflectance, [0., 0.0625, 0.031_25]);
    assert!(pieces[0].paint.is_some());
    let other = |f: &&&common::scene::Face| f.reflectance != pieces[0].reflectance;
    assert!(pieces.iter().any(|f| other(&f)));
}

#[test]
fn even_texture_gives_no_paint() {
    // Of a palette each face has one colour.
    let scene = load_joined(&textured_square(embedded_image(), [0.1, 0.1], [0.4, 0.4]), false);
    assert_close(scene.faces[0].reflectance, RED);
    assert!(!scene.is_painted());
}
