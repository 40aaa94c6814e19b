//! `solve --error`: what it refuses, and what it writes.

use super::command::{failure, folder, radiosity};
use serde_json::{Value, json};
use std::fs;
use std::path::Path;

const BOX: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenes/cornell_box.obj");

#[test]
fn what_an_error_decides_cannot_be_given_beside_it() {
    let folder = folder("error-usage");
    let out = folder.join("out");
    let out = out.to_str().unwrap();
    let solve = ["solve", BOX, "--error", "1%", "--out", out];
    for option in [
        &["--quality", "normal"][..],
        &["--epsilon", "0.1"],
        &["--max-shots", "9"],
        &["--iteration", "cg"],
        &["--cells", "4"],
        &["--samples", "4"],
        &["--conserve"],
        &["--item-buffer", "512"],
        &["--lookup", "3x3"],
        &["--raster", "pixel"],
        &["--visibility", "hemicube"],
        &["--form-factor", "disc"],
        &["--solver", "gpu"],
        &["--solver", "matrix"],
        &["--adapter", "any"],
        &["--require-gpu"],
    ] {
        let (code, line) = failure(&[&solve[..], option].concat());
        assert_eq!(code, 2, "{option:?}: {line}");
        assert!(line.contains(option[0]), "{option:?}: {line}");
    }
    for error in ["0", "-1", "0.1%", "11%", "nan", "one"] {
        let (code, line) = failure(&["solve", BOX, "--error", error, "--out", out]);
        assert_eq!(code, 2, "{error}: {line}");
    }
    for command in ["compare", "plan"] {
        let (code, line) = failure(&[command, BOX, "--error", "1%"]);
        assert_eq!(code, 2, "{command}: {line}");
    }
    // 19 faces of 8192² texels.
    let (code, line) = failure(&[&solve[..], &["--texels", "8192"]].concat());
    assert_eq!(code, 2, "{line}");
    assert!(line.contains("fewer texels"), "{line}");
    assert!(!Path::new(out).exists(), "a refused solve wrote something");
}

#[test]
fn the_answer_says_what_was_asked_and_what_was_reached() {
    let folder = folder("error");
    let out = folder.join("out");
    let arguments = ["solve", BOX, "--error", "2 %", "--texels", "8", "--out"];
    let output = radiosity(&[&arguments[..], &[out.to_str().unwrap()]].concat());
    let text = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(0), "{text}");
    let file = fs::read(out.join("result.json")).unwrap();
    let result: Value = serde_json::from_slice(&file).unwrap();
    assert_eq!(result["solver"], "cpu");
    let settings =
        json!({"error": 0.02, "texels": 8, "visibility": "rays", "form-factor": "polygon"});
    assert_eq!(result["settings"], settings);
    let error = result["estimated_error"].as_f64().unwrap();
    assert!(error > 0.0 && error <= 0.02, "{error}");
    let changes = result["certificate"]["changes"].as_array().unwrap();
    assert_eq!(changes.last().unwrap().as_f64(), Some(error));
    assert_eq!(result["certificate"]["causes"][0]["cause"], "refinement");
    assert_eq!(result["converged"], true);
    assert!(result["shots"].as_u64().unwrap() > 0);
    // The account closes; a twentieth of the light finds no front through the open side.
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
