//! `solve --gltf`: the baked scene, read as other programs do.

use super::command::TestFolder;
use crate::baked::{BakedScene, LightPicture};
use glam::{Vec2, Vec3};
use radiosity::report::picture::{Exposure, encode_srgb};
use serde_json::{Value, json};

/// A floor of two triangles and, beside it, a quad that is no parallelogram, under a lamp, and a red wall.
const SCENE: &str = "mtllib s.mtl
v 0 0 0\nv 0 0 1\nv 1 0 1\nv 1 0 0\nv 2 0 .2\nv 2 0 .8
v .4 1 .4\nv 1.2 1 .4\nv 1.2 1 .7\nv .4 1 .7\nv 0 1 0\nv 0 1 1
o floor\nusemtl white\nf 1 2 3\nf 1 3 4\nf 4 3 6 5
o lamp\nusemtl lamp\nf 7 8 9 10
o wall\nusemtl red\nf 2 1 11 12\n";
const MATERIALS: &str = "newmtl white\nKd .7 .7 .7\nnewmtl red\nKd .8 .1 .1\nnewmtl lamp\nKd 0 0 0\nKe 3 3 3\n";

#[test]
fn baked_picture_has_the_irradiance_of_the_exr_file() {
    let folder = TestFolder::new();
    folder.write("s.obj", SCENE);
    folder.write("s.mtl", MATERIALS);
    folder.succeed("solve s.obj --solver cpu --texels 8 --gltf s.glb");

    let glb = folder.read("s.glb");
    let baked = BakedScene::new(&glb);
    // Two triangles of the floor and two of each quad; nothing else becomes of them.
    assert_eq!(baked.triangles.len(), 2 + 2 * 3);
    let light = LightPicture::new(&folder.read("s.exr"), "irradiance.");
    let radiosity = LightPicture::new(&folder.read("s.exr"), "");
    let lightmap = &baked.json["materials"][0]["extensions"]["MOZ_lightmap"];
    let shown = Exposure::with_white(lightmap["intensity"].as_f64().unwrap() as f32);
    let picture = image::load_from_memory(&baked.picture).unwrap().into_rgba8();
    for (x, y, pixel) in picture.enumerate_pixels() {
        let irradiance = light.pixel(Vec2::new(x as f32, y as f32));
        assert_eq!(pixel.0[..3], encode_srgb(shown.display_light(irradiance)), "{x} {y}");
    }
    // The wall reflects eight times as much red as green.
    for (k, [(place, uv), ..]) in baked.triangles.iter().enumerate().skip(6) {
        let light = radiosity.at(*uv);
        assert!(light.x > 4.0 * light.y, "{k} {place}: {light}");
    }
}

/// Groups become nodes, materials keep their names, and vertices stay shared.
#[test]
fn obj_is_baked_with_its_groups_materials_and_textures() {
    let folder = TestFolder::new();
    let textured = "v 3 0 0\nv 3 0 1\nv 4 0 1\nv 4 0 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\no picture\nusemtl picture\nf 13/1 14/2 15/3 16/4\n";
    folder.write("s.obj", format!("{SCENE}{textured}"));
    folder.write(
        "s.mtl",
        format!("{MATERIALS}newmtl picture\nKd .5 .5 .5\nmap_Kd wood.png\n"),
    );
    let mut png = std::io::Cursor::new(Vec::new());
    let wood = image::RgbImage::from_fn(4, 2, |x, y| image::Rgb([40 * x as u8, 90 * y as u8, 60]));
    wood.write_to(&mut png, image::ImageFormat::Png).unwrap();
    let png = png.into_inner();
    folder.write("wood.png", &png);
    folder.succeed("solve s.obj --solver cpu --error 10% --gltf s.glb");

    let (document, buffers, _) = read_glb(&folder.read("s.glb"));
    let names = |of: &str| -> Vec<String> {
        let list = document[of].as_array().unwrap().iter();
        list.map(|entry| entry["name"].as_str().unwrap_or("").to_owned())
            .collect()
    };
    assert_eq!(names("nodes"), ["floor", "lamp", "wall", "picture"]);
    assert_eq!(names("materials"), ["white", "lamp", "red", "picture"]);
    let lamp = &document["materials"][1];
    assert_eq!(lamp["emissiveFactor"], json!([1.0, 1.0, 1.0]));
    assert_eq!(
        lamp["extensions"]["KHR_materials_emissive_strength"]["emissiveStrength"],
        3.0
    );
    let texture = &document["materials"][3]["pbrMetallicRoughness"]["baseColorTexture"]["index"];
    let source = &document["textures"][texture.as_u64().unwrap() as usize]["source"];
    let view = &document["images"][source.as_u64().unwrap() as usize]["bufferView"];
    assert_eq!(view_bytes(&document, &buffers, view), png);
    let floor = &document["meshes"][0]["primitives"][0];
    let place = floor["attributes"]["POSITION"].as_u64().unwrap() as usize;
    // Two triangles and a quad with six different corners, coplanar: no seam.
    assert_eq!(document["accessors"][place]["count"], 6);
}

