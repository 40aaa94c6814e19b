//! `diff` run as a program: figures calculated by hand, planted faults, bad input.

use approx::abs_diff_eq;
use common::mesh::Mesh;
use common::scene::{Face, Scene};
use common::settings::Settings;
use common::shooting::{SolveRun, initial_field};
use common::solution::{PhaseSeconds, Solution};
use exr::prelude::{FlatSamples, ReadChannels, ReadLayers, WritableImage, read};
use glam::{DVec3, Vec3, Vec3Swizzles};
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

const EMISSION: Vec3 = Vec3::new(0.5, 0.0, 2.0);

fn empty_folder(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("diff-{}-{name}", std::process::id()));
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    folder
}

/// Makes a floor of 1×1 and, above it, a lamp of 1×3.
fn floor_and_lamp() -> Scene {
    let p = |x: f64, z: f64, y: f64| DVec3::new(x, y, z);
    let floor = [p(0., 0., 0.), p(0., 1., 0.), p(1., 1., 0.), p(1., 0., 0.)];
    let lamp = [p(0., 0., 1.), p(1., 0., 1.), p(1., 3., 1.), p(0., 3., 1.)];
    Scene {
        name: "two".into(),
        faces: vec![
            Face::quad("floor", floor, Vec3::ZERO, Vec3::splat(0.5)),
            Face::quad("lamp", lamp, EMISSION, Vec3::splat(0.5)),
        ],
        notes: Vec::new(),
    }
}

/// Stores the scene with `reflected(face, place)` in each of n×n texels.
fn store_result(dir: &Path, scene: &Scene, n: u32, reflected: impl Fn(u32, [f32; 2]) -> Vec3) -> String {
    fs::create_dir_all(dir).unwrap();
    let mesh = Mesh::uniform(scene, n, 1).unwrap();
    let mut field = initial_field(&mesh, "by hand");
    for (texel, radiosity) in mesh.texels.iter().zip(&mut field.radiosity) {
        let place = [texel.index % n, texel.index / n].map(|i| (i as f32 + 0.5) / n as f32);
        *radiosity = (texel.emission + reflected(texel.face, place)).extend(0.0);
    }
    let solution = Solution {
        matrix: None,
        relit: None,
        scene,
        mesh: &mesh,
        solver: "cpu",
        adapter: None,
        settings: &Settings::default(),
        run: &SolveRun {
            shots: Vec::new(),
            emitted: 1.0,
            converged: true,
            stagnated: false,
            passes: 0,
            shooters: 0,
            field,
        },
        texel_error: None,
        certificate: None,
        error: None,
        warnings: &[],
        notes: &[],
        seconds: PhaseSeconds::default(),
    };
    solution.write(dir).unwrap();
    dir.to_str().unwrap().to_owned()
}

fn run_radiosity(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_radiosity"))
        .args(arguments)
        .output()
        .unwrap()
}

/// Runs `diff`; returns exit code, diff.json and stderr.
fn run_diff(a: &str, b: &str, more: &[&str]) -> (i32, Value, String) {
    let out = Path::new(a).join("diff");
    let output = run_radiosity(&[&["diff", a, b, "--out", out.to_str().unwrap()], more].concat());
    let text = String::from_utf8(output.stderr).unwrap();
    let json = fs::read(out.join("diff.json"))
        .map(|bytes| serde_json::from_slice(&bytes).unwrap())
        .unwrap_or_default();
    (output.status.code().unwrap(), json, text)
}

fn channel_numbers(value: &Value) -> [f64; 3] {
    [0, 1, 2].map(|c| value[c].as_f64().unwrap())
}

fn assert_close(a: f64, b: f64) {
    // The values are stored in 32 bits.
    assert!(abs_diff_eq!(a, b, epsilon = 1e-6), "{a} {b}");
}

