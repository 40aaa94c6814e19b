//! Textures of constant faces: means, transforms, wrap modes and locations of pictures.

use super::files::{Folder, Gltf, notes, square, text_lines};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use common::import::{ImportOptions, load_scene};
use glam::Vec3;
use image::{ImageFormat, Rgb, RgbImage};
use serde_json::{Value, json};
use std::f32::consts::PI;
use std::io::Cursor;

/// Two by two pixels: red and green above, blue and black below.
pub fn picture_bytes() -> Vec<u8> {
    encode_picture(ImageFormat::Png)
}

fn encode_picture(format: ImageFormat) -> Vec<u8> {
    let colours = [[255, 0, 0], [0, 255, 0], [0, 0, 255], [0, 0, 0]];
    let image = RgbImage::from_fn(2, 2, |x, y| Rgb(colours[(x + 2 * y) as usize]));
    let mut bytes = Cursor::new(Vec::new());
    image.write_to(&mut bytes, format).expect("a picture");
    bytes.into_inner()
}

/// Returns the square with texture coordinates as set 1: its corners are those of the rectangle from `low` to `high`,
/// corner 0 at the lower left of the picture as seen.
pub fn textured_square(image: Value, [left, top]: [f32; 2], [right, bottom]: [f32; 2]) -> Gltf {
    let places = [[left, bottom], [right, bottom], [right, top], [left, top]];
    square()
        .attribute("TEXCOORD_1", "VEC2", places.as_flattened())
        .set("/images", json!([image]))
        .set("/textures", json!([{"source": 0}]))
        .set(
            "/materials/0/pbrMetallicRoughness/baseColorTexture",
            json!({"index": 0, "texCoord": 1}),
        )
}

pub fn embedded_image() -> Value {
    json!({"uri": format!("data:image/png;base64,{}", STANDARD.encode(picture_bytes()))})
}

pub fn assert_close(found: Vec3, expected: [f32; 3]) {
    assert!(
        (found - Vec3::from(expected)).length() < 1e-6,
        "{found} instead of {expected:?}"
    );
}

#[test]
fn pictures_are_read_from_buffers_and_files() {
    let [low, high] = [[0., 0.], [0.5, 0.5]];
    let red = [0.5, 0., 0.];
    let within = textured_square(json!({"bufferView": 3, "mimeType": "image/png"}), low, high);
    let within = within.view(&picture_bytes());
    assert_close(within.scene().faces[0].reflectance, red);
    let beside = textured_square(json!({"uri": "a%20b.png"}), low, high);
    let folder = Folder::new()
        .with("a.glb", beside.glb())
        .with("a b.png", picture_bytes());
    let scene = folder.load("a.glb").expect("a scene");
    assert_close(scene.faces[0].reflectance, red);
}

#[test]
fn webp_pictures_are_read_where_there_is_no_other() {
    let webp = encode_picture(ImageFormat::WebP);
    let textured = textured_square(embedded_image(), [0., 0.], [0.5, 0.5])
        .view(&webp)
        .set("/images/-", json!({"bufferView": 3, "mimeType": "image/webp"}))
        .set("/extensionsRequired", json!(["EXT_texture_webp"]))
        .set(
            "/textures/0",
            json!({"extensions": {"EXT_texture_webp": {"source": 1}}}),
        );
    assert_close(textured.scene().faces[0].reflectance, [0.5, 0., 0.]);
    let both = textured.clone().set("/textures/0/source", json!(0));
    let both = both.set("/textures/0/extensions/EXT_texture_webp/source", json!(7));
    assert_close(both.scene().faces[0].reflectance, [0.5, 0., 0.]);
    let beyond = textured.set("/textures/0/extensions/EXT_texture_webp/source", json!(1_u64 << 32));
    assert!(beyond.error().contains("has the index 4294967296"));
}

