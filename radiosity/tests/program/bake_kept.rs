//! `solve --gltf --uv keep`: light baked on the scene's own charts.

use super::bake::read_glb;
use super::command::{empty_folder, exit_code_and_error, run_radiosity};
use exr::prelude::read_first_flat_layer_from_file;
use glam::{Vec2, Vec3};
use serde_json::json;
use std::fs;
use std::path::Path;

/// A triangle and its texture coordinates.
type Triangle = ([[f32; 3]; 3], [[f32; 2]; 3]);

/// A floor in two halves under a lamp. The charts of the halves are apart, and one of them is rotated.
const FLOOR: [Triangle; 4] = [
    (
        [[0., 0., 0.], [0., 0., 2.], [1., 0., 2.]],
        [[0.1, 0.1], [0.1, 0.5], [0.3, 0.5]],
    ),
    (
        [[0., 0., 0.], [1., 0., 2.], [1., 0., 0.]],
        [[0.1, 0.1], [0.3, 0.5], [0.3, 0.1]],
    ),
    (
        [[1., 0., 0.], [1., 0., 2.], [2., 0., 2.]],
        [[0.4, 0.3], [0.8, 0.3], [0.8, 0.1]],
    ),
    (
        [[1., 0., 0.], [2., 0., 2.], [2., 0., 0.]],
        [[0.4, 0.3], [0.8, 0.1], [0.4, 0.1]],
    ),
];
const LAMP: [Triangle; 1] = [(
    [[0.2, 1.5, 0.3], [1.0, 1.5, 0.3], [0.6, 1.5, 1.1]],
    [[0.1, 0.9], [0.3, 0.9], [0.2, 0.7]],
)];

/// Writes a glTF of a grey part and of an emitting one, with TEXCOORD_1 only if `charted`.
fn write_gltf(folder: &Path, parts: [(&str, &[Triangle]); 2], charted: bool) -> String {
    let (mut bytes, mut views, mut accessors, mut meshes) = (vec![], vec![], vec![], vec![]);
    let mut put = |floats: &mut dyn Iterator<Item = f32>, kind: &str, width: usize| {
        let from = bytes.len();
        bytes.extend(floats.flat_map(f32::to_le_bytes));
        let length = bytes.len() - from;
        views.push(json!({ "buffer": 0, "byteOffset": from, "byteLength": length }));
        accessors.push(json!({
            "bufferView": views.len() - 1, "componentType": 5126, "type": kind, "count": length / 4 / width,
        }));
        accessors.len() - 1
    };
    for (k, (name, triangles)) in parts.into_iter().enumerate() {
        let (corners, places): (Vec<_>, Vec<_>) = triangles.iter().copied().unzip();
        let mut attributes = json!({});
        attributes["POSITION"] = put(&mut corners.into_iter().flatten().flatten(), "VEC3", 3).into();
        if charted {
            attributes["TEXCOORD_1"] = put(&mut places.into_iter().flatten().flatten(), "VEC2", 2).into();
        }
        meshes.push(json!({ "name": name, "primitives": [{ "attributes": attributes, "material": k }] }));
    }
    let document = json!({
        "asset": { "version": "2.0" },
        "scenes": [{ "nodes": [0, 1] }], "scene": 0,
        "nodes": [{ "mesh": 0 }, { "mesh": 1 }],
        "meshes": meshes,
        "materials": [
            { "pbrMetallicRoughness": { "baseColorFactor": [0.6, 0.5, 0.4, 1] } },
            { "pbrMetallicRoughness": { "baseColorFactor": [0, 0, 0, 1] }, "emissiveFactor": [1, 1, 1] },
        ],
        "buffers": [{ "uri": "s.bin", "byteLength": bytes.len() }],
        "bufferViews": views, "accessors": accessors,
    });
    fs::write(folder.join("s.bin"), bytes).unwrap();
    let path = folder.join("s.gltf");
    fs::write(&path, document.to_string()).unwrap();
    path.to_str().unwrap().to_owned()
}

/// A baked scene, sampled like another program would.
struct Light {
    size: Vec2,
    pixels: Vec<Vec3>,
    triangles: Vec<[(Vec3, Vec2); 3]>,
}

