//! `solve --error`: the options it refuses, the result it writes.

use super::command::{empty_folder, exit_code_and_error, run_radiosity};
use exr::prelude::read_first_flat_layer_from_file;
use serde_json::{Value, json};
use std::fs;
use std::path::Path;

const BOX: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenes/cornell_box.obj");

#[test]
fn options_of_shooting_contradict_error_option() {
    let folder = empty_folder("error-usage");
    let out = folder.join("out");
    let out = out.to_str().unwrap();
    let solve = ["solve", BOX, "--error", "1%", "--out", out];
    for option in [
        &["--quality", "normal"][..],
        &["--epsilon", "0.1"],
        &["--max-shots", "9"],
        &["--iteration", "cg"],
        &["--patches", "4"],
        &["--samples", "4"],
        &["--conserve"],
        &["--item-buffer", "512"],
        &["--lookup", "3x3"],
        &["--raster", "pixel"],
        &["--visibility", "hemicube"],
        &["--form-factor", "disc"],
        &["--solver", "dense"],
        &["--adapter", "any"],
        &["--require-gpu"],
    ] {
        let (code, line) = exit_code_and_error(&[&solve[..], option].concat());
        assert_eq!(code, 2, "{option:?}: {line}");
        assert!(line.contains(option[0]), "{option:?}: {line}");
    }
    for error in ["0", "-1", "0.1%", "11%", "nan", "one"] {
        let (code, line) = exit_code_and_error(&["solve", BOX, "--error", error, "--out", out]);
        assert_eq!(code, 2, "{error}: {line}");
    }
    let (code, line) = exit_code_and_error(&["compare", BOX, "--error", "1%", "--patches", "2"]);
    assert!(code == 2 && line.contains("--patches"), "{line}");
    // 19 faces of 8192² texels.
    let (code, line) = exit_code_and_error(&[&solve[..], &["--texels", "8192"]].concat());
    assert_eq!(code, 2, "{line}");
    assert!(line.contains("would fit"), "{line}");
    assert!(!Path::new(out).exists(), "a refused solve wrote something");
}

#[test]
fn result_has_requested_and_estimated_error() {
    let folder = empty_folder("error");
    let out = folder.join("out");
    let arguments = ["solve", BOX, "--error", "2 %", "--texels", "8", "--out"];
    let output = run_radiosity(&[&arguments[..], &[out.to_str().unwrap()]].concat());
    let text = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(0), "{text}");
    let file = fs::read(out.join("result.json")).unwrap();
    let result: Value = serde_json::from_slice(&file).unwrap();
    assert_eq!(result["solver"], "cpu");
    let settings = json!({"error": 0.02, "texels": 8, "visibility": "rays", "form-factor": "polygon"});
    assert_eq!(result["settings"], settings);
    let error = result["estimated_error"].as_f64().unwrap();
    assert!(error > 0.0 && error <= 0.02, "{error}");
    let changes = result["certificate"]["changes"].as_array().unwrap();
    let causes = result["certificate"]["causes"].as_array().unwrap();
    let names: Vec<&Value> = causes.iter().map(|part| &part["cause"]).collect();
    let refined = ["sources", "visibility", "receivers", "propagation", "texels"];
    let rest = ["iteration", "closure", "rounding"];
    assert_eq!(names, [&refined[..], &rest].concat());
    let parts = causes.iter().map(|part| part["error"].as_f64().unwrap());
    let squares: Vec<f64> = parts.map(|part| part * part).collect();
    assert!((squares.iter().sum::<f64>().sqrt() / error - 1.0).abs() < 1e-12);
    // All causes of error occur in this box: shadows, gradients and texels.
    assert!(squares[..refined.len()].iter().all(|part| *part > 0.0));
    let change = changes.last().unwrap().as_f64().unwrap();
    let refined: f64 = squares[..refined.len()].iter().sum();
    assert!((refined.sqrt() / change - 1.0).abs() < 1e-12);
    assert_error_map_matches(change, &out, &result);
    assert_eq!(result["converged"], true);
    assert!(result["shots"].as_u64().unwrap() > 0);
    // The energy balances; a twentieth of the light escapes through the open side.
    let energy = &result["energy"];
    assert!(energy["imbalance"].as_f64().unwrap() < 1e-5, "{energy}");
    for c in 0..3 {
        let part = |name: &str| energy[name][c].as_f64().unwrap();
        assert!(part("escaped") > 0.05 * part("emitted"), "{energy}");
        assert!(part("closure").abs() < 0.02 * part("emitted"), "{energy}");
    }
    for face in result["faces"].as_array().unwrap() {
        assert_eq!(face["texels"], json!([8, 8]));
    }
}

