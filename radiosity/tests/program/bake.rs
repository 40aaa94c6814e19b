//! `solve --gltf`: the baked scene, read like other programs do.

use super::command::{empty_folder, exit_code_and_error, run_radiosity};
use glam::{Vec2, Vec3};
use radiosity::report::picture::{Exposure, encode_srgb};
use std::collections::HashMap;
use std::fs;
use std::path::Path;

/// A floor of two triangles and, beside it, a quad that is no parallelogram, under a lamp, and a red wall.
const SCENE: &str = "mtllib s.mtl
v 0 0 0\nv 0 0 1\nv 1 0 1\nv 1 0 0\nv 2 0 .2\nv 2 0 .8
v .4 1 .4\nv 1.2 1 .4\nv 1.2 1 .7\nv .4 1 .7\nv 0 1 0\nv 0 1 1
o floor\nusemtl white\nf 1 2 3\nf 1 3 4\nf 4 3 6 5
o lamp\nusemtl lamp\nf 7 8 9 10
o wall\nusemtl red\nf 2 1 11 12\n";
const MATERIALS: &str = "newmtl white\nKd .7 .7 .7\nnewmtl red\nKd .8 .1 .1\nnewmtl lamp\nKd 0 0 0\nKe 3 3 3\n";

/// Corners with their texture coordinates, part by part.
pub struct Read {
    pub corners: Vec<(Vec3, Vec2)>,
    pub triangles: Vec<[usize; 3]>,
    picture: image::RgbaImage,
    white: f32,
}

pub fn read_glb(path: &Path) -> Read {
    let bytes = fs::read(path).unwrap();
    let document = gltf::Gltf::from_slice(&bytes).unwrap();
    let blob = document.blob.as_deref().unwrap();
    let (mut corners, mut triangles) = (Vec::new(), Vec::new());
    for primitive in document.meshes().flat_map(|mesh| mesh.primitives()) {
        let first = corners.len();
        let reader = primitive.reader(|_| Some(blob));
        let places = reader.read_positions().unwrap().map(Vec3::from);
        let uvs = reader.read_tex_coords(1).unwrap().into_f32();
        corners.extend(places.zip(uvs.map(Vec2::from)));
        let index = reader.read_indices().unwrap().into_u32();
        let index: Vec<usize> = index.map(|k| first + k as usize).collect();
        triangles.extend(index.as_chunks::<3>().0);
    }
    let gltf::image::Source::View { view, .. } = document.images().next().unwrap().source() else {
        panic!("the picture is not in the file");
    };
    let picture = &blob[view.offset()..view.offset() + view.length()];
    let json = gltf::Glb::from_slice(&bytes).unwrap().json.into_owned();
    let json: serde_json::Value = serde_json::from_slice(&json).unwrap();
    Read {
        corners,
        triangles,
        picture: image::load_from_memory(picture).unwrap().into_rgba8(),
        white: json["materials"][0]["extras"]["white"].as_f64().unwrap() as f32,
    }
}

#[test]
fn baked_light_has_no_seams() {
    let folder = empty_folder("bake");
    let [scene, glb] = ["s.obj", "s.glb"].map(|name| folder.join(name));
    fs::write(&scene, SCENE).unwrap();
    fs::write(folder.join("s.mtl"), MATERIALS).unwrap();
    let [path, out] = [&scene, &folder].map(|path| path.to_str().unwrap());
    let solve = [
        "solve", path, "--solver", "cpu", "--texels", "8", "--out", out, "--gltf",
    ];
    let output = run_radiosity(&[&solve[..], &[glb.to_str().unwrap()]].concat());
    assert_eq!(output.status.code(), Some(0));

    let read = read_glb(&glb);
    // Two triangles, 8×8 cells of the quad that is no parallelogram, and two triangles each of lamp and wall.
    assert_eq!(read.triangles.len(), 2 + 2 * 64 + 2 * 2);
    let (width, height) = read.picture.dimensions();
    let light = exr::prelude::read_first_flat_layer_from_file(folder.join("s.exr")).unwrap();
    let channels = &light.layer_data.channel_data.list;
    let plane = |name: &str| channels.iter().find(|c| c.name.eq(name)).unwrap();
    let radiosity = |x: u32, y: u32| {
        let at = (y * width + x) as usize;
        Vec3::from(["R", "G", "B"].map(|name| plane(name).sample_data.value_by_flat_index(at).to_f32()))
    };
    let shown = Exposure::with_white(read.white);
    for (x, y, pixel) in read.picture.enumerate_pixels() {
        assert_eq!(
            pixel.0[..3],
            encode_srgb(shown.display_light(radiosity(x, y))),
            "{x} {y}"
        );
    }
    // Corners lie on pixels, and a shared corner has the same light in all charts of the floor.
    let mut known: HashMap<[i32; 3], Vec3> = HashMap::new();
    let mut shared = 0;
    let mut reddest = 0.0f32;
    for (place, uv) in &read.corners {
        let pixel = *uv * Vec2::new(width as f32, height as f32) - 0.5;
        assert!((pixel - pixel.round()).abs().max_element() < 1e-3, "{uv}");
        let own = radiosity(pixel.x.round() as u32, pixel.y.round() as u32);
        if place.x == 0.0 && place.y > 0.5 {
            reddest = reddest.max(own.x / own.y);
        }
        // The corners at the wall belong to other charts.
        let on_floor = place.y == 0.0 && place.x > 0.0;
        if !on_floor {
            continue;
        }
        let key = (*place * 1e3).round().as_ivec3().to_array();
        if let Some(before) = known.insert(key, own) {
            shared += 1;
            assert!(
                (before - own).abs().max_element() <= 1e-5 * own.max_element(),
                "{place} {before} {own}"
            );
        }
    }
    assert!(shared == 3 && reddest > 4.0, "{shared} {reddest}");
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn wrong_file_ending_is_refused_before_solving() {
    let folder = empty_folder("bake-ending");
    let cube = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenes/furnace.obj");
    let out = folder.join("out");
    let (code, text) = exit_code_and_error(&["solve", cube, "--out", out.to_str().unwrap(), "--gltf", "a.obj"]);
    assert_eq!(code, 2, "{text}");
    assert!(text.contains("a.obj"), "{text}");
    assert!(!out.join("result.json").exists());
    fs::remove_dir_all(folder).unwrap();
}
