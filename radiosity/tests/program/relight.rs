//! `relight` run as a program: rooms of every kind, the files it writes, the input it refuses.

use super::command::{empty_folder, exit_code_and_error, run_radiosity};
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};

/// Writes a closed room of six quads, the ceiling a lamp, and a cube to put into it.
fn write_room_and_object(folder: &Path) -> (String, String) {
    let cube = |low: f64, high: f64, inward: bool| {
        let mut text = String::new();
        for k in 0..8 {
            let at = |bit: usize| if k >> bit & 1 == 1 { high } else { low };
            text += &format!("v {} {} {}\n", at(0), at(1), at(2));
        }
        let quads = [
            [1, 5, 6, 2],
            [3, 4, 8, 7],
            [1, 3, 7, 5],
            [2, 6, 8, 4],
            [1, 2, 4, 3],
            [5, 7, 8, 6],
        ];
        for (k, quad) in quads.into_iter().enumerate() {
            text += if k == 1 && inward {
                "usemtl lamp\n"
            } else {
                "usemtl wall\n"
            };
            let [a, b, c, d] = if inward {
                quad
            } else {
                [quad[3], quad[2], quad[1], quad[0]]
            };
            text += &format!("f {a} {b} {c} {d}\n");
        }
        text
    };
    let mtl = "newmtl wall\nKd .6 .5 .4\nnewmtl lamp\nKd .5 .5 .5\nKe 1 1 1\n";
    fs::write(folder.join("m.mtl"), mtl).unwrap();
    let write = |name: &str, text: String| {
        let path = folder.join(name);
        fs::write(&path, format!("mtllib m.mtl\n{text}")).unwrap();
        path.to_str().unwrap().to_owned()
    };
    (
        write("room.obj", cube(0.0, 1.0, true)),
        write("object.obj", cube(-0.1, 0.1, false)),
    )
}

fn read_json(path: PathBuf) -> Value {
    serde_json::from_slice(&fs::read(path).unwrap()).unwrap()
}

#[test]
fn relight_writes_files_of_contract() {
    let folder = empty_folder("relight");
    let (room, object) = write_room_and_object(&folder);
    let solved = folder.join("solved");
    let solved = solved.to_str().unwrap();
    // Given patches and samples make all three rooms shoot alike.
    let quality = ["--texels", "4", "--quiet", "--solver", "cpu"];
    let links = ["--patches", "4", "--samples", "4"];
    let run = |arguments: &[&str]| {
        let output = run_radiosity(&[arguments, &quality, &links].concat());
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success(), "{arguments:?}: {text}");
    };
    run(&["shoot", &room, "--maps", "--out", solved]);
    let maps = format!("{solved}/maps");
    let mut answers = Vec::new();
    for (k, from) in [room.as_str(), solved, &maps].into_iter().enumerate() {
        let out = folder.join(format!("out{k}"));
        run(&[
            "relight",
            "--room",
            from,
            "--object",
            &object,
            "--place",
            "0.5,0.4,0.5",
            "--object",
            &object,
            "--scale",
            "0.5",
            "--place",
            "0.2,0.2,0.2",
            "--reflectance",
            "0,0,0",
            "--out",
            out.to_str().unwrap(),
        ]);
        for file in [
            "lightmap.exr",
            "composite.exr",
            "background.exr",
            "composite.png",
            "report.html",
        ] {
            assert!(fs::metadata(out.join(file)).unwrap().len() > 0, "{file}");
        }
        let result = read_json(out.join("result.json"));
        assert_eq!(result["method"], "signed");
        assert_eq!(result["negative_texels"], 0);
        assert!(result["map_shots"].as_u64().unwrap() > 0 && result["object_shots"].as_u64().unwrap() > 0);
        assert_eq!(result["faces"].as_array().unwrap().len(), 18);
        assert_eq!(result["faces"][12]["reflectance"], serde_json::json!([0.0, 0.0, 0.0]));
        assert!(result["energy"]["imbalance"].as_f64().unwrap() < 1e-4);
        answers.push(out);
    }
    // The same room in three forms: the files of a solve lose nothing, its maps only the unshot power.
    for (other, bound) in [(&answers[1], 1e-6), (&answers[2], 2e-3)] {
        let out = folder.join("diff");
        let paths = [other, &answers[0], &out].map(|p| p.to_str().unwrap().to_owned());
        let output = run_radiosity(&["diff", &paths[0], &paths[1], "--out", &paths[2], "--quiet"]);
        assert!(output.status.success());
        let diff = read_json(out.join("diff.json"));
        for channel in diff["relative_rms"].as_array().unwrap() {
            assert!(channel.as_f64().unwrap() <= bound, "{diff}");
        }
    }
    // Without an object the captured radiosity and the background are unchanged bit for bit.
    let out = folder.join("null");
    run(&["relight", "--room", solved, "--out", out.to_str().unwrap()]);
    assert_eq!(
        fs::read(out.join("composite.exr")).unwrap(),
        fs::read(out.join("background.exr")).unwrap()
    );
    assert_eq!(read_json(out.join("result.json"))["object_shots"], 0);
}

