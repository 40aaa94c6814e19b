//! `diff` run as a program: figures calculated by hand, planted faults, bad input.

use super::command::TestFolder;
use approx::abs_diff_eq;
use common::mesh::Mesh;
use common::scene::{Face, Scene};
use common::settings::Settings;
use common::shooting::{SolveRun, initial_field};
use common::solution::write::encode_exr;
use common::solution::{PhaseSeconds, Solution};
use glam::{DVec3, Vec3, Vec3Swizzles};
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// Makes a floor of 1×1 and, above it, a lamp of 1×3.
fn floor_and_lamp() -> Scene {
    let p = |x: f64, z: f64, y: f64| DVec3::new(x, y, z);
    let floor = [p(0., 0., 0.), p(0., 1., 0.), p(1., 1., 0.), p(1., 0., 0.)];
    let lamp = [p(0., 0., 1.), p(1., 0., 1.), p(1., 3., 1.), p(0., 3., 1.)];
    let emission = Vec3::new(0.5, 0.0, 2.0);
    Scene {
        name: "two".into(),
        faces: vec![
            Face::quad("floor", floor, Vec3::ZERO, Vec3::splat(0.5)),
            Face::quad("lamp", lamp, emission, Vec3::splat(0.5)),
        ],
        ..Scene::default()
    }
}

/// Stores the scene with `reflected(face, place)` in each of n×n texels.
fn store_result(folder: &TestFolder, dir: &str, scene: &Scene, n: u32, reflected: impl Fn(u32, [f32; 2]) -> Vec3) {
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
            emitted: 1.0,
            converged: true,
            field,
            ..SolveRun::default()
        },
        open: None,
        texel_error: None,
        certificate: None,
        error: None,
        warnings: &[],
        notes: &[],
        seconds: PhaseSeconds::default(),
    };
    std::fs::create_dir_all(folder.path(dir)).unwrap();
    solution.write(&folder.path(dir)).unwrap();
}

/// Changes the channels of a result's lightmap, and removes the checksum of the old file.
pub fn rewrite_lightmap(folder: &TestFolder, dir: &str, change: impl FnOnce(&mut BTreeMap<String, Vec<f32>>)) {
    let name = format!("{dir}/lightmap.exr");
    let mut planes = folder.read_planes(&name);
    change(&mut planes.channels);
    let size = [planes.width, planes.height].map(|n| n as u32);
    let bytes = encode_exr(size, planes.channels.into_iter().collect()).unwrap();
    folder.write(&name, bytes);
    folder.change_json(&format!("{dir}/result.json"), |result| {
        result["lightmap_crc32"] = Value::Null
    });
}

/// Compares `a` with `b`; returns diff.json and the messages.
fn run_diff(folder: &TestFolder) -> (Value, String) {
    let end = folder.succeed("diff a b");
    (folder.read_json("out/diff.json"), end.stderr)
}

fn channel_numbers(value: &Value) -> [f64; 3] {
    [0, 1, 2].map(|c| value[c].as_f64().unwrap())
}

fn worst_rms(json: &Value) -> f64 {
    channel_numbers(&json["relative_rms"]).into_iter().fold(0.0, f64::max)
}

fn assert_close(a: f64, b: f64) {
    // The values are stored in 32 bits.
    assert!(abs_diff_eq!(a, b, epsilon = 1e-6), "{a} {b}");
}