/// Reads the JSON and the binary chunk of a GLB, and its vertices as bytes.
fn read_glb(glb: &[u8]) -> (Value, Vec<u8>, gltf::Gltf) {
    let chunks = gltf::Glb::from_slice(glb).unwrap();
    let document = serde_json::from_slice(&chunks.json).unwrap();
    (
        document,
        chunks.bin.unwrap().into_owned(),
        gltf::Gltf::from_slice_without_validation(glb).unwrap(),
    )
}

fn view_bytes(document: &Value, bytes: &[u8], view: &Value) -> Vec<u8> {
    let view = &document["bufferViews"][view.as_u64().unwrap() as usize];
    let [start, length] = ["byteOffset", "byteLength"].map(|of| view[of].as_u64().unwrap_or(0) as usize);
    bytes[start..start + length].to_vec()
}

/// A cube with eight shared vertices, in the middle of a lit room, placed twice in a hierarchy.
fn write_hierarchy(folder: &TestFolder) {
    let corners: Vec<[f32; 3]> = (0..8)
        .map(|k| [0, 1, 2].map(|axis| if k >> axis & 1 == 0 { -0.5 } else { 0.5 }))
        .collect();
    let sides = [
        [1, 3, 2, 0],
        [4, 6, 7, 5],
        [0, 4, 5, 1],
        [2, 3, 7, 6],
        [0, 2, 6, 4],
        [1, 5, 7, 3],
    ];
    let outside: Vec<u8> = sides.iter().flat_map(|[a, b, c, d]| [*a, *d, *c, *a, *c, *b]).collect();
    let inside: Vec<u8> = outside.chunks(3).flat_map(|t| [t[0], t[2], t[1]]).collect();
    let mut bytes: Vec<u8> = corners.as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect();
    let (cube, room) = (bytes.len(), bytes.len() + outside.len());
    bytes.extend(&outside);
    bytes.extend(&inside);
    let marks = bytes.len();
    bytes.extend([10, 11, 12, 13, 14, 15, 16, 17]);
    let mut png = std::io::Cursor::new(Vec::new());
    let picture = image::RgbImage::from_pixel(2, 2, image::Rgb([200, 150, 100]));
    picture.write_to(&mut png, image::ImageFormat::Png).unwrap();
    folder.write("deep/wood.png", png.into_inner());
    folder.write("deep/s.bin", &bytes);
    let document = json!({
        "asset": { "version": "2.0", "generator": "by hand", "extras": { "made": 1 } },
        "extensionsUsed": ["KHR_lights_punctual", "VENDOR_unknown"],
        "extensions": { "VENDOR_unknown": { "list": [1, 2.5, "three"] } },
        "scene": 0,
        "scenes": [{ "name": "all", "nodes": [0, 5], "extras": { "level": "ground" } }],
        "nodes": [
            { "name": "root", "children": [1, 2, 3], "scale": [2, 2, 2], "extras": { "tag": [true, null] } },
            { "name": "left", "mesh": 0, "translation": [-0.5, 0, 0], "scale": [0.25, 0.25, 0.25] },
            { "name": "right", "mesh": 0, "translation": [0.5, 0.2, 0], "scale": [-0.25, 0.25, 0.25] },
            { "name": "walls", "mesh": 1, "scale": [2, 1, 1], "children": [4] },
            { "name": "sight", "camera": 0 },
            { "name": "lamp", "mesh": 2, "translation": [0, 0.9, 0], "rotation": [0, 1, 0, 0], "scale": [0.5, 0.05, 0.5] },
        ],
        "cameras": [{ "name": "eye", "type": "perspective", "perspective": { "yfov": 0.8, "znear": 0.1 } }],
        "animations": [],
        "meshes": [
            { "name": "cube", "primitives": [
                { "attributes": { "POSITION": 0, "_MARK": 3 }, "indices": 1, "material": 0, "extras": { "sort": 7 } },
                { "attributes": { "POSITION": 0 }, "mode": 0, "material": 0 },
            ], "extras": { "kind": "crate" } },
            { "name": "walls", "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 2, "material": 1 }] },
            { "name": "lamp", "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 1, "material": 2 }] },
        ],
        "materials": [
            { "name": "wood", "doubleSided": true, "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } },
              "extras": { "cost": 3 }, "extensions": { "VENDOR_unknown": { "gloss": 0.5 } } },
            { "name": "paint", "pbrMetallicRoughness": { "baseColorFactor": [0.5, 0.6, 0.7, 1.0], "metallicFactor": 0.0 } },
            { "name": "glow", "emissiveFactor": [1.0, 1.0, 1.0] },
        ],
        "textures": [{ "source": 0, "name": "wood texture" }],
        "images": [{ "uri": "wood.png", "name": "wood picture" }],
        "buffers": [{ "uri": "s.bin", "byteLength": bytes.len() }],
        "bufferViews": [
            { "buffer": 0, "byteLength": cube },
            { "buffer": 0, "byteOffset": cube, "byteLength": 36 },
            { "buffer": 0, "byteOffset": room, "byteLength": 36 },
            { "buffer": 0, "byteOffset": marks, "byteLength": 8 },
        ],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 8, "min": [-0.5, -0.5, -0.5], "max": [0.5, 0.5, 0.5] },
            { "bufferView": 1, "componentType": 5121, "type": "SCALAR", "count": 36 },
            { "bufferView": 2, "componentType": 5121, "type": "SCALAR", "count": 36 },
            { "bufferView": 3, "componentType": 5121, "type": "SCALAR", "count": 8 },
        ],
    });
    folder.write("deep/s.gltf", document.to_string());
}