impl Light {
    /// Solves and bakes; returns the messages as well.
    fn new(folder: &Path, scene: &str, name: &str, more: &[&str]) -> (Self, String) {
        let glb = folder.join(format!("{name}.glb"));
        let out = folder.join("out");
        let [glb, out] = [&glb, &out].map(|path| path.to_str().unwrap());
        let solve = [
            "solve", scene, "--solver", "cpu", "--error", "2%", "--texels", "8", "--out", out, "--gltf", glb,
        ];
        let output = run_radiosity(&[&solve[..], more].concat());
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(0), "{said}");
        let baked = read_glb(Path::new(glb));
        let light = read_first_flat_layer_from_file(glb.replace(".glb", ".exr"))
            .unwrap()
            .layer_data;
        let planes = ["R", "G", "B"].map(|name| {
            let plane = light.channel_data.list.iter().find(|c| c.name.eq(name)).unwrap();
            plane.sample_data.values_as_f32().collect::<Vec<f32>>()
        });
        let corners = baked
            .triangles
            .iter()
            .map(|triangle| triangle.map(|k| baked.corners[k]));
        let light = Self {
            size: Vec2::new(light.size.0 as f32, light.size.1 as f32),
            pixels: (0..planes[0].len())
                .map(|k| Vec3::new(planes[0][k], planes[1][k], planes[2][k]))
                .collect(),
            triangles: corners.collect(),
        };
        (light, said)
    }

    /// Samples the picture bilinearly.
    fn sample_picture(&self, uv: Vec2) -> Vec3 {
        let p = uv * self.size - 0.5;
        let share = p - p.floor();
        let pixel = |x: f32, y: f32| {
            let at = (p.floor() + Vec2::new(x, y)).clamp(Vec2::ZERO, self.size - 1.0);
            self.pixels[(at.y * self.size.x + at.x) as usize]
        };
        let row = |y: f32| pixel(0., y).lerp(pixel(1., y), share.x);
        row(0.).lerp(row(1.), share.y)
    }

    /// Samples the light of triangle `k` at a point.
    fn light_at(&self, k: usize, point: Vec3) -> Vec3 {
        let [(a, at_a), (b, at_b), (c, at_c)] = self.triangles[k];
        let normal = (b - a).cross(c - a);
        let share = |p: Vec3, q: Vec3| normal.dot((q - p).cross(point - p)) / normal.length_squared();
        self.sample_picture(at_a * share(b, c) + at_b * share(c, a) + at_c * share(a, b))
    }
}