#[test]
fn diff_of_two_faces_equals_hand_calculation() {
    let folder = TestFolder::new();
    // Floor (area 1): a = 3, 1, 2 against b = 1, 1, 4; lamp (area 3): a = b = 2, 1, 1.
    let lamp = Vec3::new(2.0, 1.0, 1.0);
    for (dir, floor) in [("a", Vec3::new(3.0, 1.0, 2.0)), ("b", Vec3::new(1.0, 1.0, 4.0))] {
        let value = |face: u32, _| if face == 0 { floor } else { lamp };
        store_result(&folder, dir, &floor_and_lamp(), 2, value);
    }
    let (json, _) = run_diff(&folder);
    let [r, g, b] = channel_numbers(&json["relative_rms"]);
    assert_close(r, (4.0f64 / 13.0).sqrt());
    assert_close(g, 0.0);
    assert_close(b, (4.0f64 / 19.0).sqrt());
    let [r, g, b] = channel_numbers(&json["bias"]);
    assert_close(r, 2.0 / 7.0);
    assert_close(g, 0.0);
    assert_close(b, -2.0 / 7.0);
    // rms(b) is √(13/4) in red, √(19/4) in blue.
    assert_close(json["max_relative"].as_f64().unwrap(), 2.0 / (13.0f64 / 4.0).sqrt());
    assert!(json["flip"].as_f64().unwrap() > 0.0);
    assert_eq!(json["faces"][0]["share"], 1.0);
    assert_eq!(json["faces"][1]["share"], 0.0);
    assert_eq!(json["identical"], false);
    let html = folder.read_text("out/diff.html");
    for wanted in ["floor", "lamp", "HDR-FLIP", "A − B"] {
        assert!(html.contains(wanted), "{wanted}");
    }
    assert!(!html.contains("http"), "the page needs the network");

    for (tolerance, code) in [("60%", 0), ("55 %", 1), ("55", 1), ("0%", 1)] {
        let end = folder.run_words(&["diff", "a", "b", "--tolerance", tolerance]);
        assert_eq!(end.code, Some(code), "{end}");
    }
    for wrong in ["-1%", "nan", "inf", "x"] {
        folder.fail_with(2, &format!("diff a b --tolerance={wrong}"), wrong);
    }
}

/// Returns reflected light without any symmetry.
fn uneven_light(face: u32, [x, y]: [f32; 2]) -> Vec3 {
    Vec3::new(1.0 + x + face as f32, 2.0 + x * y, 1.0 + 3.0 * y * y)
}

fn with_black_texel(face: u32, place: [f32; 2]) -> Vec3 {
    let black = face == 0 && place == [0.125; 2];
    if black { Vec3::ZERO } else { uneven_light(face, place) }
}