/// Writes a lat-long map, bright above and dim below, as a Radiance picture of plain pixels: mantissa, exponent 128 + 1,
/// so that a channel is its byte / 128.
fn write_panorama(path: &Path) {
    let (width, height) = (64, 32);
    let mut bytes = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n").into_bytes();
    for row in 0..height {
        let pixel = if row < 6 {
            [255, 240, 220, 131]
        } else {
            [64, 60, 56, 128]
        };
        bytes.extend(pixel.repeat(width));
    }
    fs::write(path, bytes).unwrap();
}

#[test]
fn panorama_lights_object_and_receives_its_shadow() {
    let folder = empty_folder("panorama");
    let (_, object) = write_room_and_object(&folder);
    let map = folder.join("room.hdr");
    write_panorama(&map);
    let map = map.to_str().unwrap();
    let run = |name: &str, objects: &[&str]| {
        let out = folder.join(name);
        let room = [
            "relight",
            "--room",
            map,
            "--room-size",
            "4,3,4",
            "--texels",
            "4",
            "--quiet",
            "--solver",
            "cpu",
            "--out",
            out.to_str().unwrap(),
        ];
        let output = run_radiosity(&[&room[..], objects].concat());
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success(), "{text}");
        out
    };
    // The object half a metre above the floor shadows it and receives the lamp's light.
    let place = ["--object", object.as_str(), "--scale", "4", "--place", "0,0.9,0"];
    let out = run("object", &place);
    let result = read_json(out.join("result.json"));
    assert_eq!(result["method"], "signed");
    assert_eq!(result["faces"].as_array().unwrap().len(), 12);
    assert_eq!(result["negative_texels"], 0);
    assert!(result["map_shots"].as_u64().unwrap() > 0 && result["object_shots"].as_u64().unwrap() > 0);
    assert!(result["energy"]["imbalance"].as_f64().unwrap() < 1e-4);
    let empty = run("empty", &[]);
    let [with, without] = [&out, &empty].map(|folder| floor_radiosity(folder));
    assert!(
        with > 0.0 && with < 0.99 * without,
        "{with} with the object, {without} without"
    );
    let bytes = |folder: &Path, name: &str| fs::read(folder.join(name)).unwrap();
    assert_ne!(bytes(&out, "composite.exr"), bytes(&out, "background.exr"));
    assert_eq!(bytes(&empty, "composite.exr"), bytes(&empty, "background.exr"));
    fs::remove_dir_all(folder).unwrap();
}

/// Returns the red radiosity of the room's floor, summed over its texels.
fn floor_radiosity(folder: &Path) -> f64 {
    let result = read_json(folder.join("result.json"));
    let faces = result["faces"].as_array().unwrap();
    let lies = |face: &&Value| {
        face["corners"]
            .as_array()
            .unwrap()
            .iter()
            .all(|c| c[1].as_f64() == Some(0.0))
    };
    let rect: Vec<usize> = faces.iter().find(lies).unwrap()["rect"]
        .as_array()
        .unwrap()
        .iter()
        .map(|x| x.as_u64().unwrap() as usize)
        .collect();
    let image = exr::prelude::read_first_flat_layer_from_file(folder.join("lightmap.exr")).unwrap();
    let layer = &image.layer_data;
    let red = layer.channel_data.list.iter().find(|c| c.name.eq("R")).unwrap();
    let values: Vec<f32> = red.sample_data.values_as_f32().collect();
    let width = layer.size.x();
    let row = |y: usize| values[y * width + rect[0]..y * width + rect[0] + rect[2]].iter();
    (rect[1]..rect[1] + rect[3]).flat_map(row).map(|b| f64::from(*b)).sum()
}

