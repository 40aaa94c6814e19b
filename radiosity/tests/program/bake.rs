//! `solve --gltf`: the baked scene, read as other programs do.

use super::command::TestFolder;
use crate::baked::{BakedScene, LightPicture};
use glam::{Vec2, Vec3};
use radiosity::report::picture::{Exposure, encode_srgb};
use serde_json::{Value, json};
use std::collections::HashMap;

/// A floor of two triangles and, beside it, a quad that is no parallelogram, under a lamp, and a red wall.
const SCENE: &str = "mtllib s.mtl
v 0 0 0\nv 0 0 1\nv 1 0 1\nv 1 0 0\nv 2 0 .2\nv 2 0 .8
v .4 1 .4\nv 1.2 1 .4\nv 1.2 1 .7\nv .4 1 .7\nv 0 1 0\nv 0 1 1
o floor\nusemtl white\nf 1 2 3\nf 1 3 4\nf 4 3 6 5
o lamp\nusemtl lamp\nf 7 8 9 10
o wall\nusemtl red\nf 2 1 11 12\n";
const MATERIALS: &str = "newmtl white\nKd .7 .7 .7\nnewmtl red\nKd .8 .1 .1\nnewmtl lamp\nKd 0 0 0\nKe 3 3 3\n";

#[test]
fn baked_picture_and_corners_have_the_light_of_the_exr_file() {
    let folder = TestFolder::new();
    folder.write("s.obj", SCENE);
    folder.write("s.mtl", MATERIALS);
    folder.succeed("solve s.obj --solver cpu --texels 8 --gltf s.glb");

    let glb = folder.read("s.glb");
    let baked = BakedScene::new(&glb);
    // Two triangles, 8×8 cells of the quad that is no parallelogram, and two triangles each of lamp and wall.
    assert_eq!(baked.triangles.len(), 2 + 2 * 64 + 2 * 2);
    let light = LightPicture::new(&folder.read("s.exr"), "");
    let document = gltf::Glb::from_slice(&glb).unwrap();
    let json: Value = serde_json::from_slice(&document.json).unwrap();
    let shown = Exposure::with_white(json["materials"][0]["extras"]["white"].as_f64().unwrap() as f32);
    let picture = image::load_from_memory(&baked.picture).unwrap().into_rgba8();
    for (x, y, pixel) in picture.enumerate_pixels() {
        let radiosity = light.pixel(Vec2::new(x as f32, y as f32));
        assert_eq!(pixel.0[..3], encode_srgb(shown.display_light(radiosity)), "{x} {y}");
    }
    // Corners lie on pixels, and a shared corner has the same light in all charts of the floor.
    let mut known: HashMap<[i32; 3], Vec3> = HashMap::new();
    let mut shared = 0;
    let mut reddest = 0.0f32;
    for (place, uv) in baked.triangles.as_flattened() {
        let pixel = *uv * light.size - 0.5;
        assert!((pixel - pixel.round()).abs().max_element() < 1e-3, "{uv}");
        let own = light.pixel(pixel.round());
        if place.x == 0.0 && place.y > 0.5 {
            reddest = reddest.max(own.x / own.y);
        }
        // The corners at the wall belong to other charts.
        if place.y == 0.0 && place.x > 0.0 {
            let key = (*place * 1e3).round().as_ivec3().to_array();
            if let Some(before) = known.insert(key, own) {
                shared += 1;
                let step = (before - own).abs().max_element();
                assert!(step <= 1e-5 * own.max_element(), "{place} {before} {own}");
            }
        }
    }
    assert!(shared > 3 && reddest > 4.0, "{shared} {reddest}");
}

/// Corners x and z of a triangle, and their texture coordinates.
type Triangle = [[f32; 4]; 3];

/// A floor in two halves. The charts of the halves are apart, and one of them is rotated.
pub const FLOOR: [Triangle; 4] = [
    [[0., 0., 0.1, 0.1], [0., 2., 0.1, 0.5], [1., 2., 0.3, 0.5]],
    [[0., 0., 0.1, 0.1], [1., 2., 0.3, 0.5], [1., 0., 0.3, 0.1]],
    [[1., 0., 0.4, 0.3], [1., 2., 0.8, 0.3], [2., 2., 0.8, 0.1]],
    [[1., 0., 0.4, 0.3], [2., 2., 0.8, 0.1], [2., 0., 0.4, 0.1]],
];
const LAMP: [Triangle; 1] = [[[0.2, 0.3, 0.1, 0.9], [1.0, 0.3, 0.3, 0.9], [0.6, 1.1, 0.2, 0.7]]];