#[test]
fn diff_of_two_faces_equals_hand_calculation() {
    let dir = empty_folder("hand");
    // Floor (area 1): a = 3, 1, 2 against b = 1, 1, 4; lamp (area 3): a = b = 2, 1, 1.
    let lamp = Vec3::new(2.0, 1.0, 1.0);
    let value = |floor: Vec3| move |face: u32, _: [f32; 2]| if face == 0 { floor } else { lamp };
    let scene = floor_and_lamp();
    let a = store_result(&dir.join("a"), &scene, 2, value(Vec3::new(3.0, 1.0, 2.0)));
    let b = store_result(&dir.join("b"), &scene, 2, value(Vec3::new(1.0, 1.0, 4.0)));
    let (code, json, text) = run_diff(&a, &b, &[]);
    assert_eq!(code, 0, "{text}");
    let [r, g, b_] = channel_numbers(&json["relative_rms"]);
    assert_close(r, (4.0f64 / 13.0).sqrt());
    assert_close(g, 0.0);
    assert_close(b_, (4.0f64 / 19.0).sqrt());
    let [r, g, b_] = channel_numbers(&json["bias"]);
    assert_close(r, 2.0 / 7.0);
    assert_close(g, 0.0);
    assert_close(b_, -2.0 / 7.0);
    // rms(b) is √(13/4) in red, √(19/4) in blue.
    assert_close(json["max_relative"].as_f64().unwrap(), 2.0 / (13.0f64 / 4.0).sqrt());
    assert!(json["flip"].as_f64().unwrap() > 0.0);
    assert_eq!(json["faces"][0]["share"], 1.0);
    assert_eq!(json["faces"][1]["share"], 0.0);
    assert_eq!(json["identical"], false);
    let html = fs::read_to_string(Path::new(&a).join("diff/diff.html")).unwrap();
    for wanted in ["floor", "lamp", "HDR-FLIP", "A − B"] {
        assert!(html.contains(wanted), "{wanted}");
    }
    assert!(!html.contains("http"), "the page needs the network");

    for (tolerance, expected) in [("60%", 0), ("55 %", 1), ("55", 1), ("0%", 1)] {
        assert_eq!(run_diff(&a, &b, &["--tolerance", tolerance]).0, expected, "{tolerance}");
    }
    for wrong in ["-1%", "nan", "inf", "x"] {
        assert_eq!(run_diff(&a, &b, &["--tolerance", wrong]).0, 2, "{wrong}");
    }
}

/// Returns reflected light without any symmetry.
fn uneven_light(face: u32, [x, y]: [f32; 2]) -> Vec3 {
    Vec3::new(1.0 + x + face as f32, 2.0 + x * y, 1.0 + 3.0 * y * y)
}