#[test]
fn gltf_is_kept_node_by_node() {
    let folder = TestFolder::new();
    write_hierarchy(&folder);
    folder.succeed("solve deep/s.gltf --solver cpu --error 10% --gltf s.glb");
    let before = folder.read_json("deep/s.gltf");
    let (after, bytes, _) = read_glb(&folder.read("s.glb"));
    for unchanged in ["asset", "scene", "scenes", "cameras", "animations", "extensions"] {
        assert_eq!(after[unchanged], before[unchanged], "{unchanged}");
    }
    let list = |document: &Value, name: &str| document[name].as_array().unwrap().clone();
    for (k, node) in list(&before, "nodes").into_iter().enumerate() {
        let mut expected = node;
        if k == 2 {
            // The second place of the cube has a copy of its mesh.
            expected["mesh"] = 3.into();
        }
        assert_eq!(after["nodes"][k], expected, "{k}");
    }
    assert_eq!(list(&after, "nodes").len(), 6);
    assert_eq!(list(&after, "meshes").len(), 4);
    for (k, own) in [(0, 0), (1, 1), (2, 2), (3, 0)] {
        let [mesh, was] = [&after["meshes"][k], &before["meshes"][own]];
        assert_eq!((&mesh["name"], &mesh["extras"]), (&was["name"], &was["extras"]), "{k}");
        assert_eq!(mesh["primitives"][0]["extras"], was["primitives"][0]["extras"], "{k}");
        // Points are not lit, and keep the material as it was.
        assert_eq!(mesh["primitives"][1], was["primitives"][1], "{k}");
    }
    for prefix in ["accessors", "textures"] {
        let was = list(&before, prefix);
        assert_eq!(list(&after, prefix)[..was.len()], was, "{prefix}");
    }
    // The points' material stays, and the cubes have a copy with the lightmap.
    assert_eq!(after["materials"][0], before["materials"][0]);
    let mut lit = after["materials"][3].clone();
    let lightmap = lit["extensions"]
        .as_object_mut()
        .unwrap()
        .remove("MOZ_lightmap")
        .unwrap();
    assert_eq!(lit, before["materials"][0]);
    assert_eq!(lightmap["texCoord"], 1);
    for k in [1, 2] {
        let mut material = after["materials"][k].clone();
        assert_eq!(material["extensions"]["MOZ_lightmap"], lightmap);
        material.as_object_mut().unwrap().remove("extensions");
        assert_eq!(material, before["materials"][k]);
    }
    assert_eq!(after["images"][0]["name"], "wood picture");
    assert_eq!(
        view_bytes(&after, &bytes, &after["images"][0]["bufferView"]),
        folder.read("deep/wood.png")
    );
    let old = folder.read("deep/s.bin");
    assert_eq!(bytes[..old.len()], old);
    // Each corner of a cube lies in three charts: copied twice, with all attributes.
    let primitive = &after["meshes"][3]["primitives"][0];
    let index = |name: &str| primitive["attributes"][name].as_u64().unwrap() as usize;
    for name in ["POSITION", "_MARK", "TEXCOORD_1"] {
        assert_eq!(after["accessors"][index(name)]["count"], 24, "{name}");
    }
    let view = &after["accessors"][index("_MARK")]["bufferView"];
    let marks = view_bytes(&after, &bytes, view);
    let places = view_bytes(&after, &bytes, &after["accessors"][index("POSITION")]["bufferView"]);
    for (mark, place) in marks.chunks(4).zip(places.chunks(12)) {
        let own = usize::from(mark[0] - 10) * 12;
        assert_eq!(place, &old[own..own + 12]);
    }
}