/// Writes a glTF of a grey floor and of the lamp above it, with TEXCOORD_1 only if `charted`.
pub fn write_gltf(folder: &TestFolder, name: &str, floor: &[Triangle], charted: bool) {
    let (mut bytes, mut views, mut accessors, mut meshes) = (vec![], vec![], vec![], vec![]);
    let mut put = |floats: &[f32], kind: &str, count: usize| {
        let view = json!({ "buffer": 0, "byteOffset": bytes.len(), "byteLength": 4 * floats.len() });
        bytes.extend(floats.iter().flat_map(|x| x.to_le_bytes()));
        views.push(view);
        accessors.push(json!({
            "bufferView": views.len() - 1, "componentType": 5126, "type": kind, "count": count,
        }));
        accessors.len() - 1
    };
    for (k, (name, triangles, y)) in [("floor", floor, 0.0), ("lamp", &LAMP, 1.5)].into_iter().enumerate() {
        let corners = triangles.as_flattened();
        let places: Vec<_> = corners.iter().map(|[x, z, ..]| [*x, y, *z]).collect();
        let uvs: Vec<_> = corners.iter().map(|[.., u, v]| [*u, *v]).collect();
        let mut attributes = json!({ "POSITION": put(places.as_flattened(), "VEC3", corners.len()) });
        if charted {
            attributes["TEXCOORD_1"] = put(uvs.as_flattened(), "VEC2", corners.len()).into();
        }
        meshes.push(json!({ "name": name, "primitives": [{ "attributes": attributes, "material": k }] }));
    }
    let uri = format!("{name}.bin");
    let document = json!({
        "asset": { "version": "2.0" },
        "scenes": [{ "nodes": [0, 1] }], "scene": 0,
        "nodes": [{ "mesh": 0 }, { "mesh": 1 }],
        "meshes": meshes,
        "materials": [
            { "pbrMetallicRoughness": { "baseColorFactor": [0.6, 0.5, 0.4, 1] } },
            { "pbrMetallicRoughness": { "baseColorFactor": [0, 0, 0, 1] }, "emissiveFactor": [1, 1, 1] },
        ],
        "buffers": [{ "uri": uri, "byteLength": bytes.len() }],
        "bufferViews": views, "accessors": accessors,
    });
    folder.write(&uri, bytes);
    folder.write(name, document.to_string());
}

/// Charts are baked without seams along their edges (`baked`); here they have the light of the solve.
#[test]
fn kept_charts_have_the_light_of_packed_ones() {
    let folder = TestFolder::new();
    write_gltf(&folder, "s.gltf", &FLOOR, true);
    let solve = "solve s.gltf --solver cpu --error 2% --texels 8";
    let end = folder.succeed(&format!("{solve} --gltf kept.glb --uv keep"));
    assert!(!end.stderr.contains("pixels of the lightmap"), "{end}");
    folder.succeed(&format!("{solve} --gltf packed.glb"));
    let [kept, packed] = ["kept", "packed"].map(|name| {
        let baked = BakedScene::new(&folder.read(&format!("{name}.glb")));
        (baked, LightPicture::new(&folder.read(&format!("{name}.exr")), ""))
    });
    assert_eq!(kept.1.size, Vec2::splat(128.0));
    for (given, triangle) in FLOOR.iter().chain(&LAMP).zip(&kept.0.triangles) {
        let uvs = given.map(|[.., u, v]| Vec2::new(u, v));
        assert_eq!(triangle.map(|(_, uv)| uv), uvs);
    }
    let light = |(baked, light): &(BakedScene, LightPicture), face: usize, point: Vec3| {
        light.at(baked.place_on_chart(face, point))
    };
    let brightest = (0..4)
        .map(|k| light(&packed, k, Vec3::new(1., 0., 1.)).max_element())
        .fold(0.0, f32::max);
    let off = (0..2000).map(|k| {
        let [u, v] = [k % 50, k / 50].map(|n| (n as f32 + 0.5) / 50.0);
        let (face, point) = (usize::from(u > v), Vec3::new(u, 0., 2. * v));
        (light(&kept, face, point) - light(&packed, face, point))
            .abs()
            .max_element()
    });
    let off = off.sum::<f32>() / 2000.0 / brightest;
    // Packed charts hold the corners of texels only, and light bends between them.
    assert!(off < 0.02, "{off}");
}

#[test]
fn unusable_charts_are_refused_and_near_ones_noted() {
    let folder = TestFolder::new();
    write_gltf(&folder, "fine.gltf", &FLOOR, true);
    write_gltf(&folder, "bare.gltf", &FLOOR, false);
    let mut floor = FLOOR;
    floor[2] = [[1., 0., 0.1, 0.1], [1., 2., 0.1, 0.5], [2., 2., 0.3, 0.5]];
    write_gltf(&folder, "double.gltf", &floor, true);
    floor[2][0] = [1., 0., -0.5, 0.];
    write_gltf(&folder, "outside.gltf", &floor, true);
    folder.write("s.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    folder.assert_refused(
        "solve bare.gltf --uv keep --gltf b.glb => mesh 0 primitive 0: has no TEXCOORD_1
         solve double.gltf --uv keep --gltf b.glb => face 3 (floor): lies on face 1 (floor)
         solve outside.gltf --uv keep --gltf b.glb => face 3 (floor): reaches (-0.500, 0.000)
         solve fine.gltf --uv keep --gltf b.glb --two-sided => leave --two-sided out
         solve s.obj --uv keep --gltf b.glb => export as glTF",
    );
    // The chart of the second half touches that of the first at an edge that they do not share.
    let mut floor = FLOOR;
    for corner in floor[2..].as_flattened_mut() {
        corner[2] -= 0.1;
    }
    write_gltf(&folder, "near.gltf", &floor, true);
    let end = folder.succeed("solve near.gltf --solver cpu --error 5% --texels 4 --uv keep --gltf b.glb");
    let note = " of the 2048×2048 pixels of the lightmap lie between charts";
    assert!(end.stderr.contains(note), "{end}");
}