#[test]
fn texture_transform_and_wrap_modes_apply() {
    let info = "/materials/0/pbrMetallicRoughness/baseColorTexture/extensions";
    let with = |transform: Value| {
        textured_square(embedded_image(), [0., 0.], [0.5, 0.5]).set(info, json!({"KHR_texture_transform": transform}))
    };
    let first = |gltf: &Gltf| gltf.scene().faces[0].reflectance;
    assert_close(first(&with(json!({"offset": [0.5, 0]}))), [0., 0.25, 0.]);
    assert_close(
        first(&with(json!({"scale": [1, 1], "offset": [1, 0.5]}))),
        [0., 0., 0.125],
    );
    assert_close(first(&with(json!({"texCoord": 0}))), [0.125, 0.0625, 0.031_25]);
    // A quarter turn, counter-clockwise as seen: (x, y) goes to (y, −x), above the picture.
    let turned = with(json!({"rotation": PI / 2.0}));
    assert_close(first(&turned), [0., 0., 0.125]);
    let clamped = turned
        .set("/samplers", json!([{"wrapS": 33071, "wrapT": 33071}]))
        .set("/textures/0/sampler", json!(0));
    assert_close(first(&clamped), [0.5, 0., 0.]);
}

#[test]
fn unreadable_picture_is_named() {
    let beside = textured_square(json!({"uri": "a.png"}), [0., 0.], [1., 1.]).glb();
    let folder = Folder::new().with("a.glb", &beside);
    let told = |folder: &Folder| folder.error("a.glb");
    let missing = "a.glb: material grey: image 0 a.png cannot be read: there is no such file";
    assert_eq!(told(&folder), missing);
    let bytes = picture_bytes();
    for (bytes, what) in [
        (&bytes[..bytes.len() - 20], "image a.png cannot be decoded"),
        (&b"GIF89a"[..], "image a.png is neither PNG, JPEG nor WebP"),
        (&b"\xff\xd8\xff\xe0"[..], "image a.png is cut off"),
    ] {
        folder.put("a.png", bytes);
        let error = told(&folder);
        assert!(error.starts_with(&format!("a.glb: material grey: {what}")), "{error}");
    }
    let outside = textured_square(json!({"bufferView": 9}), [0., 0.], [1., 1.]).error();
    assert!(outside.contains("image 0 uses buffer view 9"), "{outside}");
    let none = textured_square(embedded_image(), [0., 0.], [1., 1.])
        .set("/textures/0", json!({}))
        .error();
    assert!(none.contains("a texture has no image"), "{none}");
    // A replaced reflectance needs no texture.
    let options = ImportOptions {
        reflectance: Some(Vec3::splat(0.25)),
        ..Default::default()
    };
    let given = load_scene(&folder.path("a.glb"), &options).expect("a scene");
    assert_eq!(given.faces[0].reflectance, Vec3::splat(0.25));
}

#[test]
fn obj_texture_v_runs_upwards() {
    let text = text_lines(
        "mtllib a.mtl; S vt 0 0; vt 0.5 0; vt .5 .5; vt 0 .5; usemtl a; f 1/1 2/2 3/3 4/4; f 1/-4 2/-3 3/-2; \
         usemtl b; f 1/1 2/2 3/3 4/4; usemtl a; f 1 2 3;",
    );
    let materials = "newmtl a\nKd 0.5 0.5 0.5\nmap_Kd sub\\a b.png\n\
        newmtl b\nmap_Kd -bm 0.5 -o 0.5 0.5 -blendu on -clamp on -s 1 1 1 sub/a b.png\nKe 2 2 2\nmap_Ke sub/a b.png\n";
    let folder = Folder::new().with("a.obj", text).with("a.mtl", materials);
    std::fs::create_dir(folder.path("sub")).expect("a folder");
    folder.put("sub/a b.png", picture_bytes());
    let scene = folder.load("a.obj").expect("a scene");
    let found: Vec<_> = scene.faces.iter().map(|f| f.reflectance).collect();
    assert_close(found[0], [0., 0., 0.5]);
    assert_close(found[1], [0., 0., 0.5]);
    assert_close(found[2], [0., 0.95, 0.]);
    assert_close(found[3], [0.125; 3]);
    assert_close(scene.faces[2].emission / PI, [0., 0., 2.]);
    let lost = "textures on faces without coordinates are taken as their mean: materials a";
    assert_eq!(notes(&scene, lost), [lost]);
    assert_eq!(notes(&scene, "materials b reflect all light").len(), 1);
}
