//! `solve --error`: the result it writes.

use super::command::TestFolder;
use serde_json::{Value, json};

#[test]
fn result_has_requested_and_estimated_error() {
    let folder = TestFolder::new();
    let solve = ["solve", "scenes/cornell_box.obj", "--error", "2 %", "--texels", "8"];
    assert_eq!(folder.run_words(&solve).code, Some(0));
    let result = folder.read_json("out/result.json");
    assert_eq!(result["solver"], "cpu");
    let settings = json!({"error": 0.02, "texels": 8, "visibility": "rays", "form-factor": "polygon"});
    assert_eq!(result["settings"], settings);
    let error = result["estimated_error"].as_f64().unwrap();
    assert!(error > 0.0 && error <= 0.02, "{error}");
    let changes = result["certificate"]["changes"].as_array().unwrap();
    let causes = result["certificate"]["causes"].as_array().unwrap();
    let names: Vec<&Value> = causes.iter().map(|part| &part["cause"]).collect();
    assert_eq!(names, ["refinement", "noise", "iteration", "closure", "rounding"]);
    let parts = causes.iter().map(|part| part["error"].as_f64().unwrap());
    let squares: Vec<f64> = parts.map(|part| part * part).collect();
    assert!((squares.iter().sum::<f64>().sqrt() / error - 1.0).abs() < 1e-12);
    // Half of the squared error as if that of both steps was alike, half as if the first was independent and twice as large.
    assert_eq!(changes.len(), 1);
    let change = changes[0].as_f64().unwrap();
    let remaining = change * (0.5f64 * (1.0 + 1.0 / 5.0)).sqrt();
    assert!((squares[0].sqrt() / remaining - 1.0).abs() < 1e-12);
    let upper = (change * change + squares[1..].iter().sum::<f64>()).sqrt();
    assert!((result["certificate"]["upper"].as_f64().unwrap() / upper - 1.0).abs() < 1e-12);
    assert_error_map_matches(remaining, &folder, &result);
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
fn assert_error_map_matches(error: f64, folder: &TestFolder, result: &Value) {
    let map = folder.read_planes("out/error.exr");
    let lightmap = folder.read_planes("out/lightmap.exr");
    let radiosity = lightmap.colour_planes("").unwrap();
    let (mut off, mut light) = (0.0, [0.0; 3]);
    for face in result["faces"].as_array().unwrap() {
        let [x, y, w, h] = [0, 1, 2, 3].map(|k| face["rect"][k].as_u64().unwrap() as usize);
        let area = face["area"].as_f64().unwrap() / (w * h) as f64;
        for (i, j) in (0..w).flat_map(|i| (0..h).map(move |j| (x + i, y + j))) {
            let own = f64::from(map.channels["Y"][j * map.width + i]);
            assert!(own >= 0.0);
            off += area * own.powi(2);
            for (c, light) in light.iter_mut().enumerate() {
                let emission = face["emission"][c].as_f64().unwrap();
                let reflected = f64::from(radiosity[c][j * lightmap.width + i]) - emission;
                *light += area * reflected.powi(2);
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
    let folder = TestFolder::new();
    folder.succeed("solve scenes/cornell_box.obj --solver gpu --error 5% --texels 4");
    let result = folder.read_json("out/result.json");
    assert_eq!(result["solver"], "gpu");
    assert!(result["adapter"].is_string(), "{}", result["adapter"]);
    assert_eq!(result["settings"]["error"], 0.05);
    let error = result["estimated_error"].as_f64().unwrap();
    assert!(error > 0.0 && error <= 0.05, "{error}");
}

/// Commands, the error in their settings, and whether the solve chooses the texels.
const SETTINGS: [(&str, Option<f64>, bool); 4] = [
    ("solve", Some(0.01), true),
    ("solve --quality draft", Some(0.05), true),
    ("solve --texels 4", Some(0.01), false),
    ("shoot --patches 2 --texels 4", None, false),
];

#[test]
fn solve_solves_to_error_and_shoot_removes_its_error_map() {
    let folder = TestFolder::new();
    for (command, error, chosen) in SETTINGS {
        folder.succeed(&format!("{command} scenes/cornell_box.obj --solver cpu"));
        let result = folder.read_json("out/result.json");
        let settings = &result["settings"];
        assert_eq!(settings["error"], json!(error), "{command}");
        let faces = result["faces"].as_array().unwrap();
        let alike = faces.iter().all(|face| face["texels"][0] == faces[0]["texels"][0]);
        assert_eq!(alike, !chosen, "{command}");
        assert_eq!(settings["texels"].is_null(), chosen, "{settings}");
        assert_eq!(folder.has("out/error.exr"), error.is_some(), "{command}");
    }
    assert_eq!(folder.read_json("out/result.json")["settings"]["cells"], 2);
}