#[test]
fn diff_measures_planted_faults() {
    let dir = empty_folder("planted");
    let scene = floor_and_lamp();
    let b = store_result(&dir.join("b"), &scene, 4, uneven_light);
    type Fault = (&'static str, fn(u32, [f32; 2]) -> Vec3, f64);
    let faults: [Fault; 6] = [
        ("one per cent brighter", |f, p| uneven_light(f, p) * 1.01, 0.009),
        ("red and blue swapped", |f, p| uneven_light(f, p).zyx(), 0.1),
        ("transposed", |f, [x, y]| uneven_light(f, [y, x]), 0.05),
        ("faces swapped", |f, p| uneven_light(1 - f, p), 0.1),
        ("upside down", |f, [x, y]| uneven_light(f, [x, 1.0 - y]), 0.1),
        (
            "one texel black",
            |f, p| {
                if f == 0 && p == [0.125; 2] {
                    Vec3::ZERO
                } else {
                    uneven_light(f, p)
                }
            },
            0.05,
        ),
    ];
    for (name, fault, least) in faults {
        let a = store_result(&dir.join("a"), &scene, 4, fault);
        let (code, json, text) = run_diff(&a, &b, &[]);
        assert_eq!(code, 0, "{name}: {text}");
        let worst = channel_numbers(&json["relative_rms"]).into_iter().fold(0.0, f64::max);
        assert!(worst > least, "{name}: {worst}");
        assert!(!text.contains("same data"), "{name}: {text}");
    }
    let mut brighter = scene.clone();
    brighter.faces[1].emission *= 2.0;
    let a = store_result(&dir.join("brighter"), &brighter, 4, uneven_light);
    let (_, json, text) = run_diff(&a, &b, &[]);
    assert!(text.contains("1 faces emit differently"), "{text}");
    assert_close(channel_numbers(&json["relative_rms"])[2], 0.0);
}

#[test]
fn diff_of_identical_data_is_noted() {
    let dir = empty_folder("same");
    let scene = floor_and_lamp();
    let a = store_result(&dir.join("a"), &scene, 3, uneven_light);
    let b = store_result(&dir.join("b"), &scene, 3, uneven_light);
    for (b, how) in [(&a, "one directory"), (&b, "bit for bit")] {
        let (code, json, text) = run_diff(&a, b, &[]);
        assert_eq!(code, 0);
        assert!(
            text.contains("note: A and B are the same data") && text.contains(how),
            "{text}"
        );
        assert_eq!(json["identical"], true);
        assert_eq!(json["flip"], 0.0);
    }
    // Equal radiosity with different emission is different reflected light.
    let path = Path::new(&b).join("result.json");
    let mut dim: Value = serde_json::from_slice(&fs::read(&path).unwrap()).unwrap();
    dim["faces"][0]["emission"] = serde_json::json!([0.125, 0.25, 0.5]);
    fs::write(&path, dim.to_string()).unwrap();
    let (_, json, text) = run_diff(&a, &b, &[]);
    assert!(!text.contains("same data"), "{text}");
    assert_eq!(json["identical"], false);
}

#[test]
fn diff_resamples_other_resolutions() {
    let dir = empty_folder("resolutions");
    let mut scene = floor_and_lamp();
    let c = scene.faces[0].corners;
    // A quad of unequal texels, and a triangle.
    scene.faces[0].corners = [c[0], c[1], c[2], DVec3::new(0.5, 0.0, 0.2)];
    let triangle = Face::triangle("t", [c[0], c[2], DVec3::new(3.0, 0.0, 0.0)], Vec3::ZERO, Vec3::ZERO);
    scene.faces.push(triangle);
    // A uniform field is the same at any resolution.
    let even = |_: u32, _: [f32; 2]| Vec3::new(1.0, 2.0, 3.0);
    for (n, m, cut) in [
        (4, 2, false),
        (2, 4, false),
        (6, 4, false),
        (5, 7, true),
        (15, 16, true),
    ] {
        let a = store_result(&dir.join("a"), &scene, n, even);
        let b = store_result(&dir.join("b"), &scene, m, even);
        let (code, json, text) = run_diff(&a, &b, &[]);
        assert_eq!(code, 0, "{text}");
        for x in channel_numbers(&json["relative_rms"])
            .into_iter()
            .chain(channel_numbers(&json["bias"]))
        {
            assert_close(x, 0.0);
        }
        assert_eq!(text.contains("were cut"), cut, "{n} {m}: {text}");
        assert!(!text.contains("same data"));
        // Another field differs by less than its variation within a texel.
        let b = store_result(&dir.join("b"), &scene, m, uneven_light);
        let a = store_result(&dir.join("a"), &scene, n, uneven_light);
        let worst = channel_numbers(&run_diff(&a, &b, &[]).1["relative_rms"])
            .into_iter()
            .fold(0.0, f64::max);
        assert!(worst > 0.0 && worst < 0.25, "{n} {m}: {worst}");
    }
}

/// Rewrites a lightmap's planes.
fn rewrite_lightmap(dir: &str, change: impl Fn(&mut Vec<(String, Vec<f32>)>)) {
    use exr::prelude::{AnyChannel, AnyChannels, Encoding, Image, Layer, LayerAttributes};
    let path = Path::new(dir).join("lightmap.exr");
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_file(&path)
        .unwrap();
    let layer = image.layer_data;
    let mut planes: Vec<(String, Vec<f32>)> = layer
        .channel_data
        .list
        .iter()
        .map(|c| (c.name.to_string(), c.sample_data.values_as_f32().collect()))
        .collect();
    change(&mut planes);
    let channels = planes
        .into_iter()
        .map(|(name, values)| AnyChannel::new(name.as_str(), FlatSamples::F32(values)));
    let layer = Layer::new(
        layer.size,
        LayerAttributes::default(),
        Encoding::FAST_LOSSLESS,
        AnyChannels::sort(channels.collect()),
    );
    Image::from_layer(layer).write().to_file(&path).unwrap();
    // The checksum of the old file is removed.
    let path = Path::new(dir).join("result.json");
    let mut result: Value = serde_json::from_slice(&fs::read(&path).unwrap()).unwrap();
    result["lightmap_crc32"] = Value::Null;
    fs::write(&path, result.to_string()).unwrap();
}

#[test]
fn standard_error_of_truth_is_reported_and_other_channels_are_optional() {
    let dir = empty_folder("error");
    let scene = floor_and_lamp();
    let even = |_: u32, _: [f32; 2]| Vec3::splat(2.0);
    let a = store_result(&dir.join("a"), &scene, 2, |_, _| Vec3::splat(2.1));
    let b = store_result(&dir.join("b"), &scene, 4, even);
    rewrite_lightmap(&b, |planes| {
        planes.retain(|(name, _)| !name.contains('.'));
        for letter in ["R", "G", "B"] {
            planes.push((format!("error.{letter}"), vec![0.1; planes[0].1.len()]));
        }
    });
    let (code, json, text) = run_diff(&a, &b, &[]);
    assert_eq!(code, 0, "{text}");
    // Each texel of the comparison is the mean of four texels of the truth.
    for x in channel_numbers(&json["standard_error"]) {
        assert_close(x, 0.1 / 2.0 / 2.0);
    }
    assert_close(channel_numbers(&json["bias"])[0], 0.05);
}

#[test]
fn incomparable_results_are_one_error_line_and_code_2() {
    let dir = empty_folder("bad");
    let scene = floor_and_lamp();
    let b = store_result(&dir.join("b"), &scene, 2, uneven_light);
    let a = dir.join("a");
    let refused = |name: &str, says: &[&str]| {
        let (code, _, text) = run_diff(a.to_str().unwrap(), &b, &[]);
        assert_eq!(code, 2, "{name}: {text}");
        assert_eq!(text.lines().count(), 1, "{name}: {text}");
        assert!(text.starts_with("error: "), "{name}: {text}");
        for part in says {
            assert!(text.contains(part), "{name}: {text}");
        }
        assert!(!a.join("diff").exists(), "{name}: something was written");
    };
    refused("nothing there", &["result.json"]);
    let mut other = scene.clone();
    other.faces.pop();
    store_result(&a, &other, 2, uneven_light);
    refused("a face less", &["1 faces", "2"]);
    other = scene.clone();
    other.faces[1].corners[2].x += 1e-3;
    store_result(&a, &other, 2, uneven_light);
    refused("a corner moved", &["face 1", "corner 2", "not the same scene"]);
    let c = scene.faces[0].corners;
    other.faces[0] = Face::triangle("t", [c[0], c[1], c[2]], Vec3::ZERO, Vec3::ZERO);
    store_result(&a, &other, 2, uneven_light);
    refused("a triangle", &["face 0", "triangle"]);

    store_result(&a, &scene, 2, uneven_light);
    rewrite_lightmap(a.to_str().unwrap(), |planes| planes[1].1[3] = f32::NAN);
    refused("not a number", &["lightmap.exr", "face 0", "not finite"]);
    store_result(&a, &scene, 2, uneven_light);
    rewrite_lightmap(a.to_str().unwrap(), |planes| planes.retain(|(name, _)| name != "G"));
    refused("no green", &["lightmap.exr", "lacks a channel"]);
    store_result(&a, &scene, 2, uneven_light);
    let bytes = fs::read(a.join("lightmap.exr")).unwrap();
    fs::write(a.join("lightmap.exr"), &bytes[..bytes.len() / 2]).unwrap();
    refused("cut short", &["lightmap.exr"]);
    store_result(&a, &scene, 2, uneven_light);
    fs::write(a.join("result.json"), "{}").unwrap();
    refused("no faces", &["result.json"]);

    // Rounded corners and other names are the same scene.
    other = scene.clone();
    other.faces[1].corners[2].x += 1e-5;
    other.faces[1].name = "light".into();
    store_result(&a, &other, 2, uneven_light);
    assert_eq!(run_diff(a.to_str().unwrap(), &b, &[]).0, 0);
}
