//! `check`: the error of a stored result.

use super::command::{empty_folder, exit_code_and_error, run_radiosity};
use serde_json::Value;
use std::fs;
use std::path::Path;

const BOX: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenes/cornell_box.obj");
const ROOM: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenes/paper_room.obj");

fn read_json(file: &Path) -> Value {
    serde_json::from_slice(&fs::read(file).unwrap()).unwrap()
}

/// Runs `solve` or `shoot` on the box into `out`.
fn solve_into(command: &str, out: &Path, options: &[&str]) {
    let solve = [command, BOX, "--solver", "cpu", "--texels", "8", "--out"];
    let output = run_radiosity(&[&solve[..], &[out.to_str().unwrap()], options].concat());
    assert_eq!(output.status.code(), Some(0), "{options:?}");
}

/// Runs `check` on a result; returns its JSON and exit code.
fn run_check(result: &Path, out: &Path, options: &[&str]) -> (Value, Option<i32>) {
    let check = ["check", result.to_str().unwrap(), "--out"];
    let output = run_radiosity(&[&check[..], &[out.to_str().unwrap()], options].concat());
    assert!(fs::read_to_string(out.join("check.html")).unwrap().len() > 10_000);
    (read_json(&out.join("check.json")), output.status.code())
}

#[test]
fn check_estimates_error_of_crude_and_good_result() {
    let folder = empty_folder("check");
    let [crude, good, out] = ["crude", "good", "out"].map(|name| folder.join(name));
    solve_into("shoot", &crude, &["--patches", "1", "--samples", "1"]);
    solve_into("solve", &good, &["--error", "0.5%"]);
    let [crude_path, good_path] = [&crude, &good].map(|path| path.to_str().unwrap());
    let diff = ["diff", crude_path, good_path, "--out", out.to_str().unwrap()];
    assert_eq!(run_radiosity(&diff).status.code(), Some(0));
    let shares = read_json(&out.join("diff.json"));
    let shares = shares["relative_rms"].as_array().unwrap().iter();
    let known = shares.map(|x| x.as_f64().unwrap()).fold(0.0, f64::max);

    let (found, code) = run_check(&crude, &out, &["--tolerance", "5%"]);
    let error = found["estimated_error"].as_f64().unwrap();
    // The two estimates are from different methods, each accurate to half a per cent.
    assert!(known > 0.1 && (error - known).abs() <= 0.01, "{error} {known}");
    assert!(found["one_bounce"].as_f64().unwrap() > 0.05);
    assert_eq!(code, Some(1));
    let worst = found["faces"].as_array().unwrap().iter();
    assert!(worst.map(|face| face["share"].as_f64().unwrap()).sum::<f64>() > 0.999);

    let (found, code) = run_check(&good, &out, &["--scene", BOX, "--tolerance", "1%"]);
    let error = found["estimated_error"].as_f64().unwrap();
    assert!(error > 0.0 && error <= 0.01, "{error}");
    assert_eq!(code, Some(0));
    let energy = &found["energy"];
    assert!(energy["imbalance"].as_f64().unwrap() < 1e-5, "{energy}");
}

#[test]
fn results_that_cannot_be_judged_are_refused() {
    let folder = empty_folder("check-refused");
    let result = folder.join("result");
    let out = folder.join("out");
    let out = out.to_str().unwrap();
    let (code, line) = exit_code_and_error(&["check", result.to_str().unwrap(), "--out", out]);
    assert_eq!(code, 2, "{line}");
    solve_into("solve", &result, &["--quality", "draft"]);
    let check = ["check", result.to_str().unwrap(), "--out", out];
    let (code, line) = exit_code_and_error(&[&check[..], &["--scene", ROOM]].concat());
    assert_eq!(code, 2, "{line}");
    assert!(line.contains("156 faces"), "{line}");
    // The reflectance is missing.
    let file = result.join("result.json");
    let mut stored = read_json(&file);
    for face in stored["faces"].as_array_mut().unwrap() {
        face.as_object_mut().unwrap().remove("reflectance");
    }
    fs::write(&file, stored.to_string()).unwrap();
    let (code, line) = exit_code_and_error(&check);
    assert_eq!(code, 2, "{line}");
    assert!(line.contains("--scene"), "{line}");
    let (_, code) = run_check(&result, Path::new(out), &["--scene", BOX]);
    assert_eq!(code, Some(0));
}