/// Asserts that the error map, the worst channel of each texel, has at least the error of the worst channel of all, and
/// little more.
fn assert_error_map_matches(error: f64, out: &Path, result: &Value) {
    let plane = |file: &str, name: &str| {
        let image = read_first_flat_layer_from_file(out.join(file)).unwrap();
        let width = image.layer_data.size.width();
        let mut channels = image.layer_data.channel_data.list.into_iter();
        let channel = channels.find(|channel| channel.name.eq(name)).unwrap();
        let values: Vec<f32> = channel.sample_data.values_as_f32().collect();
        move |x: usize, y: usize| f64::from(values[y * width + x])
    };
    let map = plane("error.exr", "Y");
    let (mut off, mut light) = (0.0, [0.0; 3]);
    for face in result["faces"].as_array().unwrap() {
        let [x, y, w, h] = [0, 1, 2, 3].map(|k| face["rect"][k].as_u64().unwrap() as usize);
        let area = face["area"].as_f64().unwrap() / (w * h) as f64;
        for (i, j) in (0..w).flat_map(|i| (0..h).map(move |j| (x + i, y + j))) {
            assert!(map(i, j) >= 0.0);
            off += area * map(i, j).powi(2);
        }
        for (c, name) in ["R", "G", "B"].into_iter().enumerate() {
            let radiosity = plane("lightmap.exr", name);
            let emission = face["emission"][c].as_f64().unwrap();
            for (i, j) in (0..w).flat_map(|i| (0..h).map(move |j| (x + i, y + j))) {
                light[c] += area * (radiosity(i, j) - emission).powi(2);
            }
        }
    }
    let least = light.into_iter().fold(f64::INFINITY, f64::min);
    let most = light.into_iter().fold(0.0, f64::max);
    let [low, high] = [most, least].map(|light| (off / light).sqrt());
    assert!(low < 1.5 * error && error <= high, "{low} {error} {high}");
}

#[test]
fn gpu_solves_to_error() {
    let out = empty_folder("error-gpu").join("out");
    let solve = ["solve", BOX, "--solver", "gpu", "--error", "5%"];
    let rest = ["--texels", "4", "--out", out.to_str().unwrap()];
    let output = run_radiosity(&[&solve[..], &rest].concat());
    let text = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(0), "{text}");
    let file = fs::read(out.join("result.json")).unwrap();
    let result: Value = serde_json::from_slice(&file).unwrap();
    assert_eq!(result["solver"], "gpu");
    assert!(result["adapter"].is_string(), "{}", result["adapter"]);
    assert_eq!(result["settings"]["error"], 0.05);
    let error = result["estimated_error"].as_f64().unwrap();
    assert!(error > 0.0 && error <= 0.05, "{error}");
}

#[test]
fn error_map_of_earlier_solve_is_removed() {
    let out = empty_folder("error-stale").join("out");
    let quality = ["--solver", "cpu", "--texels", "4", "--out"];
    for (command, options, is_there) in [("solve", &[][..], true), ("shoot", &["--patches", "2"], false)] {
        let run = [&[command, BOX], &quality[..], &[out.to_str().unwrap()]].concat();
        let output = run_radiosity(&[&run[..], options].concat());
        assert_eq!(output.status.code(), Some(0));
        assert_eq!(out.join("error.exr").exists(), is_there);
    }
}

/// Runs `solve` or `shoot` on the box with these options; returns its settings and the texels of its faces.
fn solved_settings(command: &str, name: &str, options: &[&str]) -> (Value, Vec<u64>) {
    let out = empty_folder(name).join("out");
    let solve = [command, BOX, "--solver", "cpu", "--out"];
    let output = run_radiosity(&[&solve[..], &[out.to_str().unwrap()], options].concat());
    assert_eq!(output.status.code(), Some(0), "{options:?}");
    let file = fs::read(out.join("result.json")).unwrap();
    let result: Value = serde_json::from_slice(&file).unwrap();
    let faces = result["faces"].as_array().unwrap().iter();
    let sides = faces.map(|face| face["texels"][0].as_u64().unwrap());
    (result["settings"].clone(), sides.collect())
}

#[test]
fn solve_solves_to_error_and_shoot_shoots() {
    for (name, options, error) in [
        ("error-default", &[][..], 0.01),
        ("error-draft", &["--quality", "draft"], 0.05),
        ("error-texels", &["--texels", "4"], 0.01),
    ] {
        let (settings, sides) = solved_settings("solve", name, options);
        assert_eq!(settings["error"], error, "{options:?}");
        // Without --texels the solve chooses the texels.
        let asked = options.contains(&"--texels");
        let alike = sides.iter().all(|side| *side == sides[0]);
        assert_eq!(alike, asked, "{sides:?}");
        assert_eq!(settings["texels"].is_null(), !asked, "{settings}");
    }
    let shot = ["--patches", "2", "--texels", "4"];
    let (settings, _) = solved_settings("shoot", "error-patches", &shot);
    assert!(settings["error"].is_null() && settings["cells"] == 2);
}