/// Files that a relight writes.
const OUTPUTS: [&str; 6] = [
    "lightmap.exr",
    "result.json",
    "composite.exr",
    "background.exr",
    "composite.png",
    "report.html",
];

#[test]
fn relight_to_error_replaces_old_files() {
    let folder = empty_folder("relight-error");
    let (room, object) = write_room_and_object(&folder);
    let run = |name: &str, options: &[&str]| {
        let out = folder.join(name);
        fs::create_dir_all(&out).unwrap();
        for file in OUTPUTS {
            fs::write(out.join(file), b"poison").unwrap();
        }
        let room = ["relight", "--room", &room, "--object", &object, "--quiet"];
        let place = ["--place", "0.5,0.4,0.5", "--out", out.to_str().unwrap()];
        let output = run_radiosity(&[&room[..], &place, options].concat());
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success(), "{text}");
        for file in OUTPUTS {
            let bytes = fs::read(out.join(file)).unwrap();
            assert!(bytes.len() > 100, "{file} is as it was");
        }
        out
    };
    let out = run("out", &["--error", "2%"]);
    let result = read_json(out.join("result.json"));
    assert_eq!(result["method"], "signed");
    assert_eq!(result["settings"]["error"], 0.02);
    let error = result["estimated_error"].as_f64().unwrap();
    assert!(error > 0.0 && error <= 0.02, "{error}");
    assert_eq!(result["negative_texels"], 0);
    assert_eq!(result["exposure"]["curve"], "filmic");
    // Two stops and another tone curve change the PNG and not the radiance.
    let bright = ["--error", "2%", "--exposure", "2", "--curve", "linear"];
    let other = run("bright", &bright);
    let bytes = |folder: &Path, name: &str| fs::read(folder.join(name)).unwrap();
    for file in ["composite.exr", "background.exr", "lightmap.exr"] {
        assert_eq!(bytes(&out, file), bytes(&other, file), "{file}");
    }
    assert_ne!(bytes(&out, "composite.png"), bytes(&other, "composite.png"));
    let white = |result: &Value| result["exposure"]["white"].as_f64().unwrap();
    let brighter = read_json(other.join("result.json"));
    assert!((white(&brighter) * 4.0 / white(&result) - 1.0).abs() < 1e-6);
    assert_eq!(brighter["exposure"]["curve"], "linear");
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn bad_relight_input_is_one_error_line_and_code_2() {
    let folder = empty_folder("relight-bad");
    let (room, object) = write_room_and_object(&folder);
    let out = folder.join("out");
    let out = out.to_str().unwrap();
    let broken = folder.join("broken");
    fs::write(&broken, b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 8\n").unwrap();
    let broken = broken.to_str().unwrap();
    for (arguments, says) in [
        (vec!["--room", &room, "--object", "/nowhere.obj"], "nowhere"),
        (vec!["--room", "/nowhere.hdr", "--object", &object], "nowhere"),
        (vec!["--room", broken, "--object", &object], "--room-size"),
        (
            vec!["--room", broken, "--room-size", "1,1,1", "--object", &object],
            "broken",
        ),
        (
            vec!["--room", broken, "--room-size", "1,0,1", "--object", &object],
            "--room-size",
        ),
        (
            vec!["--room", &room, "--room-size", "1,1,1", "--object", &object],
            "room.obj",
        ),
        (vec!["--room", &room, "--scale", "2", "--object", &object], "--scale"),
        (vec!["--room", &room, "--object", &object, "--place", "1,2"], "1,2"),
        (
            vec!["--room", &room, "--object", &object, "--reflectance", "1,1,1"],
            "1,1,1",
        ),
        (
            vec!["--room", &room, "--object", &object, "--mend", "bleeding"],
            "--mend",
        ),
        (
            vec!["--room", &room, "--object", &object, "--exposure", "nan"],
            "--exposure",
        ),
        (vec!["--room", &room, "--object", &object, "--conserve"], "--conserve"),
        (
            vec!["--room", &room, "--object", &object, "--solver", "dense"],
            "--solver",
        ),
        (
            vec!["--room", &room, "--object", &object, "--camera", "0,0,0,0,0,0,50"],
            "camera",
        ),
    ] {
        let (code, line) = exit_code_and_error(&[vec!["relight", "--out", out], arguments].concat());
        assert_eq!(code, 2, "{line}");
        assert!(line.contains(says), "{line} does not say {says}");
        assert!(!Path::new(out).exists(), "{line}: something was written");
    }
}