/// Two places of one mesh have the light of their own place.
#[test]
fn each_instance_has_its_own_light() {
    let folder = TestFolder::new();
    write_hierarchy(&folder);
    folder.change_json("deep/s.gltf", |document| {
        // The lamp is beside the left cube alone.
        document["nodes"][5]["translation"] = json!([-1.0, 0.9, 0.0]);
        document["nodes"][5]["scale"] = json!([0.3, 0.05, 0.3]);
    });
    folder.succeed("solve deep/s.gltf --solver cpu --error 5% --gltf s.glb");
    let baked = BakedScene::new(&folder.read("s.glb"));
    let light = LightPicture::new(&folder.read("s.exr"), "irradiance.");
    let top = |x: f32| {
        let is_top = |[(a, _), (b, _), (c, _)]: &&[(Vec3, Vec2); 3]| {
            let high = a.y.min(b.y).min(c.y);
            (a.y - c.y).abs() + (a.y - b.y).abs() < 1e-5 && high < 0.8 && high > -0.8 && a.x * x > 0.0
        };
        let tops = baked.triangles.iter().filter(is_top).filter(|[(a, _), ..]| a.y > 0.0);
        let lights: Vec<f32> = tops.flatten().map(|(_, uv)| light.at(*uv).x).collect();
        assert!(!lights.is_empty());
        lights.iter().sum::<f32>() / lights.len() as f32
    };
    let [left, right] = [top(-1.0), top(1.0)];
    assert!(left > 3.0 * right, "{left} {right}");
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
    // Both are sampled between pixels.
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