#[test]
fn diff_measures_planted_faults() {
    let folder = TestFolder::new();
    let scene = floor_and_lamp();
    store_result(&folder, "b", &scene, 4, uneven_light);
    type Fault = (&'static str, fn(u32, [f32; 2]) -> Vec3, f64);
    let faults: [Fault; 6] = [
        ("one per cent brighter", |f, p| uneven_light(f, p) * 1.01, 0.009),
        ("red and blue swapped", |f, p| uneven_light(f, p).zyx(), 0.1),
        ("transposed", |f, [x, y]| uneven_light(f, [y, x]), 0.05),
        ("faces swapped", |f, p| uneven_light(1 - f, p), 0.1),
        ("upside down", |f, [x, y]| uneven_light(f, [x, 1.0 - y]), 0.1),
        ("one texel black", with_black_texel, 0.05),
    ];
    for (name, fault, least) in faults {
        store_result(&folder, "a", &scene, 4, fault);
        let (json, text) = run_diff(&folder);
        assert!(worst_rms(&json) > least, "{name}: {json}");
        assert!(!text.contains("same data"), "{name}: {text}");
    }
    let mut brighter = scene.clone();
    brighter.faces[1].emission *= 2.0;
    store_result(&folder, "a", &brighter, 4, uneven_light);
    let (json, text) = run_diff(&folder);
    assert!(text.contains("1 faces emit differently"), "{text}");
    assert_close(channel_numbers(&json["relative_rms"])[2], 0.0);
}

#[test]
fn diff_of_identical_data_is_noted() {
    let folder = TestFolder::new();
    for dir in ["a", "b"] {
        store_result(&folder, dir, &floor_and_lamp(), 3, uneven_light);
    }
    for (line, how) in [("diff a a", "one directory"), ("diff a b", "bit for bit")] {
        let text = folder.succeed(line).stderr;
        assert!(text.contains("note: A and B are the same data"), "{text}");
        assert!(text.contains(how), "{text}");
        let json = folder.read_json("out/diff.json");
        assert_eq!(json["identical"], true);
        assert_eq!(json["flip"], 0.0);
    }
    // Equal radiosity with different emission is different reflected light.
    folder.change_json("b/result.json", |result| {
        result["faces"][0]["emission"] = json!([0.125, 0.25, 0.5]);
    });
    let (json, text) = run_diff(&folder);
    assert!(!text.contains("same data"), "{text}");
    assert_eq!(json["identical"], false);
}

#[test]
fn diff_resamples_other_resolutions() {
    let folder = TestFolder::new();
    let mut scene = floor_and_lamp();
    let c = scene.faces[0].corners;
    // A quad of unequal texels, and a triangle.
    scene.faces[0].corners = [c[0], c[1], c[2], DVec3::new(0.5, 0.0, 0.2)];
    let triangle = Face::triangle("t", [c[0], c[2], DVec3::new(3.0, 0.0, 0.0)], Vec3::ZERO, Vec3::ZERO);
    scene.faces.push(triangle);
    let even = |_: u32, _: [f32; 2]| Vec3::new(1.0, 2.0, 3.0);
    for (n, m, cut) in [
        (4, 2, false),
        (2, 4, false),
        (6, 4, false),
        (5, 7, true),
        (15, 16, true),
    ] {
        // A uniform field is the same at any resolution.
        store_result(&folder, "a", &scene, n, even);
        store_result(&folder, "b", &scene, m, even);
        let (json, text) = run_diff(&folder);
        for figure in ["relative_rms", "bias"] {
            channel_numbers(&json[figure])
                .into_iter()
                .for_each(|x| assert_close(x, 0.0));
        }
        assert_eq!(text.contains("were cut"), cut, "{n} {m}: {text}");
        assert!(!text.contains("same data"));
        // Another field differs by less than its variation within a texel.
        store_result(&folder, "a", &scene, n, uneven_light);
        store_result(&folder, "b", &scene, m, uneven_light);
        let worst = worst_rms(&run_diff(&folder).0);
        assert!(worst > 0.0 && worst < 0.25, "{n} {m}: {worst}");
    }
}

#[test]
fn standard_error_of_truth_is_reported_and_other_channels_are_optional() {
    let folder = TestFolder::new();
    let scene = floor_and_lamp();
    store_result(&folder, "a", &scene, 2, |_, _| Vec3::splat(2.1));
    store_result(&folder, "b", &scene, 4, |_, _| Vec3::splat(2.0));
    rewrite_lightmap(&folder, "b", |channels| {
        channels.retain(|name, _| !name.contains('.'));
        let count = channels["R"].len();
        channels.extend(["R", "G", "B"].map(|letter| (format!("error.{letter}"), vec![0.1; count])));
    });
    let (json, _) = run_diff(&folder);
    // Each texel of the comparison is the mean of four texels of the truth.
    for x in channel_numbers(&json["standard_error"]) {
        assert_close(x, 0.1 / 2.0 / 2.0);
    }
    assert_close(channel_numbers(&json["bias"])[0], 0.05);
}

#[test]
fn incomparable_results_are_refused() {
    let folder = TestFolder::new();
    let scene = floor_and_lamp();
    let changed = |change: &dyn Fn(&mut Scene)| {
        let mut other = scene.clone();
        change(&mut other);
        other
    };
    let c = scene.faces[0].corners;
    let triangle = Face::triangle("t", [c[0], c[1], c[2]], Vec3::ZERO, Vec3::ZERO);
    for (dir, scene) in [
        ("b", scene.clone()),
        ("less", changed(&|scene| scene.faces.truncate(1))),
        ("moved", changed(&|scene| scene.faces[1].corners[2].x += 1e-3)),
        ("triangle", changed(&|scene| scene.faces[0] = triangle.clone())),
        ("colourless", scene.clone()),
        ("cut", scene.clone()),
        ("faceless", scene.clone()),
    ] {
        store_result(&folder, dir, &scene, 2, uneven_light);
    }
    rewrite_lightmap(&folder, "colourless", |channels| drop(channels.remove("G")));
    let bytes = folder.read("cut/lightmap.exr");
    folder.write("cut/lightmap.exr", &bytes[..bytes.len() / 2]);
    folder.write("faceless/result.json", "{}");
    folder.assert_refused(
        "diff nothing b => result.json
         diff less b => 1 faces
         diff moved b => face 1: its corner 2
         diff moved b => not the same scene
         diff triangle b => face 0
         diff triangle b => triangle
         diff colourless b => lightmap.exr: lacks a channel
         diff cut b => lightmap.exr
         diff faceless b => result.json",
    );
    // Rounded corners and other names are the same scene.
    let renamed = changed(&|scene| {
        scene.faces[1].corners[2].x += 1e-5;
        scene.faces[1].name = "light".into();
    });
    store_result(&folder, "a", &renamed, 2, uneven_light);
    run_diff(&folder);
}