#[test]
fn kept_charts_are_baked_without_seams() {
    let folder = empty_folder("bake-kept");
    let path = write_gltf(&folder, [("floor", &FLOOR), ("lamp", &LAMP)], true);
    let (kept, said) = Light::new(&folder, &path, "kept", &["--uv", "keep"]);
    let (packed, _) = Light::new(&folder, &path, "packed", &[]);
    assert!(!said.contains("pixels of the lightmap"), "{said}");
    for (k, (_, places)) in FLOOR.iter().chain(&LAMP).enumerate() {
        assert_eq!(kept.triangles[k].map(|(_, uv)| uv.to_array()), *places);
    }
    // The halves meet along the floor's middle, their triangles along two diagonals.
    let edges = [
        ([0, 1], [Vec3::ZERO, Vec3::new(1., 0., 2.)]),
        ([1, 2], [Vec3::X, Vec3::new(1., 0., 2.)]),
        ([2, 3], [Vec3::X, Vec3::new(2., 0., 2.)]),
    ];
    let brightest = (0..4)
        .map(|k| packed.light_at(k, Vec3::new(1., 0., 1.)).max_element())
        .fold(0.0, f32::max);
    let steps = edges.map(|([a, b], [from, to])| {
        let steps = (0..=200).map(|k| {
            let point = from.lerp(to, k as f32 / 200.0);
            (kept.light_at(a, point) - kept.light_at(b, point)).abs().max_element()
        });
        steps.fold(0.0, f32::max) / brightest
    });
    let inside = (0..2000).map(|k| {
        let [u, v] = [k % 50, k / 50].map(|n| (n as f32 + 0.5) / 50.0);
        let face = usize::from(u > v);
        let point = Vec3::new(u, 0., 2. * v);
        (kept.light_at(face, point) - packed.light_at(face, point))
            .abs()
            .max_element()
    });
    let off = inside.sum::<f32>() / 2000.0 / brightest;
    // The error of linear interpolation is the second difference of the light between texels, times the square of a pixel's
    // share of a texel, 1/3.2: an eighth of it in either direction between pixels, all of it where light is extrapolated
    // beside a chart; on both sides of an edge.
    let at = |i: i32, j: i32| {
        let place = Vec2::new(i as f32, j as f32) / 8.0;
        let point = Vec3::new(place.x, 0., 2. * place.y);
        packed.light_at(usize::from(place.x > place.y), point)
    };
    let bend = |[i, j]: [i32; 2], [k, l]: [i32; 2]| {
        let bend = at(i + k, j + l) + at(i - k, j - l) - 2. * at(i, j);
        bend.abs().max_element()
    };
    let within = (1..8).flat_map(|j| (1..8).map(move |i| [i, j]));
    let bends = within.map(|at| bend(at, [1, 0]).max(bend(at, [0, 1])));
    let bend = bends.fold(0.0, f32::max) / brightest;
    println!("steps {steps:?}, bend {bend}, off {off} in the mean");
    let lost = 2.0 * (2.0 / 8.0 + 1.0) / (3.2 * 3.2) * bend;
    assert_eq!(kept.size, Vec2::splat(128.0));
    assert!(steps.iter().all(|step| *step < lost), "{steps:?} {lost}");
    // Packed charts hold the corners of texels only: within a texel they are off by half the second difference.
    assert!(off < 0.5 * bend, "{off} {bend}");
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn unusable_charts_are_refused_before_solving() {
    let folder = empty_folder("bake-refused");
    let [glb, out] = ["b.glb", "out"].map(|name| folder.join(name).to_str().unwrap().to_owned());
    let refused = |floor: &[Triangle], charted: bool, more: &[&str]| {
        let path = write_gltf(&folder, [("floor", floor), ("lamp", &LAMP)], charted);
        let solve = ["solve", &path, "--out", &out, "--uv", "keep"];
        let (code, told) = exit_code_and_error(&[&solve[..], more].concat());
        assert_eq!(code, 2, "{told}");
        assert!(!Path::new(&out).exists() && !Path::new(&glb).exists(), "{told}");
        told
    };
    let bake = ["--gltf", &glb];
    let told = refused(&FLOOR, false, &bake);
    assert!(told.contains("mesh 0 primitive 0: has no TEXCOORD_1"), "{told}");
    let mut floor = FLOOR;
    floor[2].1 = floor[0].1;
    let told = refused(&floor, true, &bake);
    assert!(told.contains("face 3 (floor): lies on face 1 (floor)"), "{told}");
    floor[2].1[0] = [-0.5, 0.];
    let told = refused(&floor, true, &bake);
    assert!(told.contains("face 3 (floor): reaches (-0.500, 0.000)"), "{told}");
    let told = refused(&FLOOR, true, &[]);
    assert!(told.contains("--gltf"), "{told}");
    let told = refused(&FLOOR, true, &[&bake[..], &["--two-sided"]].concat());
    assert!(told.contains("leave --two-sided out"), "{told}");

    let obj = folder.join("s.obj");
    fs::write(&obj, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    let solve = ["solve", obj.to_str().unwrap(), "--out", &out, "--uv", "keep"];
    let (code, told) = exit_code_and_error(&[&solve[..], &bake].concat());
    assert!(code == 2 && told.contains("export as glTF"), "{told}");
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn charts_without_margin_are_noted() {
    let folder = empty_folder("bake-near");
    let mut floor = FLOOR;
    // The chart of the second half touches that of the first at an edge that they do not share.
    for (_, places) in &mut floor[2..] {
        *places = places.map(|[x, y]| [x - 0.1, y]);
    }
    let path = write_gltf(&folder, [("floor", &floor), ("lamp", &LAMP)], true);
    let (_, said) = Light::new(&folder, &path, "kept", &["--uv", "keep"]);
    assert!(
        said.contains(" of the 2048×2048 pixels of the lightmap lie between charts"),
        "{said}"
    );
    fs::remove_dir_all(folder).unwrap();
}
